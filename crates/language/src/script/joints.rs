//! Joints and movements by their clinical names.

use super::geometry::{ARTICLES, has};

/// "Right shoulder flexion 90 degrees", "abduct the left arm", "elbow fully extended": joints as physiotherapists name them.
pub(super) fn by_joints(words: Vec<String>) -> Vec<String> {
    const JOINTS: [&str; 10] =
        ["shoulder", "shoulders", "elbow", "elbows", "knee", "knees", "hip", "hips", "neck", "trunk"];
    let way = |joint: &str, movement: &str| match (joint.trim_end_matches('s'), movement) {
        ("shoulder", "flexion" | "flex") => Some("arm forward"),
        ("shoulder", "abduction" | "abduct") => Some("arm to the side"),
        ("shoulder", "adduction" | "adduct") => Some("arm down"),
        ("shoulder", "extension") => Some("arm back"),
        ("elbow", "flexion" | "flex") => Some("elbow bent"),
        ("elbow", "extension" | "extended") => Some("elbow straight"),
        ("knee", "flexion" | "flex") => Some("knee bent"),
        ("hip", "flexion" | "flex") => Some("thigh forward"),
        ("hip", "abduction" | "abduct") => Some("leg to the side"),
        ("hip", "extension") => Some("leg back"),
        ("neck", "flexion" | "flex") => Some("head down"),
        ("neck", "extension") => Some("head back"),
        ("trunk", "flexion" | "flex") => Some("trunk forward"),
        _ => None,
    };
    let mut out: Vec<String> = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let verb = ["flex", "abduct", "adduct"].contains(&words[at].as_str()).then(|| {
            let skipped = words[at + 1..]
                .iter()
                .take_while(|word| has(&ARTICLES, Some(word)) || has(&["left", "right"], Some(word)));
            at + 1 + skipped.count()
        });
        // "Abduct the left arm": at the shoulder.
        let named = |joint: usize| match words.get(joint).map(String::as_str) {
            Some("arm" | "arms") if words[at] != "flex" => Some("shoulder"),
            Some("leg" | "legs") => Some("hip"),
            Some(joint) if JOINTS.contains(&joint) => Some(joint),
            _ => None,
        };
        let by_verb = verb.and_then(|joint| Some((joint, named(joint)?)));
        let found = match by_verb {
            Some((joint, name)) => way(name, &words[at]).map(|way| (words[at + 1..joint].to_vec(), joint, way)),
            None if JOINTS.contains(&words[at].as_str()) => {
                let fully = usize::from(has(&["fully", "completely", "full", "joint"], words.get(at + 1)));
                let movement = words.get(at + 1 + fully).map_or("", String::as_str);
                way(&words[at], movement).map(|way| (Vec::new(), at + 1 + fully, way))
            }
            None => None,
        };
        let Some((before, end, way)) = found else {
            out.push(words[at].clone());
            at += 1;
            continue;
        };
        let is_plural = words[at..=end].iter().any(|word| JOINTS.contains(&word.as_str()) && word.ends_with('s'))
            || words[at..=end].iter().any(|word| word == "arms" || word == "legs");
        out.extend(before);
        let mut parts = way.split(' ').map(str::to_string);
        out.extend(parts.next().map(|limb| if is_plural { limb + "s" } else { limb }));
        out.extend(parts);
        at = end + 1 + usize::from(has(&["to", "of", "at"], words.get(end + 1)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::split::normal;

    #[test]
    fn movements_of_joints_are_ways_of_limbs() {
        for (text, plain) in [
            (
                "right shoulder flexion 90 degrees, elbow fully extended",
                "right arm forward 90 degrees , elbow straight",
            ),
            ("abduct both arms to 45 degrees", "both arms to the side 45 degrees"),
            ("flex your elbows to 90 degrees", "your elbows bent 90 degrees"),
        ] {
            assert_eq!(normal(text).join(" "), plain, "{text}");
        }
    }
}
