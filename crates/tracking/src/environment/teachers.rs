//! Teachers: policies whose actions a new one learns to take in the states that it gets itself into (DAgger, Ross et al. 2011).
//!
//! Teachers see the truth, whatever the new policy is told: theirs may be another layout, without noise and delays.
//! They teach joint targets. So their outputs may be corrections of the reference where the new policy's are the
//! targets themselves.

use std::borrow::Cow;

use lifelike_robot::Controller;
use lifelike_robot::controller::PolicyWorkspace;
use lifelike_sim::BatchState;
use rayon::prelude::*;

use super::setup::{Setup, expect};
use super::state::write_features;
use super::{CHUNK, Environment};
use crate::TrackerError;
use crate::episode::Episode;
use crate::observe::{Observed, Observer};
use crate::plan::teachers_of;

/// All teachers, and which one teaches a clip.
#[derive(Default)]
pub(super) struct Teachers {
    teachers: Vec<Teacher>,
    of_clip: Vec<usize>,
}

struct Teacher {
    controller: Controller,
    observer: Observer,
}

impl Environment {
    /// Lets the policies of the plan's `teachers` teach, each its clips.
    ///
    /// # Errors
    /// They are not as many, a clip has no teacher, or a teacher sees latent codes of another size, or earlier steps.
    pub fn set_teachers(&mut self, controllers: Vec<Controller>) -> Result<(), TrackerError> {
        let (plan, library) = (&self.setup.plan, &self.setup.library);
        expect("policies of the plan's teachers", plan.teachers.len(), controllers.len())?;
        for (controller, spec) in controllers.iter().zip(&plan.teachers) {
            let (header, of) = (controller.header(), spec.policy.display());
            expect(&format!("earlier steps that the teacher {of} sees"), 0, header.observation.reference.history)?;
            let latent = header.observation.reference.latent;
            if latent > 0 {
                expect(&format!("latent codes that the teacher {of} sees"), plan.inputs.latent, latent)?;
            }
        }
        let of_clip = if controllers.is_empty() { Vec::new() } else { teachers_of(&plan.teachers, &library.names)? };
        let robot = &self.setup.robot;
        let teacher = |controller: Controller| Teacher {
            observer: Observer::new(robot, controller.observation().clone()),
            controller,
        };
        self.teachers = Teachers { teachers: controllers.into_iter().map(teacher).collect(), of_clip };
        Ok(())
    }

    /// Appends what the teachers would do now, `[N, J]` outputs of a policy; nothing where there are none.
    pub(super) fn taught(&self, out: &mut Vec<f32>) {
        let pupils = Pupils { setup: &self.setup, episodes: &self.episodes, state: self.simulation.state() };
        self.teachers.advise(&pupils, out);
    }
}

/// The environments, as teachers see them.
struct Pupils<'a> {
    setup: &'a Setup,
    episodes: &'a [Episode],
    state: &'a BatchState,
}

impl Teachers {
    fn advise(&self, pupils: &Pupils<'_>, out: &mut Vec<f32>) {
        if self.teachers.is_empty() {
            return;
        }
        let (library, joints) = (&pupils.setup.library, pupils.setup.robot.joints());
        let first = out.len();
        out.resize(first + pupils.episodes.len() * joints, 0.0);
        for (number, teacher) in self.teachers.iter().enumerate() {
            let mine = |i: &usize| self.of_clip[library.clip_of(pupils.episodes[*i].frame)] == number;
            let class: Vec<usize> = (0..pupils.episodes.len()).filter(mine).collect();
            let mut actions = vec![0.0; class.len() * joints];
            class.par_chunks(CHUNK).zip(actions.par_chunks_mut(CHUNK * joints)).for_each_init(
                || (PolicyWorkspace::batched(), vec![0.0; library.layout.size()]),
                |(work, features), (class, actions)| teacher.advise(pupils, class, features, work, actions),
            );
            let own = &pupils.setup.actions;
            let mut targets = vec![0.0; joints];
            for (i, action) in class.iter().zip(actions.chunks_exact(joints)) {
                let row = &mut out[first + i * joints..first + (i + 1) * joints];
                if teacher.controller.actions().spec == own.spec {
                    row.iter_mut().zip(action).for_each(|(out, y)| *out = own.spec.clamp_output(*y));
                } else {
                    let reference = library.joints_at(library.ahead(pupils.episodes[*i].frame, 1));
                    teacher.controller.actions().write(action, reference, &mut targets);
                    own.holding(&targets, reference, row);
                }
            }
        }
    }
}

impl Teacher {
    /// Writes its outputs for some environments.
    fn advise(
        &self,
        pupils: &Pupils<'_>,
        class: &[usize],
        features: &mut [f32],
        work: &mut PolicyWorkspace,
        actions: &mut [f32],
    ) {
        let &Pupils { setup, episodes, state } = pupils;
        let (library, width) = (&*setup.library, self.observer.actor_size());
        let mut rows = vec![0.0; class.len() * width];
        for (&i, row) in class.iter().zip(rows.chunks_exact_mut(width)) {
            let heading = write_features(state, i, setup, features);
            let episode = self.as_own(&episodes[i], setup);
            let observed = Observed { state, i, episode: &episode, library, features, heading };
            self.observer.write_policy(&observed, row);
        }
        self.controller.outputs(&mut rows, work, actions);
    }

    /// Returns an episode with the last actions as this teacher would have said them: its policy sees its own.
    fn as_own<'a>(&self, episode: &'a Episode, setup: &Setup) -> Cow<'a, Episode> {
        let own = self.controller.actions();
        if own.spec == setup.actions.spec {
            return Cow::Borrowed(episode);
        }
        let mut told = episode.clone();
        let mut targets = vec![0.0; episode.last.len()];
        for (output, frame) in [&mut told.last, &mut told.before].into_iter().zip(episode.asked) {
            let reference = setup.library.joints_at(frame);
            setup.actions.write(output, reference, &mut targets);
            own.holding(&targets, reference, output);
        }
        Cow::Owned(told)
    }
}
