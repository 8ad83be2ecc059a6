//! The page's own files, in the program.

/// The page.
pub const INDEX: &str = include_str!("../page/index.html");

const SCRIPT: &str = "text/javascript; charset=utf-8";
const FILES: [(&str, &str, &str); 9] = [
    ("studio.css", "text/css; charset=utf-8", include_str!("../page/studio.css")),
    ("main.js", SCRIPT, include_str!("../page/main.js")),
    ("link.js", SCRIPT, include_str!("../page/link.js")),
    ("scene.js", SCRIPT, include_str!("../page/scene.js")),
    ("timeline.js", SCRIPT, include_str!("../page/timeline.js")),
    ("strips.js", SCRIPT, include_str!("../page/strips.js")),
    ("panel.js", SCRIPT, include_str!("../page/panel.js")),
    ("keys.js", SCRIPT, include_str!("../page/keys.js")),
    ("tour.js", SCRIPT, include_str!("../page/tour.js")),
];

/// Returns media type and content of a file of the page. The renderer is that of reports, as a module.
pub fn find(name: &str) -> Option<(&'static str, String)> {
    if name == "renderer.js" {
        return Some((SCRIPT, lifelike_report::renderer_module()));
    }
    FILES.iter().find(|(known, _, _)| *known == name).map(|(_, kind, text)| (*kind, (*text).to_string()))
}
