//! `<keyframe>`: of its positions the one called `home` is the default pose.

use crate::error::CharacterError;
use crate::mjcf::attributes::Attributes;
use crate::mjcf::document::Element;

/// Name of the key that is the default pose.
const HOME: &str = "home";

/// Returns the position of the key [`HOME`] (`nq` numbers); adds a line about others to `notes`, and to `warnings` about keys that
/// are another model's.
pub(crate) fn read(
    root: &Element,
    nq: usize,
    notes: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> Result<Option<Vec<f64>>, CharacterError> {
    let (mut home, mut others) = (None, 0);
    for key in root.children_named("keyframe").flat_map(|section| section.children_named("key")) {
        let a = Attributes::own(key);
        let name = a.text("name").unwrap_or_default();
        others += usize::from(name != HOME);
        let numbers: Result<Vec<f64>, _> =
            a.text("qpos").unwrap_or_default().split_whitespace().map(str::parse::<f64>).collect();
        match numbers {
            Ok(numbers) if numbers.is_empty() => {}
            Ok(numbers) if numbers.iter().all(|x| x.is_finite()) => {
                if numbers.len() != nq {
                    let got = numbers.len();
                    warnings.push(format!(
                        "{}: expected {nq} numbers for 'qpos' of keyframe '{name}', got {got}: it is not used",
                        a.at
                    ));
                } else if name == HOME {
                    home = Some(numbers);
                }
            }
            _ => {
                return Err(a.invalid("finite numbers for 'qpos'", format!("'{}'", a.text("qpos").unwrap_or_default())));
            }
        }
    }
    if others > 0 {
        notes.push(format!("{others} keyframes are not used: the default pose is the one named '{HOME}'"));
    }
    Ok(home)
}
