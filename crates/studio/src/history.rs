//! Frames that were simulated, and saved states to go on from any of them.

use std::sync::Arc;

use lifelike_robot::ReferenceLibrary;

use crate::StudioError;
use crate::packet;
use crate::performer::{Events, Fall, Performer, Saved};

/// Frames between two saved states.
const EVERY: usize = 10;
/// Time after a fall for which it is shown (s).
const SHOWN: f64 = 1.2;

/// Simulated frames, from the start of the scene on.
pub struct History {
    performer: Performer,
    bodies: Vec<Box<[u8]>>,
    columns: Vec<[u8; 5]>,
    saved: Vec<Saved>,
    falls: Vec<Fall>,
}

impl History {
    /// Begins with a performer at its first frame.
    pub fn new(performer: Performer) -> Self {
        let saved = vec![performer.save()];
        let (body, column) = packet::frame(performer.rollout(), false);
        Self { performer, bodies: vec![body], columns: vec![column], saved, falls: Vec::new() }
    }

    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Returns the body of a frame's packet.
    pub fn body(&self, frame: usize) -> &[u8] {
        self.bodies.get(frame).map_or(&[], |body| body)
    }

    /// Returns a copy of the bodies of all packets.
    pub fn bodies(&self) -> Vec<Box<[u8]>> {
        self.bodies.clone()
    }

    /// Returns the columns of the strips.
    pub fn columns(&self) -> &[[u8; 5]] {
        &self.columns
    }

    /// Returns the falls.
    pub fn falls(&self) -> &[Fall] {
        &self.falls
    }

    /// Returns whether the robot lies after a fall in a frame.
    pub fn is_down(&self, frame: usize, hz: f64) -> bool {
        let shown = (SHOWN * hz) as usize;
        self.falls.iter().any(|fall| (fall.frame..fall.frame + shown).contains(&frame))
    }

    /// Simulates one frame; returns whether the robot fell in it.
    ///
    /// # Errors
    /// As [`Performer::step`].
    pub fn step(&mut self, events: &Events) -> Result<bool, StudioError> {
        let fall = self.performer.step(events)?;
        let fell = fall.is_some();
        let (body, column) = packet::frame(self.performer.rollout(), fell);
        if self.performer.frame() == self.bodies.len() {
            self.bodies.push(body);
            self.columns.push(column);
            self.falls.extend(fall);
            if self.performer.frame().is_multiple_of(EVERY) {
                self.saved.push(self.performer.save());
            }
        }
        Ok(fell)
    }

    /// Forgets everything, and begins with the first frame of a reference.
    ///
    /// # Errors
    /// As [`Performer::restart`].
    pub fn restart(&mut self, reference: &Arc<ReferenceLibrary>) -> Result<(), StudioError> {
        self.performer.restart(reference)?;
        let (body, column) = packet::frame(self.performer.rollout(), false);
        (self.bodies, self.columns) = (vec![body], vec![column]);
        self.saved = vec![self.performer.save()];
        self.falls.clear();
        Ok(())
    }

    /// Forgets all frames after this one, and goes on from there along a reference that may differ after it.
    ///
    /// # Errors
    /// As [`Performer::restore`].
    pub fn truncate(&mut self, frame: usize, reference: &Arc<ReferenceLibrary>) -> Result<(), StudioError> {
        let last = self.saved.iter().rposition(|saved| saved.frame() <= frame).unwrap_or(0);
        self.saved.truncate(last + 1);
        let Some(saved) = self.saved.last() else { return Ok(()) };
        // A state is saved before the step that follows it: frames up to it are as they were.
        self.performer.restore(saved, reference)?;
        let kept = saved.frame() + 1;
        self.bodies.truncate(kept);
        self.columns.truncate(kept);
        self.falls.retain(|fall| fall.frame < kept);
        Ok(())
    }
}
