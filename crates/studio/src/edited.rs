//! A block's own clip after its edits: part, style, control points, points of the body, repair, speed, repetition.

use lifelike_evaluation::verdict::finding_words;
use lifelike_motion::edit::{
    Amplify, Around, Key, Part, Warp, amplify, mirror, place, repair, sequence, settle, smooth, trim, warp,
};
use lifelike_motion::{MotionClip, MotionError};
use lifelike_representation::motion_spline::{MotionSpline, Playing, SplinedClip};
use lifelike_robot::{Robot, clips};

use crate::StudioError;
use crate::edits::PointGain;
use crate::scene::Block;

/// Time that neighbours share where nothing else is said (s).
pub(crate) const FADE: f64 = 0.3;

/// Returns a block's motion after its edits, and the changes that a repair made, in words.
///
/// # Errors
/// An edit that does not fit the robot; control points without a motion spline.
pub(crate) fn edited(
    whole: &MotionClip,
    block: &Block,
    robot: &Robot,
    spline: Option<&MotionSpline>,
) -> Result<(MotionClip, String), StudioError> {
    let (character, anatomy) = (&robot.character, &robot.anatomy);
    let mut options = clips::retarget_options(robot);
    clips::limit_speeds(&mut options, robot);
    let start = block.start.unwrap_or(0.0);
    let mut clip = trim(whole, block.start, block.end.map(|end| end.min(whole.seconds())))?;
    if block.mirror {
        clip = mirror(&clip, character)?;
    }
    if let Some(cutoff) = block.smooth {
        clip = smooth(&clip, character, anatomy, &clip.joint_names.clone(), cutoff, &options)?;
    }
    if let Some(gain) = block.gain {
        let style = Amplify { joints: clip.joint_names.clone(), gain, around: Around::Mean };
        clip = amplify(&clip, character, anatomy, &style, &options)?;
    }
    if !block.points.is_empty() {
        let Some(model) = spline else {
            let message = format!("no motion spline for '{}' comes with the program", robot.name);
            return Err(StudioError::Operation(message));
        };
        let bent = bent(model, &clip, &block.points, start);
        let bent = bent.map_err(|error| StudioError::Operation(error.to_string()))?;
        clip = settle(&clip, bent, character, anatomy, &options)?;
    }
    let there = block.edits.iter().map(|edit| (edit, edit.at - start));
    let there = there.filter(|(_, at)| (0.0..=clip.seconds()).contains(at));
    let keys: Vec<Key> = there.map(|(edit, at)| edit.key(&clip, at)).collect();
    if !keys.is_empty() {
        clip = place(&clip, character, anatomy, &keys, &options)?.0;
    }
    let mut changed = String::new();
    if block.feasible {
        let (repaired, report) = repair(&clip, character, anatomy, &robot.speeds(), &options)?;
        let change = &report.change;
        let still = report.after.reasons().next().map(|finding| format!("; still: {}", finding_words(finding)));
        changed = match repaired == clip {
            true => "nothing had to be repaired".into(),
            false => format!(
                "repaired: root by {:.1} cm, feet by {:.1} cm, legs by {:.1} deg, others by {:.1} deg, {:.2} s longer{}",
                100.0 * change.root.mean,
                100.0 * change.feet.mean,
                change.legs.mean.to_degrees(),
                change.others.mean.to_degrees(),
                change.longer,
                still.unwrap_or_default()
            ),
        };
        clip = repaired;
    }
    if let Some(speed) = block.speed {
        clip = warp(&clip, &Warp::Speed(speed))?;
    }
    clip = repeated(clip, block)?;
    clip.provenance.source.clone_from(&whole.provenance.source);
    Ok((clip, changed))
}

fn repeated(clip: MotionClip, block: &Block) -> Result<MotionClip, MotionError> {
    let Some(times) = block.repeat.filter(|times| *times > 1) else { return Ok(clip) };
    let fade = if clip.cyclic { 0.0 } else { fading(FADE, clip.len(), clip.len(), clip.fps) };
    sequence(&vec![Part::from(&clip); times], fade)
}

/// Returns the clip with control points moved away from, or towards, where they lie on average.
fn bent(
    model: &MotionSpline,
    clip: &MotionClip,
    points: &[PointGain],
    start: f64,
) -> Result<MotionClip, lifelike_representation::RepresentationError> {
    let mut splined = SplinedClip::encode(model, clip)?;
    let mut segments = splined.segments().to_vec();
    let last = model.control_points() - 1;
    for point in points {
        let at = point.at - start;
        let time = |segment: f64, k: usize| segment + model.spacing() * k as f64;
        let all = segments.iter().enumerate().flat_map(|(s, segment)| (1..last).map(move |k| (s, k, segment.start)));
        let far = |one: &(usize, usize, f64)| (time(one.2, one.1) - at).abs();
        let Some((s, k, _)) = all.min_by(|a, b| far(a).total_cmp(&far(b))) else { continue };
        let mean = &model.usual().mean[k];
        let numbers = segments[s].control_points[k].iter_mut().zip(mean);
        numbers.for_each(|(number, mean)| *number = mean + point.gain as f32 * (*number - mean));
    }
    splined.set_segments(segments)?;
    splined.play(model, &Playing { fps: clip.fps, speed: 1.0, detail: true })
}

/// Returns the fade that fits between neighbours of these lengths (s).
pub(crate) fn fading(fade: f64, before: usize, next: usize, fps: f64) -> f64 {
    let most = before.min(next).saturating_sub(2) as f64 / fps;
    fade.min(most).max(0.0)
}
