//! `lifelike-thesis control-points`: what latent control points say of curves (thesis A.1, Figs. A.1 and A.2).

use std::path::{Path, PathBuf};

use crate::sequences::{CurveSequences, CurvesPlan};
use lifelike_checkpoint::Checkpoint;
use lifelike_generation::critic::calibration::spearman;
use lifelike_report::run::RunFolder;
use lifelike_report::{Cell, Column as Head, Drawing, Panel, ReportBuilder, Table};
use lifelike_representation::spline_transformer::{HeldOut, Method, SequenceTrainer, Sequences};
use serde::Serialize;
use serde_json::json;

use lifelike::CliError;
use lifelike::Output;

/// Compare curves with their latent control points, and move one control point (thesis Figs. A.1 and A.2).
///
/// Runs are folders of `lifelike-thesis curves`. Unseen curves are encoded. The table reports two rank correlations: of
/// distances between curves and between their control points, and of the curvedness of both. For runs of the spline, C2
/// is also moved to C1 in steps and decoded. The folder gets control-points.json and report.html.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis control-points runs/hypotrochoids/hypotrochoids-spline-warmup-200-0 -o runs/a1
  # baselines beside it
  lifelike-thesis control-points runs/hypotrochoids/*-0 --curves 1000 -o runs/a1")]
pub struct Args {
    /// Folders of finished runs of `curves`.
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Unseen curves, at least 8.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(8..=10_000))]
    curves: u64,
    /// Folder of the results.
    #[arg(short, long, value_parser = lifelike::destination::folder)]
    output: PathBuf,
}

/// Numbers of one run.
#[derive(Debug, Serialize)]
struct Study {
    run: String,
    family: String,
    method: Method,
    /// Numbers that are kept of a curve.
    numbers: usize,
    curves: usize,
    #[serde(flatten)]
    likeness: Likeness,
    /// Steps of C2 to C1; only of splines.
    moved: Vec<Moved>,
}

/// Relation of curves and control points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Likeness {
    /// Spearman's rank correlation of distances between curves and between their control points, over all pairs.
    distances: f64,
    /// Share of the other curves that are nearer to a curve than the one with the nearest control points; 0.5 by chance.
    nearest: f64,
    /// Rank correlation of how curved a curve and its latent control polygon are; NaN for one control point.
    bends: f64,
}

/// C2 moved some share of the way to C1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Moved {
    share: f64,
    /// Root mean square distance of the decoded curve's points from the unmoved ones, over all curves.
    change: f64,
}

const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Queries and moved curves that are drawn.
const DRAWN: usize = 3;

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let (mut studies, mut drawings) = (Vec::new(), Vec::new());
    for path in &args.runs {
        let (study, own) = study(path, args.curves as usize)?;
        studies.push(study);
        drawings.extend(own);
    }
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let (value, file) = (json!({ "runs": studies }), args.output.join("control-points.json"));
    lifelike::output::write_json(&file, &value)?;
    let table = table(&studies);
    let text = format!("{}\n{}\n", table.to_text(), table.caption);
    let page = ReportBuilder::new("Control points of curves").subtitle("Thesis Figs. A.1 and A.2.").table(table);
    let report = args.output.join("report.html");
    drawings.into_iter().fold(page, ReportBuilder::drawing).write(&report)?;
    output.result(&value, || format!("{text}report: {}\n", report.display()))
}

fn study(path: &Path, count: usize) -> Result<(Study, Vec<Drawing>), CliError> {
    let folder = RunFolder::open(path)?;
    let plan: CurvesPlan = folder.plan()?;
    let data = CurveSequences::new(&plan)?;
    let checkpoints = folder.checkpoints(1);
    let Some((info, bytes)) = checkpoints.latest() else {
        return Err(CliError::Input(format!("{}: expected a run with a checkpoint, got none", path.display())));
    };
    let mut trainer = SequenceTrainer::new(plan.training.clone(), data)?;
    trainer.restore(&Checkpoint::from_bytes(&bytes, &checkpoints.path(info.iteration))?)?;
    let count = count.min(trainer.data().held_out_len(HeldOut::Test));
    let x = trainer.data().held_out(HeldOut::Test, 0..count);
    let (points, _) = trainer.reconstruct(&x)?;
    let (latent, method) = (plan.training.latent, plan.training.method);
    let space = Space { curves: &x, curve: 2 * plan.samples, points: &points, latent, kept: points.len() / count };
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut drawings = vec![space.likeness_drawing(&name)];
    let mut moved = Vec::new();
    if method == Method::Spline {
        let decoded = SHARES.map(|share| trainer.decode(&space.moved(share)));
        let [unmoved, ..] = &decoded;
        let unmoved = unmoved.as_ref().map_err(|e| CliError::Failed(e.to_string()))?;
        for (share, decoded) in SHARES.iter().zip(&decoded) {
            let decoded = decoded.as_ref().map_err(|e| CliError::Failed(e.to_string()))?;
            // Of a point, not of a coordinate.
            moved.push(Moved { share: *share, change: 2.0_f64.sqrt() * distance(decoded, unmoved) });
        }
        let decoded: Vec<&Vec<f32>> = decoded.iter().flatten().collect();
        drawings.push(space.moved_drawing(&name, &decoded));
    }
    let (family, numbers) = (plan.family.title().into(), space.kept);
    Ok((Study { run: name, family, method, numbers, curves: count, likeness: space.likeness(), moved }, drawings))
}

/// Curves and their control points.
struct Space<'a> {
    curves: &'a [f32],
    /// Numbers of a curve.
    curve: usize,
    points: &'a [f32],
    /// Numbers of a control point.
    latent: usize,
    /// Numbers of a curve's control points.
    kept: usize,
}

impl Space<'_> {
    fn curve(&self, i: usize) -> &[f32] {
        &self.curves[i * self.curve..][..self.curve]
    }

    fn kept(&self, i: usize) -> &[f32] {
        &self.points[i * self.kept..][..self.kept]
    }

    fn len(&self) -> usize {
        self.curves.len() / self.curve
    }

    fn likeness(&self) -> Likeness {
        let count = self.len();
        let pairs = || (0..count).flat_map(|i| (0..i).map(move |k| (i, k)));
        let of_curves: Vec<f64> = pairs().map(|(i, k)| distance(self.curve(i), self.curve(k))).collect();
        let of_points: Vec<f64> = pairs().map(|(i, k)| distance(self.kept(i), self.kept(k))).collect();
        let nearest = (0..count).map(|i| self.nearer_share(i, self.nearest(i))).sum::<f64>() / count.max(1) as f64;
        let bends = match self.kept > self.latent {
            true => {
                let of = |rows: &[f32], width: usize| bend(rows, width);
                let curves: Vec<f64> = (0..count).map(|i| of(self.curve(i), 2)).collect();
                let points: Vec<f64> = (0..count).map(|i| of(self.kept(i), self.latent)).collect();
                spearman(&curves, &points)
            }
            false => f64::NAN,
        };
        Likeness { distances: spearman(&of_curves, &of_points), nearest, bends }
    }

    /// The curve whose control points are nearest to those of curve `i`.
    fn nearest(&self, i: usize) -> usize {
        let others = (0..self.len()).filter(|k| *k != i);
        let by = |a: &usize, b: &usize| {
            distance(self.kept(i), self.kept(*a)).total_cmp(&distance(self.kept(i), self.kept(*b)))
        };
        others.min_by(by).unwrap_or(i)
    }

    /// The curve whose control points are furthest from those of curve `i`.
    fn furthest(&self, i: usize) -> usize {
        let by = |a: &usize, b: &usize| {
            distance(self.kept(i), self.kept(*a)).total_cmp(&distance(self.kept(i), self.kept(*b)))
        };
        (0..self.len()).max_by(by).unwrap_or(i)
    }

    /// Share of the other curves that are nearer to curve `i` than curve `k` is.
    fn nearer_share(&self, i: usize, k: usize) -> f64 {
        let own = distance(self.curve(i), self.curve(k));
        let nearer = (0..self.len()).filter(|j| *j != i && *j != k);
        let nearer = nearer.filter(|j| distance(self.curve(i), self.curve(*j)) < own).count();
        nearer as f64 / self.len().saturating_sub(2).max(1) as f64
    }

    /// All control points, with C2 moved a share of the way to C1.
    fn moved(&self, share: f64) -> Vec<f32> {
        let mut points = self.points.to_vec();
        for own in points.chunks_exact_mut(self.kept) {
            let (before, third) = own.split_at_mut(2 * self.latent);
            let second = &before[self.latent..];
            third.iter_mut().zip(second).take(self.latent).for_each(|(x, to)| *x += share as f32 * (to - *x));
        }
        points
    }

    /// The two latent numbers that differ most over all control points: what is drawn.
    fn axes(&self) -> [usize; 2] {
        let variance = |axis: usize| {
            let own: Vec<f64> = self.points.iter().skip(axis).step_by(self.latent).map(|x| f64::from(*x)).collect();
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            own.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
        };
        let mut axes: Vec<usize> = (0..self.latent).collect();
        axes.sort_by(|a, b| variance(*b).total_cmp(&variance(*a)));
        [axes[0], axes.get(1).copied().unwrap_or(axes[0])]
    }

    /// The latent trajectory along two numbers, and behind it the control polygon.
    fn trajectory(&self, points: &[f32], name: String) -> Panel {
        let axes = self.axes();
        let polygon: Vec<[f32; 2]> = points.chunks_exact(self.latent).map(|own| axes.map(|axis| own[axis])).collect();
        let line = match polygon[..] {
            [a, b, c, d] => (0..=60).map(|i| bezier([a, b, c, d], i as f32 / 60.0)).collect(),
            _ => polygon.clone(),
        };
        Panel { name, reference: vec![polygon], lines: vec![line], ..Panel::default() }
    }

    /// Fig. A.1: queries, the curve of the nearest and that of the furthest control points, each with its latent trajectory below.
    fn likeness_drawing(&self, run: &str) -> Drawing {
        let mut panels = Vec::new();
        for query in (0..DRAWN).map(|i| i * self.len() / DRAWN) {
            let shown = [("curve", query), ("nearest", self.nearest(query)), ("furthest", self.furthest(query))];
            panels.extend(shown.map(|(name, i)| Panel {
                name: name.into(),
                lines: vec![self.curve(i).as_chunks::<2>().0.to_vec()],
                ..Panel::default()
            }));
            panels.extend(shown.map(|(_, i)| self.trajectory(self.kept(i), "latent".into())));
        }
        Drawing {
            title: format!("{run}: curves and their control points (Fig. A.1)"),
            caption: "A curve, the one whose control points are nearest, and the one whose control points are furthest; below each its \
                      latent trajectory along the two latent numbers that differ most, the control polygon behind it."
                .into(),
            panels,
            across: 3,
        }
    }

    /// Fig. A.2: decoded curves while C2 moves to C1, each with its latent trajectory below.
    fn moved_drawing(&self, run: &str, decoded: &[&Vec<f32>]) -> Drawing {
        let mut panels = Vec::new();
        for i in (0..DRAWN).map(|i| i * self.len() / DRAWN) {
            for (share, all) in SHARES.iter().zip(decoded) {
                panels.push(Panel {
                    name: format!("{:.0}%", 100.0 * share),
                    reference: vec![self.curve(i).as_chunks::<2>().0.to_vec()],
                    lines: vec![all[i * self.curve..][..self.curve].as_chunks::<2>().0.to_vec()],
                    ..Panel::default()
                });
            }
            for share in SHARES {
                let points = self.moved(share);
                panels.push(self.trajectory(&points[i * self.kept..][..self.kept], "latent".into()));
            }
        }
        Drawing {
            title: format!("{run}: C2 moved to C1 (Fig. A.2)"),
            caption: "C2 moved by a share of the way to C1: the decoded curve before the original, and its latent trajectory below.".into(),
            panels,
            across: SHARES.len(),
        }
    }
}

/// Root mean square difference.
fn distance(a: &[f32], b: &[f32]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

/// Curvedness of a polyline of points of `width` numbers, whatever its size: squared second differences over squared first ones.
fn bend(points: &[f32], width: usize) -> f64 {
    let squared = |numbers: &mut dyn Iterator<Item = f32>| numbers.map(|x| f64::from(x).powi(2)).sum::<f64>();
    let first = squared(&mut points[width..].iter().zip(points).map(|(a, b)| a - b));
    let ahead = points[(2 * width).min(points.len())..].iter().zip(&points[width..]);
    let second = squared(&mut ahead.zip(points).map(|((c, b), a)| c - 2.0 * b + a));
    second / first.max(1e-12)
}

/// Thesis Algorithm 3 in the plane.
fn bezier([a, b, c, d]: [[f32; 2]; 4], t: f32) -> [f32; 2] {
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    [0, 1].map(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k] + weights[3] * d[k])
}

fn table(studies: &[Study]) -> Table {
    let heads = ["run", "family", "method"].map(Head::text).into_iter();
    let numbers = ["numbers", "curves", "distances", "nearer than nearest", "bends", "change at 100%"];
    let mut table = Table::new(
        "Curves and control points (Figs. A.1, A.2)",
        heads.chain(numbers.map(|name| Head::number(name, ""))).collect(),
    );
    for own in studies {
        let Likeness { distances, nearest, bends } = own.likeness;
        let mut row = vec![
            Cell::text(own.run.clone()),
            Cell::text(own.family.clone()),
            Cell::text(own.method.title()),
            Cell::number(own.numbers as f64, 0),
            Cell::number(own.curves as f64, 0),
        ];
        let change = own.moved.last().map_or(f64::NAN, |last| last.change);
        row.extend([distances, nearest, bends, change].map(|x| Cell::number(x, 3)));
        table.rows.push(row);
    }
    table.caption = "Distances: rank correlation of distances between curves and between their control points, over all pairs. Nearer than \
                     nearest: share of the other curves that are nearer than the one with the nearest control points (0.5 by chance). Bends: \
                     rank correlation of how curved curves and latent control polygons are. Change: root mean square distance of a decoded \
                     point from its own when C2 is moved to C1."
        .into();
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four straight "curves" of three points on a ray: 0, 1, 2 and 10 long; control points by hand.
    fn space<'a>(curves: &'a [f32], points: &'a [f32]) -> Space<'a> {
        Space { curves, curve: 6, points, latent: 1, kept: 4 }
    }

    fn rays() -> Vec<f32> {
        [0.0, 1.0, 2.0, 10.0].iter().flat_map(|l| [0.0, 0.0, 0.5 * l, 0.0, *l, 0.0]).collect()
    }

    #[test]
    fn likeness_by_hand() {
        let curves = rays();
        // Control points at distances of the same order, and in another order.
        let alike: Vec<f32> = [0.0, 2.0, 4.0, 20.0].iter().flat_map(|x| [*x; 4]).collect();
        let own = space(&curves, &alike);
        let Likeness { distances, nearest, .. } = own.likeness();
        assert!((distances - 1.0).abs() < 1e-12, "{distances}");
        assert_eq!(nearest, 0.0, "the nearest control points are those of the nearest curve");
        assert_eq!((own.nearest(0), own.furthest(0), own.nearest(3)), (1, 3, 2));
        let other: Vec<f32> = [0.0, 20.0, 4.0, 2.0].iter().flat_map(|x| [*x; 4]).collect();
        let own = space(&curves, &other);
        // Nearest control points: 0 -> 3 (two curves nearer), 1 -> 2 (none: 0 is as far), 2 -> 3 (two), 3 -> 0 or 2: 2 by the first least.
        assert_eq!([0, 1, 2].map(|i| own.nearest(i)), [3, 2, 3]);
        assert_eq!([own.nearer_share(0, 3), own.nearer_share(1, 2)], [1.0, 0.0]);
        assert!(own.likeness().distances < 0.5);
    }

    #[test]
    fn c2_moves_to_c1_and_bends_are_those_of_second_differences() {
        let points = [1.0, 2.0, 6.0, 7.0];
        let curves = [0.0; 6];
        let own = Space { curves: &curves, curve: 6, points: &points, latent: 1, kept: 4 };
        assert_eq!(own.moved(0.0), points);
        assert_eq!(own.moved(0.25), [1.0, 2.0, 5.0, 7.0]);
        assert_eq!(own.moved(1.0), [1.0, 2.0, 2.0, 7.0]);
        // First differences 1, 4, 1; second 3, -3.
        assert!((bend(&points, 1) - 18.0 / 18.0).abs() < 1e-12);
        assert_eq!(bend(&[0.0, 0.0, 1.0, 2.0, 2.0, 4.0], 2), 0.0);
        // The middle of a Bézier: (a + 3 b + 3 c + d) / 8.
        assert_eq!(bezier([[0.0, 8.0], [8.0, 0.0], [8.0, 0.0], [0.0, 8.0]], 0.5), [6.0, 2.0]);
    }
}
