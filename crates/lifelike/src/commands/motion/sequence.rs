//! `lifelike motion sequence`: one motion after the other.

use std::path::{Path, PathBuf};

use lifelike_motion::edit::{self, Part};

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Put motions one after the other, each from where the one before it ended.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion sequence builtin:walk builtin:turn_in_place builtin:wave \\
      --fade 0.4 -o data/directed --name greeting
  lifelike motion sequence data/lima/walk.motion.safetensors@1..4 \\
      data/lima/squat.motion.safetensors@0.5.. \\
      --fade 0 -o data/directed --name reactivity

A part is a clip, or a stretch of it in seconds: FILE@START..END, where both may be left out. The same clip may come
again. --fade 0 switches abruptly, to see how fast a policy reacts. The result is called A+B+... without --name.")]
pub struct Args {
    /// Clips in their order.
    #[arg(required = true, value_name = "FILE[@START..END]")]
    pub parts: Vec<String>,
    /// Overlap of neighbours (s).
    #[arg(long, default_value_t = 0.3)]
    pub fade: f64,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// A part as it was written.
#[derive(Debug, Clone, PartialEq)]
struct Stretch {
    file: PathBuf,
    start: Option<f64>,
    end: Option<f64>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let stretches = args.parts.iter().map(|text| stretch(text)).collect::<Result<Vec<_>, _>>()?;
    let stage = args.common.stage(stretches.iter().map(|s| s.file.as_path()))?;
    let clips = stretches.iter().map(|s| stage.clip(&s.file)).collect::<Result<Vec<_>, _>>()?;
    let parts: Vec<Part> =
        clips.iter().zip(&stretches).map(|(clip, s)| Part { clip, start: s.start, end: s.end }).collect();
    let made = args.common.write(edit::sequence(&parts, args.fade)?, &stage)?;
    output.result(&made, || made.text())
}

/// Reads FILE or FILE@START..END. A file whose name holds a `@` is that file.
fn stretch(text: &str) -> Result<Stretch, CliError> {
    let whole = Stretch { file: text.into(), start: None, end: None };
    if Path::new(text).exists() {
        return Ok(whole);
    }
    let Some((file, (start, end))) = text.rsplit_once('@').and_then(|(f, range)| Some((f, range.split_once("..")?)))
    else {
        return Ok(whole);
    };
    let time = |time: &str| match time.trim() {
        "" => Ok(None),
        time => time
            .parse()
            .map(Some)
            .map_err(|_| CliError::Usage(format!("'{text}': expected START..END in seconds, got '{time}'"))),
    };
    Ok(Stretch { file: file.into(), start: time(start)?, end: time(end)? })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn stretches_are_read() {
        let read = |text| stretch(text).unwrap();
        let expected = |start, end| Stretch { file: "a.bvh".into(), start, end };
        assert_eq!(read("a.bvh"), expected(None, None));
        assert_eq!(read("a.bvh@1.5..2"), expected(Some(1.5), Some(2.0)));
        assert_eq!(read("a.bvh@.5.."), expected(Some(0.5), None));
        assert_eq!(read("a.bvh@..2"), expected(None, Some(2.0)));
        assert_eq!(read("me@home.bvh").file, PathBuf::from("me@home.bvh"));
        assert!(stretch("a.bvh@1..x").unwrap_err().to_string().contains("'x'"));
    }
}
