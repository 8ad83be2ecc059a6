//! The page of an edit: before and after to play, the latent curves (thesis Figs. 3.8, A.1, A.2), joints over time.

use lifelike_motion::MotionClip;
use lifelike_report::{Cell, Column, Curve, Drawing, Panel, Playback, ReportBuilder, Table};
use lifelike_representation::motion_spline::{MotionSpline, SplinedClip};

use super::Row;
use crate::commands::motion::direct::Stage;
use crate::error::CliError;

/// Numbers of the latent space that are drawn, those with the most motion first.
const DRAWN: usize = 8;
/// Places of a curve.
const SAMPLES: usize = 40;

/// The page. Curves and clips are before and after.
pub fn report(
    stage: &Stage,
    model: &MotionSpline,
    curves: [&SplinedClip; 2],
    clips: [&MotionClip; 2],
    rows: &[Row],
) -> Result<ReportBuilder, CliError> {
    let character = &stage.robot.character;
    let playback = Playback::before_and_after(character, clips[0], clips[1])?;
    let page = ReportBuilder::new(clips[1].name.as_str())
        .subtitle("Motion changed by the control points of its latent curves.")
        .fact("segments", curves[0].segments().len().to_string())
        .fact("control points of a segment", model.control_points().to_string())
        .fact("numbers of a control point", model.latent().to_string())
        .playback(character, &[playback])
        .table(summary(rows))
        .drawing(latent(model, curves)?)
        .curves(joints(clips));
    Ok(page)
}

fn summary(rows: &[Row]) -> Table {
    let columns = [
        ("length", "s"),
        ("path", "m"),
        ("change of joints", "deg"),
        ("velocity", "rad/s"),
        ("acceleration", "rad/s²"),
        ("skate", "cm/s"),
        ("in contact", "%"),
    ];
    let head = [Column::text("motion")].into_iter().chain(columns.map(|(name, unit)| Column::number(name, unit)));
    let mut table = Table::new("Before and after", head.collect());
    for row in rows {
        table.rows.push(vec![
            Cell::text(row.motion.clone()),
            Cell::number(row.seconds, 2),
            Cell::number(row.path_m, 2),
            Cell::number(row.change_deg, 2),
            Cell::number(row.velocity, 3),
            Cell::number(row.acceleration, 1),
            Cell::number(100.0 * row.footing.skate, 1),
            Cell::number(100.0 * row.footing.bearing, 0),
        ]);
    }
    table.caption = "Change: root mean square against the first row; velocity and acceleration: root mean square over joints. Skate: how fast feet move that stand. In contact: share of time in \
                     which a foot stands."
        .into();
    table
}

/// A number of the latent space over time: curves of all segments, and their control points.
fn latent(model: &MotionSpline, curves: [&SplinedClip; 2]) -> Result<Drawing, CliError> {
    let length = (model.plan().frames - 1) as f64 / model.plan().frame_rate;
    let sampled = |clip: &SplinedClip| -> Result<Vec<Vec<Vec<f32>>>, CliError> {
        Ok(clip.segments().iter().map(|segment| segment.curve(model, SAMPLES)).collect::<Result<_, _>>()?)
    };
    let all = [sampled(curves[0])?, sampled(curves[1])?];
    let values = |k: usize| all.iter().flatten().flatten().map(move |row| row[k]);
    let spread = |k: usize| values(k).fold(f32::MIN, f32::max) - values(k).fold(f32::MAX, f32::min);
    let mut numbers: Vec<usize> = (0..model.latent()).collect();
    numbers.sort_by(|a, b| spread(*b).total_cmp(&spread(*a)));
    numbers.truncate(DRAWN);
    let end = curves[0].segments().last().map_or(length, |s| s.start + length);
    let panels = numbers.into_iter().map(|k| {
        // Panels have one scale: the clip's time is as wide as the numbers are high.
        let height = spread(k).max(1e-3);
        let x = |seconds: f64| (seconds / end) as f32 * height;
        let lines = |which: usize| -> Vec<Vec<[f32; 2]>> {
            let segments = curves[which].segments().iter().zip(&all[which]);
            segments
                .flat_map(|(segment, curve)| {
                    let at = |i: usize, of: usize| x(segment.start + length * i as f64 / (of - 1).max(1) as f64);
                    let line = curve.iter().enumerate().map(|(i, row)| [at(i, SAMPLES), row[k]]).collect();
                    let points = &segment.control_points;
                    let crosses = points
                        .iter()
                        .enumerate()
                        .flat_map(move |(i, p)| cross([at(i, points.len()), p[k]], 0.015 * height));
                    [line].into_iter().chain(crosses).collect::<Vec<_>>()
                })
                .collect()
        };
        let (name, note) = (format!("number {k}"), format!("{height:.2} high"));
        Panel { name, note, reference: lines(0), lines: lines(1), ..Panel::default() }
    });
    Ok(Drawing {
        title: "Latent curves".into(),
        caption: format!(
            "The {DRAWN} numbers of the latent space that change most, over the clip's {end:.1} s. Behind, before; in front, after. \
             Crosses are control points, a third of a segment apart; a curve passes through the first and the last."
        ),
        panels: panels.collect(),
        ..Drawing::default()
    })
}

fn cross([x, y]: [f32; 2], arm: f32) -> [Vec<[f32; 2]>; 2] {
    [vec![[x - arm, y], [x + arm, y]], vec![[x, y - arm], [x, y + arm]]]
}

/// The joints that change most, over time.
fn joints([before, after]: [&MotionClip; 2]) -> Vec<Curve> {
    let column = |clip: &MotionClip, name: &str| -> Vec<f64> {
        let Some(at) = clip.joint_names.iter().position(|own| own == name) else { return Vec::new() };
        (0..clip.len()).map(|f| clip.joints_at(f)[at].to_degrees()).collect()
    };
    let change = |name: &str| -> f64 {
        column(before, name).iter().zip(column(after, name)).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let mut names: Vec<&String> = before.joint_names.iter().collect();
    names.sort_by(|a, b| change(b).total_cmp(&change(a)));
    let of = |name: &str, which: &str, clip: &MotionClip| Curve {
        name: format!("joints over time (s)/{name} (deg)"),
        series: which.into(),
        x: (0..clip.len()).map(|f| f as f64 / clip.fps).collect(),
        y: column(clip, name),
    };
    names.into_iter().take(6).flat_map(|name| [of(name, "before", before), of(name, "after", after)]).collect()
}
