//! Blocks to one motion: clips and sentences, edited, one after the other, with parts of others laid over them.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::verdict::finding_words;
use lifelike_generation::generator::{Generator, Given, SampleOptions};
use lifelike_generation::representation::FeatureMatrix;
use lifelike_motion::edit::{Compose, Length, Part, compose, joints_of, sequence, trim};
use lifelike_motion::resample::resample;
use lifelike_motion::{MotionClip, feasibility, formats};
use lifelike_representation::motion_spline::MotionSpline;
use lifelike_robot::reference::standing_clip;
use lifelike_robot::{Robot, clips};
use serde::Serialize;

use crate::edited::{FADE, edited, fading};
use crate::scene::{Block, Scene};
use crate::sentence::Understood;
use crate::{FromInput, StudioError};

/// A sentence goes on from the last seconds of the motion before it (s).
pub(crate) const OVERLAP: f64 = 0.6;
/// The robot stands for this long at the end (s).
pub(crate) const STAND: f64 = 1.6;
/// Made motion that is kept for the next build; beyond it, all of it is forgotten.
const MAX_KEPT: usize = 2000;

/// Place and verdict of a block.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Span {
    /// The block.
    pub id: String,
    /// Start in the scene (s).
    pub from: f64,
    /// End in the scene (s).
    pub to: f64,
    /// Time shared with the block before (s).
    pub fade: f64,
    /// Start within the block's own clip (s).
    pub start: f64,
    /// Duration of the block's own clip before its edits (s).
    pub whole: f64,
    /// Origin of the motion, such as the layout of its file.
    pub source: String,
    /// Reason for which the motion cannot be tracked, without physics; empty where there is none.
    pub doubt: String,
    /// Changes that a repair made; empty where there was none.
    pub changed: String,
}

/// The motion of a scene.
#[derive(Debug, Clone)]
pub struct Built {
    /// All blocks, and a stand at the end.
    pub clip: MotionClip,
    /// Place of every block.
    pub spans: Vec<Span>,
}

/// One block's motion before and after its edits.
#[derive(Debug, Clone)]
struct Made {
    clip: MotionClip,
    whole: f64,
    doubt: String,
    changed: String,
    /// Time shared with the block before (s).
    fade: f64,
}

/// Motion before a block's edits, whether it begins with the end of the motion before it, and an error of the network.
type Whole = (MotionClip, bool, Option<String>);

/// Maker of motion for one robot, with a memory of what it made.
pub struct Workshop {
    robot: Arc<Robot>,
    generator: Option<Arc<Generator>>,
    spline: Option<Arc<MotionSpline>>,
    folder: PathBuf,
    made: HashMap<u64, Made>,
}

impl Workshop {
    /// Returns a workshop that reads clips below a folder only.
    pub fn new(
        robot: Arc<Robot>,
        generator: Option<Arc<Generator>>,
        spline: Option<Arc<MotionSpline>>,
        folder: PathBuf,
    ) -> Self {
        Self { robot, generator, spline, folder, made: HashMap::new() }
    }

    /// Makes the motion of a scene, at the policy's rate.
    ///
    /// # Errors
    /// [`StudioError::Block`] with the block whose motion cannot be made, and the reason.
    pub fn build(&mut self, scene: &Scene) -> Result<Built, StudioError> {
        if self.made.len() > MAX_KEPT {
            self.made.clear();
        }
        let fps = self.robot.control_hz;
        let mut out: Option<MotionClip> = None;
        let mut last = 0;
        let mut spans = Vec::with_capacity(scene.motion.len() + scene.over.len());
        for block in &scene.motion {
            if let Some(seconds) = block.wait.filter(|seconds| *seconds > 0.0) {
                let stand = standing_clip(&self.robot, seconds);
                match &mut out {
                    None => out = Some(stand.clone()),
                    Some(before) => append(before, last, &stand, fading(OVERLAP, last, stand.len(), fps))?,
                }
                last = stand.len();
            }
            let made = self.block(block, scene.seed, out.as_ref())?;
            let next = made.clip.len();
            let from = match &mut out {
                None => {
                    out = Some(made.clip.clone());
                    0.0
                }
                Some(before) => {
                    let fade = fading(made.fade, last, next, fps);
                    let seam = before.seconds() - fade / 2.0;
                    append(before, last, &made.clip, fade).map_err(StudioError::block(&block.id))?;
                    seam
                }
            };
            last = next;
            if let Some(span) = spans.last_mut() {
                let span: &mut Span = span;
                span.to = from;
            }
            let to = out.as_ref().map_or(0.0, MotionClip::seconds);
            spans.push(span(block, from, to, &made));
        }
        let stand = standing_clip(&self.robot, STAND);
        let mut clip = match out {
            None => stand,
            Some(mut before) => {
                append(&mut before, last, &stand, fading(OVERLAP, last, stand.len(), fps))?;
                before
            }
        };
        for block in &scene.over {
            let made = self.block(block, scene.seed, None)?;
            let at = block.at.unwrap_or(0.0);
            clip = self.laid_over(&clip, block, &made, at).map_err(StudioError::block(&block.id))?;
            spans.push(span(block, at, at + made.clip.seconds(), &made));
        }
        clip.name = "scene".into();
        clip.cyclic = false;
        Ok(Built { clip, spans })
    }

    fn laid_over(
        &self,
        clip: &MotionClip,
        block: &Block,
        made: &Made,
        at: f64,
    ) -> Result<MotionClip, lifelike_motion::MotionError> {
        let joints = joints_of(&self.robot.character, &self.robot.anatomy, &block.parts)?;
        let fade = block.fade.unwrap_or(FADE).min(made.clip.seconds() / 2.0);
        compose(clip, &made.clip, &Compose { joints, offset: at, length: Length::Return, fade })
    }

    /// Returns a block's motion, from memory where neither it nor what it goes on from has changed.
    fn block(&mut self, block: &Block, seed: u64, before: Option<&MotionClip>) -> Result<Made, StudioError> {
        let tail = before.filter(|before| block.sentence.is_some() && before.seconds() >= OVERLAP);
        let tail = tail.map(|before| trim(before, Some(before.seconds() - OVERLAP), None)).transpose()?;
        let mut key = DefaultHasher::new();
        // Name and place decide nothing.
        let same = Block { id: String::new(), at: None, wait: None, parts: Vec::new(), ..block.clone() };
        format!("{same:?} {seed}").hash(&mut key);
        if let Some(clip) = &block.clip
            && let Ok(modified) = std::fs::metadata(self.folder.join(clip)).and_then(|file| file.modified())
        {
            modified.hash(&mut key);
        }
        if let Some(tail) = &tail {
            let places = tail.root_position.iter().flat_map(|p| [p.x, p.y, p.z]);
            places.chain(tail.joints.iter().copied()).for_each(|value| value.to_bits().hash(&mut key));
        }
        let key = key.finish();
        if let Some(made) = self.made.get(&key) {
            return Ok(made.clone());
        }
        let made = self.make(block, seed, tail.as_ref())?;
        self.made.insert(key, made.clone());
        Ok(made)
    }

    fn make(&self, block: &Block, seed: u64, tail: Option<&MotionClip>) -> Result<Made, StudioError> {
        let told = || StudioError::block::<StudioError>(&block.id);
        let (whole, continues, failed) = match (&block.sentence, &block.clip) {
            (Some(sentence), _) => self.said(block, sentence, seed, tail).map_err(told())?,
            (None, Some(clip)) => (self.loaded(clip).map_err(told())?, false, None),
            (None, None) => return Err(StudioError::Operation(format!("block '{}' has no motion", block.id))),
        };
        let (clip, changed) =
            edited(&whole, block, &self.robot, self.spline.as_deref()).map_err(StudioError::block(&block.id))?;
        let found = feasibility::check(&clip, &self.robot.character, &self.robot.anatomy, &self.robot.speeds()).ok();
        let doubt = found.and_then(|found| found.reasons().next().map(finding_words));
        let doubt = failed.into_iter().chain(doubt).collect::<Vec<_>>().join("; ");
        let goes_on = continues && block.start.is_none_or(|start| start == 0.0) && block.speed.is_none();
        let fade = block.fade.unwrap_or(if goes_on && !block.mirror { OVERLAP } else { FADE });
        Ok(Made { clip, whole: whole.seconds(), doubt, changed, fade })
    }

    /// Returns the motion of a sentence: the network's, where it does what was understood, else that of the grammar's rules.
    fn said(&self, block: &Block, sentence: &str, seed: u64, tail: Option<&MotionClip>) -> Result<Whole, StudioError> {
        let understood = Understood::read(sentence, block.seconds, &self.robot)?;
        let is_learned = |one: &&Arc<Generator>| understood.as_ref().is_none_or(|u| u.was_learned(one, sentence));
        let generator = self.generator.as_ref().filter(is_learned);
        let learned = generator.map(|generator| self.learned(generator, block, sentence, seed, tail));
        let Some(understood) = understood else {
            let Some(learned) = learned else {
                let message = format!("no generator for '{}' comes with the program; use clips", self.robot.name);
                return Err(StudioError::Operation(message));
            };
            return Ok((learned?, tail.is_some(), None));
        };
        let from = tail.map_or(0.0, MotionClip::seconds);
        let (learned, failed) = match learned {
            Some(Err(error)) => (None, Some(format!("the network failed ({error}), the rules made it"))),
            learned => (learned.and_then(Result::ok), None),
        };
        let (mut clip, continues, by) = match learned {
            Some(clip) if understood.holds(&clip, from)? => (clip, tail.is_some(), "network"),
            _ => (understood.by_rules(block.seed.unwrap_or(seed), &self.robot)?, false, "rules"),
        };
        clip.provenance.source = format!("{} (by {by})", understood.words());
        Ok((clip, continues, failed))
    }

    /// Returns the network's motion of a sentence. After other motion it begins with the last of it.
    fn learned(
        &self,
        generator: &Generator,
        block: &Block,
        sentence: &str,
        seed: u64,
        tail: Option<&MotionClip>,
    ) -> Result<MotionClip, StudioError> {
        let failed = |error: lifelike_generation::GenerationError| StudioError::Operation(error.to_string());
        let spec = &generator.header().spec;
        let rows = tail.map(|tail| FeatureMatrix::from_clip(tail, spec)).transpose().map_err(failed)?;
        let asked = block.seconds.unwrap_or_else(|| generator.seconds(sentence));
        let overlap = rows.as_ref().map_or(0.0, |rows| rows.n as f64 / spec.fps);
        let options = SampleOptions {
            seconds: Some((asked + overlap).min(generator.header().max_seconds)),
            seed: block.seed.unwrap_or(seed),
            candidates: block.best_of.unwrap_or(1),
            ..SampleOptions::default()
        };
        let given = rows.map(|rows| vec![Given::Beginning(rows); options.candidates]).unwrap_or_default();
        let all = generator.sample_given(sentence, &options, None, &given).map_err(failed)?;
        let clips = all.iter().map(|one| generator.clip(one, sentence, &self.robot));
        let clips = clips.collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let amiss = |clip: &MotionClip| {
            let robot = &self.robot;
            let found = feasibility::check(clip, &robot.character, &robot.anatomy, &robot.speeds());
            found.map_or(f64::INFINITY, |found| found.reasons().map(|finding| finding.seconds).sum())
        };
        let best = match clips.len() {
            1 => clips.into_iter().next(),
            _ => clips.into_iter().min_by(|a, b| amiss(a).total_cmp(&amiss(b))),
        };
        best.ok_or_else(|| StudioError::Operation("expected a motion of the sentence, got none".into()))
    }

    /// Returns the motion of a clip: our own, or a file below the folder.
    fn loaded(&self, clip: &str) -> Result<MotionClip, StudioError> {
        let path = PathBuf::from(clip);
        let path = if clips::is_builtin(&path) { path } else { inside(&self.folder, &path)? };
        let mut clip = resample(&clips::load_one(&path, &self.robot)?, self.robot.control_hz)?;
        if let Some(format) = formats::of_file(&path) {
            clip.provenance.source = format!("{}: {}", format.name, clip.provenance.source);
        }
        Ok(clip)
    }
}

fn span(block: &Block, from: f64, to: f64, made: &Made) -> Span {
    let source = match &block.sentence {
        Some(_) => made.clip.provenance.source.clone(),
        None => format!("{}, {:.2} s", made.clip.provenance.source, made.whole),
    };
    Span {
        id: block.id.clone(),
        from,
        to,
        fade: made.fade,
        start: block.start.unwrap_or(0.0),
        whole: made.whole,
        source,
        doubt: made.doubt.clone(),
        changed: made.changed.clone(),
    }
}

/// Appends a clip. Only the last `last` frames take part, so that many blocks cost no more than their frames.
fn append(
    before: &mut MotionClip,
    last: usize,
    next: &MotionClip,
    fade: f64,
) -> Result<(), lifelike_motion::MotionError> {
    let keep = before.len() - last.clamp(1, before.len());
    let end = trim(before, Some(keep as f64 / before.fps), None)?;
    let joined = sequence(&[Part::from(&end), Part::from(next)], fade)?;
    let keep = before.len() - end.len();
    before.root_position.truncate(keep);
    before.root_orientation.truncate(keep);
    before.joints.truncate(keep * before.joint_names.len());
    before.root_position.extend(joined.root_position);
    before.root_orientation.extend(joined.root_orientation);
    before.joints.extend(joined.joints);
    // Captions and contacts are not needed by physics.
    before.contacts = None;
    Ok(())
}

/// Returns a path below a folder, links resolved.
///
/// # Errors
/// [`StudioError::Operation`] for a path that leads elsewhere, [`StudioError::Input`] for one that is missing.
pub(crate) fn inside(folder: &Path, path: &Path) -> Result<PathBuf, StudioError> {
    let root = folder.canonicalize().map_err(StudioError::io(folder))?;
    let whole = root.join(path);
    let found = whole.canonicalize().map_err(StudioError::io(&whole))?;
    if found.starts_with(&root) {
        return Ok(found);
    }
    let message = format!("expected a file below '{}', got '{}'", folder.display(), path.display());
    Err(StudioError::Operation(message))
}
