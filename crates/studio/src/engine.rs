//! The engine: one thread with its own clock that owns the scene and its physics, and never waits for a viewer.
//!
//! The scene is simulated ahead of the clock as far as it goes. A change truncates what was simulated at the first frame
//! that it concerns, and physics goes on from the saved state before it. Motion is made in a second thread, so that the
//! clock goes on while a clip is retargeted. A third one saves.

mod show;
mod touch;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use lifelike_robot::ReferenceLibrary;
use tokio::sync::watch;

use crate::StudioError;
use crate::document::Document;
use crate::history::History;
use crate::operation::Operation;
use crate::performer::{Events, Force};
use crate::request::{Job, Message, Request, Save, Screen};
use crate::scene::Scene;
use crate::similar::Alike;
use crate::stage::{self, Stage};
use crate::workers::{build, difference, save};
use crate::workshop::Built;

/// Physics in one go, before the clock and the viewers have their turn.
const SLICE: Duration = Duration::from_millis(6);
/// The same, where the frame of the clock is not simulated yet.
const CATCH_UP: Duration = Duration::from_millis(60);
/// Rates of the clock.
const RATES: std::ops::RangeInclusive<f64> = 0.05..=8.0;
/// Time between two views while physics runs ahead.
const VIEW_EVERY: Duration = Duration::from_millis(250);

/// Senders of the screen.
struct Outputs {
    frame: watch::Sender<Arc<Vec<u8>>>,
    view: watch::Sender<Arc<String>>,
    strips: watch::Sender<Arc<Vec<u8>>>,
}

/// The state of the thread.
pub struct Engine {
    stage: Stage,
    document: Document,
    inbox: Receiver<Message>,
    builder: Sender<Job>,
    saver: Sender<Save>,
    outputs: Outputs,
    history: History,
    reference: Arc<ReferenceLibrary>,
    built: Built,
    events: Events,
    /// Pulls that are not part of the scene yet.
    pulls: Vec<Force>,
    /// Take that is shown beside the present one, frame by frame.
    kept: Option<Vec<Box<[u8]>>>,
    /// Clips that are like the motion at a time (s).
    similar: Option<(f64, Vec<Alike>)>,
    /// Name of the policy that performs.
    policy: Option<String>,
    /// Time of the clock (s).
    time: f64,
    rate: f64,
    playing: bool,
    version: u64,
    building: Option<u64>,
    problem: String,
    viewed: Instant,
    stale: bool,
}

impl Engine {
    /// Starts the thread.
    ///
    /// # Errors
    /// [`StudioError`] where the robot cannot be simulated.
    pub fn start(stage: Stage, document: Document) -> Result<(Sender<Message>, Screen), StudioError> {
        let (sender, inbox) = channel();
        let (frame, view, strips) =
            (watch::channel(Arc::default()), watch::channel(Arc::default()), watch::channel(Arc::default()));
        let screen = Screen { frame: frame.1, view: view.1, strips: strips.1 };
        let outputs = Outputs { frame: frame.0, view: view.0, strips: strips.0 };
        let built = stage.workshop().build(&Scene::default())?;
        let reference = stage.reference(&built)?;
        let history = History::new(stage.performer(&reference, false)?);
        let (builder, jobs) = channel();
        let (answers, workshop, robot) = (sender.clone(), stage.workshop(), stage.clone());
        let spawn = |name: &str| std::thread::Builder::new().name(name.into());
        let failed = |error: std::io::Error| StudioError::Server(error.to_string());
        spawn("builder").spawn(move || build(&jobs, &answers, workshop, &robot)).map_err(failed)?;
        let (saver, saves) = channel();
        let (answers, path) = (sender.clone(), document.path().to_path_buf());
        spawn("saver").spawn(move || save(&path, &saves, &answers)).map_err(failed)?;
        let mut engine = Self {
            saver,
            policy: document.scene().policy.clone(),
            similar: None,
            stage,
            document,
            inbox,
            builder,
            outputs,
            history,
            reference,
            built,
            events: Events::default(),
            pulls: Vec::new(),
            kept: None,
            time: 0.0,
            rate: 1.0,
            playing: false,
            version: 0,
            building: None,
            problem: String::new(),
            viewed: Instant::now(),
            stale: true,
        };
        engine.follow(true);
        spawn("engine").spawn(move || engine.run()).map_err(failed)?;
        Ok((sender, screen))
    }

    fn run(mut self) {
        let mut before = Instant::now();
        let mut pending = None;
        loop {
            let message = match pending.take() {
                Some(message) => Some(message),
                None => match self.wait() {
                    Some(Duration::MAX) => self.inbox.recv().map_err(|_| RecvTimeoutError::Disconnected),
                    Some(time) => self.inbox.recv_timeout(time),
                    None => self.inbox.try_recv().map_err(|_| RecvTimeoutError::Timeout),
                }
                .map_or_else(|error| (error == RecvTimeoutError::Disconnected).then_some(Message::Close), Some),
            };
            let now = Instant::now();
            self.advance(now - before);
            before = now;
            match message {
                Some(Message::Close) => return,
                Some(message) => {
                    self.handle(message);
                    // Everything that waits is handled before the next picture.
                    pending = self.inbox.try_recv().ok();
                    if pending.is_some() {
                        continue;
                    }
                }
                None => {}
            }
            if let Err(error) = self.simulate() {
                self.problem = error.to_string();
                (self.playing, self.stale) = (false, true);
            }
            self.publish();
        }
    }

    /// Returns the time to wait for a message: [`Duration::MAX`] where nothing is to be done, none where there is work.
    fn wait(&self) -> Option<Duration> {
        if self.history.len() < self.simulated_to() {
            return None;
        }
        let view = if self.stale { VIEW_EVERY.saturating_sub(self.viewed.elapsed()) } else { Duration::MAX };
        if !self.playing {
            return Some(view);
        }
        let next = (self.frame() + 1) as f64 / self.hz();
        let next = Duration::from_secs_f64(((next - self.time) / self.rate).clamp(0.0005, 1.0));
        Some(next.min(view))
    }

    fn hz(&self) -> f64 {
        self.stage.robot().control_hz
    }

    /// Returns the number of frames of the scene; a pull goes on for as long as it is held.
    fn frames(&self) -> usize {
        let frames = stage::frames(&self.reference, &self.events, self.hz());
        let held = self.pulls.last().map_or(0, |pull| pull.from.max((self.time * self.hz()) as usize) + 50);
        frames.max(held)
    }

    /// Returns the frame of the clock.
    fn frame(&self) -> usize {
        ((self.time * self.hz() + 1e-6) as usize).min(self.frames().saturating_sub(1))
    }

    /// Returns the number of frames that are to be simulated: all, but while a body is pulled only the one that comes next.
    fn simulated_to(&self) -> usize {
        if self.pulls.is_empty() { self.frames() } else { self.frame() + 2 }
    }

    fn advance(&mut self, passed: Duration) {
        if !self.playing {
            return;
        }
        // The clock waits for physics, never the other way round.
        let most = (self.history.len().saturating_sub(1) as f64 + 1.0) / self.hz();
        self.time = (self.time + passed.as_secs_f64().min(0.25) * self.rate).min(most.max(self.time));
        let end = (self.frames() - 1) as f64 / self.hz();
        if self.time >= end && self.building.is_none() {
            (self.time, self.playing, self.stale) = (end, false, true);
        }
    }

    fn handle(&mut self, message: Message) {
        match message {
            Message::Request(request) => {
                if let Err(error) = self.obey(request) {
                    self.problem = error.to_string();
                    self.stale = true;
                }
            }
            Message::Built(version, result) if self.building == Some(version) => {
                self.building = None;
                match result {
                    Ok((built, reference)) => self.exchange(built, reference),
                    Err(problem) => self.problem = problem,
                }
                (self.stale, self.version) = (true, self.version + 1);
            }
            Message::Found(at, Ok(found)) => (self.similar, self.stale) = (Some((at, found)), true),
            Message::Saved(Err(problem)) | Message::Found(_, Err(problem)) => {
                (self.problem, self.stale) = (problem, true);
            }
            Message::Scene(answer) => {
                let _ = answer.send(self.document.scene().clone());
            }
            Message::Save(answer) => {
                let waits = Some((answer, self.document.scene().clone()));
                let _ = self.saver.send(Save { text: self.document.text().to_string(), waits });
            }
            Message::Built(..) | Message::Saved(Ok(())) | Message::Close => {}
        }
    }

    fn obey(&mut self, request: Request) -> Result<(), StudioError> {
        self.problem.clear();
        match request {
            Request::Operation(operation) => {
                let operation = self.joined_at_clock(operation);
                let changes_motion = operation.changes_motion();
                if let Operation::Policy { name } = &operation {
                    self.stage.policies.find(name.as_deref())?;
                }
                if !changes_motion {
                    // Refused before it is written: a body that the robot has not.
                    let mut scene = self.document.scene().clone();
                    operation.clone().apply(&mut scene)?;
                    Events::of(&scene, self.stage.robot())?;
                }
                self.document.apply(operation)?;
                self.changed(changes_motion);
            }
            Request::Undo => {
                self.document.undo()?;
                self.changed(true);
            }
            Request::Redo => {
                self.document.redo()?;
                self.changed(true);
            }
            Request::Play(playing) => {
                let at_end = self.frame() + 1 >= self.frames();
                if playing && at_end && self.pulls.is_empty() {
                    self.time = 0.0;
                }
                (self.playing, self.stale) = (playing, true);
            }
            Request::Seek(time) => {
                if time.is_finite() {
                    self.time = time.clamp(0.0, (self.frames() - 1) as f64 / self.hz());
                }
            }
            Request::Step(frames) => {
                let frame = self.frame().saturating_add_signed(frames as isize).min(self.frames() - 1);
                (self.playing, self.time, self.stale) = (false, frame as f64 / self.hz(), true);
            }
            Request::Rate(rate) => {
                if !RATES.contains(&rate) {
                    let message = format!("rate: expected {} to {}, got {rate}", RATES.start(), RATES.end());
                    return Err(StudioError::Operation(message));
                }
                (self.rate, self.stale) = (rate, true);
            }
            Request::Pull { body, newtons } => self.pull(&body, newtons)?,
            Request::Keep(keep) => (self.kept, self.stale) = (keep.then(|| self.history.bodies()), true),
            Request::Release => self.release()?,
            Request::Similar(at) => {
                if !(0.0..=self.built.clip.seconds()).contains(&at) {
                    let end = self.built.clip.seconds();
                    return Err(StudioError::Operation(format!("similar: expected 0 to {end:.2} s, got {at}")));
                }
                let under = self.built.spans.iter().find(|span| span.from <= at && at < span.to);
                let block = self.document.scene().motion.iter().find(|block| under.is_some_and(|u| u.id == block.id));
                let but = block.and_then(|block| block.clip.clone());
                let _ = self.builder.send(Job::Similar(Box::new(self.built.clip.clone()), at, but));
            }
        }
        Ok(())
    }

    /// Saves a change of the document, and follows it.
    fn changed(&mut self, motion: bool) {
        let _ = self.saver.send(Save { text: self.document.text().to_string(), waits: None });
        self.follow(motion);
    }

    /// Follows a change of the document.
    fn follow(&mut self, motion: bool) {
        self.version += 1;
        self.stale = true;
        match Events::of(self.document.scene(), self.stage.robot()) {
            Ok(events) => {
                let first = self.events.first_difference(&events);
                self.events = events;
                // A push of this frame acts on the next.
                if let Some(frame) = first
                    && let Err(error) = self.history.truncate(frame, &self.reference)
                {
                    self.problem = error.to_string();
                }
            }
            Err(error) => self.problem = error.to_string(),
        }
        if self.policy != self.document.scene().policy
            && let Err(error) = self.hand_over()
        {
            self.problem = error.to_string();
        }
        if motion {
            self.building = Some(self.version);
            let _ = self.builder.send(Job::Build(self.version, Box::new(self.document.scene().clone())));
        }
    }

    /// Lets the document's policy perform the scene, from its start.
    fn hand_over(&mut self) -> Result<(), StudioError> {
        self.policy.clone_from(&self.document.scene().policy);
        self.stage = self.stage.for_scene(self.document.scene())?;
        self.history = History::new(self.stage.performer(&self.reference, false)?);
        Ok(())
    }

    /// Takes a new reference in; physics goes on from the last frame before the first one that differs.
    fn exchange(&mut self, built: Built, reference: Arc<ReferenceLibrary>) {
        let first = difference(&self.reference, &reference);
        let changed = match first {
            // The robot begins in another state.
            0 => self.history.restart(&reference),
            _ => self.history.truncate(first.saturating_sub(self.stage.looks_ahead()), &reference),
        };
        if let Err(error) = changed {
            self.problem = error.to_string();
        }
        (self.built, self.reference) = (built, reference);
        self.time = self.time.min((self.frames() - 1) as f64 / self.hz());
    }

    /// Simulates for a slice of time.
    fn simulate(&mut self) -> Result<(), StudioError> {
        let began = Instant::now();
        let goal = self.simulated_to();
        if self.history.len() >= goal {
            return Ok(());
        }
        let mut events = self.events.clone();
        events.forces.extend(self.pulls.iter().cloned());
        let shown = self.frame();
        // What is on screen is never behind for longer than it takes.
        let limit = |known: usize| if known <= shown { CATCH_UP } else { SLICE };
        while self.history.len() < goal && began.elapsed() < limit(self.history.len()) {
            self.stale |= self.history.step(&events)?;
        }
        self.stale = true;
        Ok(())
    }
}
