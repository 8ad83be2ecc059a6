//! Threads beside the engine: one makes motion, one saves.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use lifelike_robot::ReferenceLibrary;

use crate::request::{Job, Message};
use crate::similar::Similar;
use crate::stage::Stage;
use crate::workshop::Workshop;

/// Makes motion and looks for it; of several jobs that wait only the newest.
pub fn build(jobs: &Receiver<Job>, answers: &Sender<Message>, mut workshop: Workshop, stage: &Stage) {
    let mut similar = Similar::new(Arc::clone(stage.robot()), stage.prior.clone(), stage.folder.clone());
    while let Ok(mut job) = jobs.recv() {
        let mut last = None;
        while let Ok(newer) = jobs.try_recv() {
            let before = std::mem::replace(&mut job, newer);
            last = if matches!(before, Job::Build(..)) { Some(before) } else { last };
        }
        // A search drops no motion that waits.
        let build = if matches!(job, Job::Build(..)) { None } else { last };
        for job in build.into_iter().chain([job]) {
            let answer = match job {
                Job::Build(version, scene) => {
                    let built = workshop.build(&scene).and_then(|built| Ok((stage.reference(&built)?, built)));
                    let built = built.map(|(reference, built)| (built, reference));
                    Message::Built(version, built.map_err(|error| error.to_string()))
                }
                Job::Similar(motion, at, but) => {
                    Message::Found(at, similar.to(&motion, at, but.as_deref()).map_err(|error| error.to_string()))
                }
            };
            if answers.send(answer).is_err() {
                return;
            }
        }
    }
}

/// Saves; of several texts that wait only the newest. Syncing a disk takes longer than a frame.
pub fn save(path: &Path, texts: &Receiver<String>, answers: &Sender<Message>) {
    while let Ok(mut text) = texts.recv() {
        while let Ok(newer) = texts.try_recv() {
            text = newer;
        }
        let saved = lifelike_checkpoint::write_file(path, text.as_bytes());
        let saved = saved.map_err(|error| format!("{} is not saved: {error}", path.display()));
        if answers.send(Message::Saved(saved)).is_err() {
            return;
        }
    }
}

/// Returns the first frame in which two references differ.
pub fn difference(a: &ReferenceLibrary, b: &ReferenceLibrary) -> usize {
    let size = a.layout.size();
    let joints = a.features.chunks(size).zip(b.features.chunks(size)).take_while(|(a, b)| a == b).count();
    let roots = a.root_position.chunks(3).zip(b.root_position.chunks(3)).take_while(|(a, b)| a == b).count();
    let turns = a.root_orientation.chunks(4).zip(b.root_orientation.chunks(4)).take_while(|(a, b)| a == b).count();
    joints.min(roots).min(turns)
}
