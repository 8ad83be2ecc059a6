//! The screen: the newest frame, view and strips.

use std::sync::Arc;
use std::time::Instant;

use super::{Engine, VIEW_EVERY};
use crate::packet::{self, Head};
use crate::stage;
use crate::view::View;

impl Engine {
    pub(super) fn publish(&mut self) {
        let (frame, known) = (self.frame(), self.history.len());
        let shown = frame.min(known.saturating_sub(1));
        // A page that plays moves from picture to picture towards the next frame: it is never late, and a push is seen at once.
        let drawn = if self.playing { (frame + 1).min(known.saturating_sub(1)) } else { shown };
        let force = self.pulls.last().map_or(0.0, |pull| pull.newtons.iter().map(|f| f * f).sum::<f32>().sqrt());
        let flags = u8::from(self.playing)
            | u8::from(self.history.is_down(shown, self.hz())) << 1
            | u8::from(self.building.is_some()) << 2
            | u8::from(self.kept.is_some()) << 3;
        let robot = self.stage.robot();
        let sizes = [robot.character.bodies.len() - 1, robot.joints(), robot.anatomy.soles.len()].map(|n| n as u16);
        let counts = [shown, known, self.frames(), self.version as usize].map(|n| n as u32);
        let head = Head { flags, sizes, counts, rate: self.rate as f32, force };
        let mut packet = packet::packet(&head, self.history.body(drawn));
        if let Some(kept) = self.kept.as_ref().and_then(|kept| kept.get(drawn).or(kept.last())) {
            packet.extend(packet::physics(kept, robot.character.bodies.len() - 1));
        }
        self.outputs.frame.send_if_modified(|last| {
            let differs = **last != packet;
            if differs {
                *last = Arc::new(packet);
            }
            differs
        });
        if self.stale && (self.viewed.elapsed() >= VIEW_EVERY || known >= self.frames() || known < 2) {
            self.outputs.view.send_replace(Arc::new(self.view()));
            self.outputs.strips.send_replace(Arc::new(packet::strips(self.history.columns(), self.frames())));
            (self.viewed, self.stale) = (Instant::now(), false);
        }
    }

    fn view(&self) -> String {
        View {
            version: self.version,
            name: stage::name_of(self.document.path()),
            scene: self.document.scene(),
            spans: &self.built.spans,
            falls: self.history.falls(),
            problem: &self.problem,
            steps: self.document.steps(),
            hz: self.hz(),
            seconds: (self.frames() - 1) as f64 / self.hz(),
            playing: self.playing,
            rate: self.rate,
            building: self.building.is_some(),
            kept: self.kept.is_some(),
            similar: self.similar.as_ref(),
            speaks: self.stage.generator.is_some(),
        }
        .to_json()
    }
}
