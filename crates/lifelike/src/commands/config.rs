//! `lifelike config`: where the program keeps what.

use lifelike_sim::mujoco;
use serde_json::json;

use crate::error::CliError;
use crate::folders;
use crate::output::{Output, table};
use crate::shipped;

/// Show where the program keeps fetched files and caches, and which networks come with it.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
///
/// # Errors
/// None of its own.
pub fn run(_args: &Args, output: &Output) -> Result<(), CliError> {
    let (data, cache) = (folders::data(), folders::cache());
    let networks: Vec<_> = shipped::all()
        .map(|network| {
            let size = network.bytes.len();
            json!({ "name": network.name, "kind": network.kind.name(), "file": network.file, "bytes": size, "terms": network.terms })
        })
        .collect();
    let library = mujoco::find();
    let value = json!({ "data": data, "cache": cache, "mujoco": library.as_ref().ok(), "networks": networks });
    output.result(&value, || {
        let rows: Vec<Vec<String>> = shipped::all()
            .map(|network| {
                let size = format!("{:.1}", network.bytes.len() as f64 / 1e6);
                let terms = if network.terms.is_some() { "not for commercial use" } else { "" };
                vec![network.name.into(), network.kind.name().into(), size, terms.into()]
            })
            .collect();
        format!(
            "fetched robots and models  {}  (XDG_DATA_HOME)\nnetworks written to disk   {}  (XDG_CACHE_HOME)\n\
             MuJoCo {}              {}  ({})\n\n{}",
            data.display(),
            cache.display(),
            mujoco::VERSION,
            library.as_ref().map_or_else(|_| "lifelike fetch mujoco".into(), |path| path.display().to_string()),
            mujoco::VARIABLE,
            table(&["network", "kind", "MB", "terms"], &rows)
        )
    })
}
