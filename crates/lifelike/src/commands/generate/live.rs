//! `lifelike generate --live`: sentences from standard input, done while physics plays in real time.

use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use lifelike_studio::{Document, EXTENSION, Live, Scene, Status};
use serde_json::json;

use super::Args;
use crate::commands::stage;
use crate::destination;
use crate::error::CliError;
use crate::interrupt;
use crate::next::NextCommand;
use crate::output::Output;

/// Time between two looks at the engine.
const EVERY: Duration = Duration::from_millis(10);

/// A sentence on its way to the robot.
struct Waiting {
    text: String,
    said: Instant,
    /// Changes of the scene before it.
    version: u64,
}

/// Reads sentences until the input ends, and ends when the robot has done the last of them.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    lifelike_studio::read_by(args.reader.as_deref());
    let scene = Scene {
        robot: args.robot.clone(),
        policy: args.policy.as_ref().map(|policy| policy.display().to_string()),
        seed: args.seed,
        ..Scene::default()
    };
    let folder = if destination::is_motion(&args.output) { stage::folder(&args.output) } else { args.output.clone() };
    std::fs::create_dir_all(&folder).map_err(CliError::write(&folder))?;
    let file = free_name(&folder);
    let document = Document::open(&file, || scene.clone())?;
    let live = Live::start(stage::open(&scene, &file)?, document)?;
    let stop = interrupt::flag()?;
    let lines = lines();
    let mut refused = String::new();
    let (mut waiting, mut shown, mut falls, mut open) = (None::<Waiting>, 0, 0, true);
    while !stop.load(std::sync::atomic::Ordering::SeqCst) {
        let status = live.status()?;
        if let Some(one) = waiting.take_if(|one| is_answered(&status, one, shown)) {
            answer(&status, &one, shown, output)?;
            if status.spans.len() > shown {
                live.play()?;
            } else {
                refused.clone_from(&status.problem);
                live.take_back()?;
            }
        }
        shown = status.spans.len().max(shown);
        for fall in status.falls.iter().skip(falls) {
            let value = json!({ "event": "fall", "second": fall.second, "cause": fall.cause });
            output.result(&value, || format!("falls at {:.1} s, {}; stands again", fall.second, fall.cause))?;
        }
        falls = status.falls.len().max(falls);
        let stands = waiting.is_none() && !status.playing && !status.building;
        if stands && !status.problem.is_empty() && status.problem != refused {
            return Err(CliError::Failed(status.problem));
        }
        let at_end = status.frame as f64 >= status.seconds * status.hz - 1.5 && !status.building;
        if waiting.is_none() {
            match lines.try_recv() {
                Ok(text) if text.trim().is_empty() => {}
                Ok(text) => {
                    waiting = Some(Waiting { said: Instant::now(), version: status.version, text });
                    live.say(waiting.as_ref().map_or("", |one| one.text.trim()))?;
                }
                Err(TryRecvError::Disconnected) => open = false,
                Err(TryRecvError::Empty) => {}
            }
        }
        if !open && waiting.is_none() && at_end {
            break;
        }
        std::thread::sleep(EVERY);
    }
    let status = live.status()?;
    drop(live);
    let value = json!({ "event": "end", "scene": file, "seconds": status.seconds, "falls": status.falls.len() });
    output.result(&value, || {
        let next = NextCommand::new("play").word(file.display()).path("-o", &folder.join("live"));
        format!("{:.1} s, {} falls: {}\nnext: {next}\n", status.seconds, status.falls.len(), file.display())
    })
}

/// Returns whether the motion of a sentence was made and its first frame simulated, or the sentence refused.
fn is_answered(status: &Status, one: &Waiting, shown: usize) -> bool {
    let begun = |from: f64| status.simulated as f64 > from * status.hz;
    let made = status.spans.len() > shown && !status.building && status.spans.last().is_some_and(|s| begun(s.from));
    made || status.version > one.version && !status.building && !status.problem.is_empty()
}

fn answer(status: &Status, one: &Waiting, shown: usize, output: &Output) -> Result<(), CliError> {
    let took = one.said.elapsed().as_secs_f64();
    let text = one.text.trim();
    match status.spans.last().filter(|_| status.spans.len() > shown) {
        Some(span) => {
            let value = json!({
                "event": "said", "sentence": text, "understood": span.source, "from": span.from, "to": span.to,
                "seconds_to_physics": took,
            });
            let [from, to] = [span.from, span.to];
            output.result(&value, || format!("{from:.1} to {to:.1} s: {}; in physics after {took:.2} s", span.source))
        }
        None => {
            // The problem names the block, which is taken back.
            let because = status.problem.split_once("': ").map_or(status.problem.as_str(), |(_, rest)| rest);
            let value = json!({ "event": "refused", "sentence": text, "because": because });
            output.result(&value, || format!("\"{text}\": {because}"))
        }
    }
}

/// Reads lines in a thread of its own: physics waits for nobody.
fn lines() -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Returns a name for the scene that no file has.
fn free_name(folder: &Path) -> PathBuf {
    let name = |n: usize| folder.join(if n == 1 { format!("live{EXTENSION}") } else { format!("live-{n}{EXTENSION}") });
    (1..).map(name).find(|file| !file.exists()).unwrap_or_else(|| name(1))
}
