//! Actions while the clock runs: motion that joins at once, and pulls by hand.

use super::Engine;
use crate::StudioError;
use crate::operation::Operation;
use crate::performer::Force;
use crate::scene::Push;
use crate::workshop::{OVERLAP, STAND};

/// Time from the clock to the start of motion that is added while the robot stands (s).
const LEAD: f64 = 0.1;

impl Engine {
    /// Lets motion that is added at the end begin at the clock, where the robot already stands there; and starts the clock.
    pub(super) fn joined_at_clock(&mut self, mut operation: Operation) -> Operation {
        let (Operation::Say { wait, index: None, .. } | Operation::Add { wait, index: None, .. }) = &mut operation
        else {
            return operation;
        };
        // The stand of the end begins within the last block.
        let stands = match self.document.scene().motion.is_empty() {
            true => 0.0,
            false => self.built.clip.seconds() - STAND,
        };
        if self.time > stands && wait.is_none() && self.building.is_none() {
            *wait = Some(((self.time + LEAD - stands + OVERLAP) * self.hz()).round() / self.hz());
        }
        (self.playing, self.stale) = (true, true);
        operation
    }

    /// Begins or changes a pull at the frame of the clock.
    pub(super) fn pull(&mut self, body: &str, newtons: [f64; 3]) -> Result<(), StudioError> {
        let body = self.stage.robot().character.body(body).map_err(StudioError::block("pull"))?;
        if !newtons.iter().all(|force| force.is_finite() && force.abs() <= 1e4) {
            return Err(StudioError::Operation(format!("pull: expected at most 10000 N, got {newtons:?}")));
        }
        let frame = self.frame();
        self.end_pull(frame);
        let newtons = newtons.map(|force| force as f32);
        self.pulls.push(Force { from: frame, until: usize::MAX, body, newtons });
        self.history.truncate(frame, &self.reference)
    }

    fn end_pull(&mut self, frame: usize) {
        let Some(last) = self.pulls.last_mut() else { return };
        last.until = last.until.min(frame);
        self.pulls.retain(|pull| pull.until > pull.from);
    }

    /// Writes the pull into the scene as pushes: the same frames, the same forces.
    pub(super) fn release(&mut self) -> Result<(), StudioError> {
        let frame = self.frame();
        self.end_pull(frame);
        let hz = self.hz();
        let pushes = std::mem::take(&mut self.pulls);
        // What was pulled for less than a frame is no push.
        if pushes.is_empty() {
            return self.history.truncate(frame, &self.reference);
        }
        let name = |body: usize| self.stage.robot().character.bodies[body].name.clone();
        let push = |pull: &Force| Push {
            id: String::new(),
            at: pull.from as f64 / hz,
            seconds: (pull.until - pull.from) as f64 / hz,
            body: name(pull.body),
            newtons: pull.newtons.map(f64::from),
        };
        let operation = Operation::Grab { pushes: pushes.iter().map(push).collect() };
        self.document.apply(operation)?;
        self.changed(false);
        Ok(())
    }
}
