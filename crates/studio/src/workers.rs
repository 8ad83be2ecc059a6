//! Threads beside the engine: one makes motion, one saves.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use lifelike_robot::ReferenceLibrary;

use crate::request::{Job, Message, Save};
use crate::scene::Scene;
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

/// Saves; of several scenes that wait only the newest. Syncing a disk takes longer than a frame.
pub fn save(path: &Path, saves: &Receiver<Save>, answers: &Sender<Message>) {
    while let Ok(mut newest) = saves.recv() {
        let mut waiting = Vec::new();
        for newer in saves.try_iter() {
            waiting.extend(std::mem::replace(&mut newest, newer).waits);
        }
        waiting.extend(newest.waits);
        let saved = save_text(path, &newest.text);
        for (answer, scene) in waiting {
            let _ = answer.send(saved.clone().map(|()| scene));
        }
        if answers.send(Message::Saved(saved)).is_err() {
            return;
        }
    }
}

/// Saves the text of a scene. A file that has this scene already keeps its comments.
fn save_text(path: &Path, text: &str) -> Result<(), String> {
    let same = |scene: Scene| Scene::load(path).is_ok_and(|saved| saved == scene);
    if Scene::parse(text, "scene").is_ok_and(same) {
        return Ok(());
    }
    lifelike_checkpoint::write_file(path, text.as_bytes())
        .map_err(|error| format!("{} is not saved: {error}", path.display()))
}

/// Returns the first frame in which two references differ.
pub fn difference(a: &ReferenceLibrary, b: &ReferenceLibrary) -> usize {
    let size = a.layout.size();
    let joints = a.features.chunks(size).zip(b.features.chunks(size)).take_while(|(a, b)| a == b).count();
    let roots = a.root_position.chunks(3).zip(b.root_position.chunks(3)).take_while(|(a, b)| a == b).count();
    let turns = a.root_orientation.chunks(4).zip(b.root_orientation.chunks(4)).take_while(|(a, b)| a == b).count();
    joints.min(roots).min(turns)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn who_waits_for_a_scene_finds_it_in_the_file_and_a_file_keeps_its_comments() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.scene.toml");
        let scene_of = |seed: u64| Scene { seed, ..Scene::default() };
        let text = |seed: u64| scene_of(seed).to_toml().unwrap();
        std::fs::write(&path, format!("# mine\n{}", text(1))).unwrap();
        let saved = |seed: u64| {
            let ((saver, saves), (answers, _told)) = (channel(), channel());
            let (answer, mut told) = tokio::sync::oneshot::channel();
            saver.send(Save { text: text(seed), waits: Some((answer, scene_of(seed))) }).unwrap();
            drop(saver);
            save(&path, &saves, &answers);
            told.try_recv().unwrap().unwrap().seed
        };
        assert_eq!(saved(1), 1);
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("# mine"));
        assert_eq!(saved(2), 2);
        assert_eq!(Scene::load(&path).unwrap().seed, 2);
    }
}
