//! Scripts by which robots get up.

use std::path::Path;

use lifelike_robot::GetUpScript;

use crate::error::CliError;

/// Reads a script: a TOML file, or that of a robot that comes with the program, by its name.
pub fn read(given: &Path) -> Result<GetUpScript, CliError> {
    if let Some(text) = given.to_str().and_then(GetUpScript::builtin).filter(|_| !given.exists()) {
        return Ok(GetUpScript::parse(text)?);
    }
    let name = given.display();
    let text = std::fs::read_to_string(given).map_err(|error| {
        CliError::Input(format!(
            "{name}: expected the file of a get-up script, or the name 'lima' or 'g1', got: {error}"
        ))
    })?;
    Ok(GetUpScript::parse(&text)?)
}
