//! `<keyframe>`: of its positions the one called `home` is the default pose.

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::Element;

/// Name of the key that is the default pose.
const HOME: &str = "home";

/// Returns the position of the key [`HOME`] (`nq` numbers); adds a line about others to `notes`.
pub(crate) fn read(root: &Element, nq: usize, notes: &mut Vec<String>) -> Result<Option<Vec<f64>>, CharacterError> {
    let (mut home, mut others) = (None, 0);
    for key in root.children_named("keyframe").flat_map(|section| section.children_named("key")) {
        let a = Attributes::own(key);
        let position = a.text("qpos").map(|text| text.split_whitespace().map(str::parse::<f64>).collect::<Vec<_>>());
        let position = position.filter(|numbers| !numbers.is_empty());
        let is_home = a.text("name") == Some(HOME);
        others += usize::from(!is_home);
        let Some(numbers) = position else { continue };
        let (expected, got) = (format!("{nq} finite numbers for 'qpos'"), numbers.len());
        let numbers: Result<Vec<f64>, _> = numbers.into_iter().collect();
        match numbers {
            Ok(numbers) if got == nq && numbers.iter().all(|x| x.is_finite()) => {
                home = if is_home { Some(numbers) } else { home };
            }
            Ok(_) => return Err(a.invalid(expected, format!("{got}"))),
            Err(error) => return Err(a.invalid(expected, error.to_string())),
        }
    }
    if others > 0 {
        notes.push(format!("{others} keyframes are not used: the default pose is the one named '{HOME}'"));
    }
    Ok(home)
}
