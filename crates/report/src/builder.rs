//! Puts the page together.

use std::path::Path;

use lifelike_character::Character;
use serde_json::{Value, json};

use super::chart::Chart;
use super::curve::Curve;
use super::drawing::Drawing;
use super::look::RobotLook;
use super::playback::Playback;
use super::scene::{character_json, contacts_json, describe_skeleton};
use super::table::{Table, escape};
use crate::ReportError;
use crate::write_atomically;

const PAGE: &str = include_str!("page/page.html");
const PLAYER: &str = include_str!("page/player.html");
const LOOK: &str = include_str!("page/look.html");
const STYLE: &str = include_str!("page/style.css");
/// In the order in which they use each other.
const SCRIPTS: [&str; 14] = [
    include_str!("page/camera.js"),
    include_str!("page/poses.js"),
    include_str!("page/shapes.js"),
    include_str!("page/plain.js"),
    include_str!("page/stage.js"),
    include_str!("page/flat.js"),
    include_str!("page/canvas.js"),
    include_str!("page/video.js"),
    include_str!("page/viewer.js"),
    include_str!("page/strip.js"),
    include_str!("page/film.js"),
    include_str!("page/curves.js"),
    include_str!("page/live.js"),
    include_str!("page/look.js"),
];
const MAIN: &str = include_str!("page/main.js");
/// Number of the first scripts, which draw.
const RENDERER: usize = 8;
/// Names that pages of others import.
const EXPORTS: &str =
    "Camera, Stage, FlatStage, unpackPose, makeStage, stageColours, fit, cross, dot, normalize, recordFilm";

/// Returns the renderer of the page as a JavaScript module, for pages with a server.
pub fn renderer_module() -> String {
    let scripts = SCRIPTS[..RENDERER].join("\n");
    format!("const query = new URLSearchParams(location.search);\n{scripts}\nexport {{ {EXPORTS} }};\n")
}

/// Initial smoothing of training curves.
const SMOOTHED: &str = "value=\"0.6\"";
const CURVES: &str = "<section>\n<div class=\"curves-head\"><h2>Curves</h2><label>smoothing <input data-is=\"smoothing\" \
                      type=\"range\" min=\"0\" max=\"0.98\" step=\"0.01\" value=\"0.6\"></label></div>\n<div \
                      data-is=\"curves\"></div>\n</section>\n";

/// A report in the making.
#[derive(Debug, Clone, Default)]
pub struct ReportBuilder {
    title: String,
    subtitle: String,
    facts: Vec<(String, String)>,
    tables: Vec<Table>,
    drawings: Vec<Drawing>,
    charts: Vec<Chart>,
    curves: Vec<Curve>,
    measured: bool,
    headlines: Vec<String>,
    curves_first: bool,
    characters: Vec<Value>,
    playbacks: Vec<Value>,
    look: Value,
}

impl ReportBuilder {
    /// Returns a report with this title.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Returns a sentence below the title.
    pub fn subtitle(mut self, text: impl Into<String>) -> Self {
        self.subtitle = text.into();
        self
    }

    /// Returns a fact below the title, such as `samples: 1.9 M`.
    pub fn fact(mut self, name: &str, value: impl Into<String>) -> Self {
        self.facts.push((name.to_string(), value.into()));
        self
    }

    /// Adds curves; [`super::curves_from`] makes them from a run's metrics.
    pub fn curves(mut self, curves: impl IntoIterator<Item = Curve>) -> Self {
        self.curves.extend(curves.into_iter().filter(|c| c.y.iter().any(|v| v.is_finite())));
        self
    }

    /// Returns the curves are shown as they are, until the reader smooths them: each point is a measurement, not a noisy iteration.
    pub fn measured(mut self) -> Self {
        self.measured = true;
        self
    }

    /// Shows the curves of these names first, and folds the others.
    pub fn headlines(mut self, names: &[&str]) -> Self {
        self.headlines = names.iter().map(|name| (*name).to_string()).collect();
        self
    }

    /// Puts the curves before the tables: for pages that are read by looking at signals.
    pub fn curves_first(mut self) -> Self {
        self.curves_first = true;
        self
    }

    /// Adds a table.
    pub fn table(mut self, table: Table) -> Self {
        self.tables.push(table);
        self
    }

    /// Adds a row of small drawings, below the tables.
    pub fn drawing(mut self, drawing: Drawing) -> Self {
        self.drawings.push(drawing);
        self
    }

    /// Adds a chart, below the tables.
    pub fn chart(mut self, chart: Chart) -> Self {
        self.charts.push(chart);
        self
    }

    /// Adds playbacks of a character. May be called for several characters.
    pub fn playback(mut self, character: &Character, playbacks: &[Playback]) -> Self {
        let drawn = character_json(character);
        let whole = playbacks.iter().filter(|p| !(p.simulated.is_empty() && p.reference.is_empty()));
        for playback in whole {
            let own = self.character(&drawn);
            let reference =
                playback.skeleton.as_ref().map_or(own, |skeleton| self.character(&describe_skeleton(skeleton)));
            self.playbacks.push(playback.to_json(own, reference, character.bodies.len()));
        }
        self
    }

    /// Shows a robot whose joints can be moved, above the tables.
    pub fn robot(mut self, robot: RobotLook<'_>) -> Self {
        let mut look = robot.to_json();
        look["visual"] = json!(self.character(&character_json(robot.character)));
        look["contacts"] = json!(self.character(&contacts_json(robot.character)));
        self.look = look;
        self
    }

    /// Returns the number of a character on the page, which is added where it is new.
    fn character(&mut self, drawn: &Value) -> usize {
        self.characters.iter().position(|known| known == drawn).unwrap_or_else(|| {
            self.characters.push(drawn.clone());
            self.characters.len() - 1
        })
    }

    /// Returns the page.
    pub fn to_html(&self) -> String {
        self.page(&Value::Null)
    }

    /// Returns the page; with `live`, one that reads its content from scripts beside it.
    pub(super) fn page(&self, live: &Value) -> String {
        let is_live = !live.is_null();
        let data = json!({
            "characters": self.characters,
            "playbacks": self.playbacks,
            "curves": self.curves,
            "headlines": self.headlines,
            "live": live,
            "look": self.look,
        });
        // Nothing inside the data may end the element that holds it.
        let data = data.to_string().replace('<', "\\u003c");
        let subtitle =
            if self.subtitle.is_empty() { String::new() } else { format!("<p>{}</p>\n", escape(&self.subtitle)) };
        let mut facts: String = self
            .facts
            .iter()
            .map(|(name, value)| format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escape(name), escape(value)))
            .collect();
        if is_live || !facts.is_empty() {
            facts = format!("<dl data-is=\"facts\">\n{facts}</dl>\n");
        }
        let hidden = |section: &str| section.replacen("<section", "<section hidden", 1);
        let player = match (self.playbacks.is_empty(), is_live) {
            (false, _) => PLAYER.to_string(),
            (true, true) => hidden(PLAYER),
            (true, false) => String::new(),
        };
        let player = if self.look.is_null() { player } else { LOOK.to_string() + &player };
        let smoothing = if self.measured { "value=\"0\"" } else { SMOOTHED };
        let curves = match (self.curves.is_empty(), is_live) {
            (false, _) => CURVES.replace(SMOOTHED, smoothing),
            (true, true) => hidden(CURVES),
            (true, false) => String::new(),
        };
        let tables = self.tables.iter().map(Table::to_html).chain(self.charts.iter().map(Chart::to_html));
        let tables: String = tables.chain(self.drawings.iter().map(Drawing::to_html)).collect();
        // Of a training that goes on, survival is of more interest than how the robot moves.
        let mut sections = match (is_live, self.curves_first) {
            (true, _) => curves + &player + &tables,
            (false, true) => player + &curves + &tables,
            (false, false) => player + &tables + &curves,
        };
        if sections.is_empty() {
            sections.push_str("<p class=\"quiet\">Nothing was recorded.</p>\n");
        }
        let script = format!("{}\n{MAIN}", SCRIPTS.join("\n"));
        fill(
            PAGE,
            &[
                ("title", &escape(&self.title)),
                ("kind", if is_live { "live" } else { "report" }),
                ("style", STYLE),
                ("subtitle", &subtitle),
                ("facts", &facts),
                ("sections", &sections),
                ("data", &data),
                ("script", &script),
            ],
        )
    }

    /// Returns the content of a live page but for its motion, as a script.
    pub(super) fn state(&self, motion: u64, done: bool) -> String {
        let state = json!({
            "facts": self.facts, "curves": self.curves, "headlines": self.headlines, "motion": motion, "done": done,
        });
        format!("window.lifelikeState({state});\n")
    }

    /// Returns the motion of a live page, as a script.
    pub(super) fn motion(&self) -> String {
        let motion = json!({ "characters": self.characters, "playbacks": self.playbacks });
        format!("window.lifelikeMotion({motion});\n")
    }

    /// Writes the page.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn write(&self, path: &Path) -> Result<(), ReportError> {
        write_atomically(path, self.to_html().as_bytes())
    }
}

/// Replaces each `{{name}}` of the template, once and from left to right: what is filled in is never searched again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out = String::with_capacity(template.len() + values.iter().map(|(_, v)| v.len()).sum::<usize>());
    let mut rest = template;
    while let Some(start) = rest.find("{{") {
        out.push_str(&rest[..start]);
        let Some(length) = rest[start..].find("}}") else { break };
        let name = &rest[start + 2..start + length];
        out.push_str(values.iter().find(|(n, _)| *n == name).map_or("", |(_, v)| v));
        rest = &rest[start + length + 2..];
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_are_filled_once() {
        assert_eq!(fill("<{{a}}|{{b}}|{{none}}>", &[("a", "{{b}}"), ("b", "2")]), "<{{b}}|2|>");
    }

    #[test]
    fn measured_curves_are_not_smoothed_at_first() {
        let page = || {
            ReportBuilder::new("").curves([Curve { name: "a".into(), x: vec![0.0], y: vec![1.0], ..Curve::default() }])
        };
        assert!(page().to_html().contains(SMOOTHED));
        let measured = page().measured().to_html();
        assert!(measured.contains("data-is=\"curves\"") && !measured.contains(SMOOTHED));
    }

    #[test]
    fn the_page_is_whole_and_asks_nobody_for_anything() {
        let hostile = "</script><script>alert(1)</script>";
        let html = ReportBuilder::new(hostile)
            .fact("samples", hostile)
            .curves([Curve { name: hostile.into(), x: vec![0.0, 1.0], y: vec![1.0, f64::NAN], ..Curve::default() }])
            .table(Table::new(hostile, vec![]))
            .to_html();
        assert!(!html.contains("alert(1)</script>"), "nothing from outside becomes markup");
        assert_eq!(html.matches("<script").count(), 2, "the data and the program");
        for outside in ["src=\"", "@import", "fetch(", "XMLHttpRequest", "import("] {
            assert!(!html.contains(outside), "{outside}");
        }
        // The only address is the name of the SVG language.
        assert_eq!(html.matches("http").count(), html.matches("http://www.w3.org/2000/svg").count());
        let start = html.find("id=\"data\">").map_or(0, |at| at + "id=\"data\">".len());
        let end = start + html[start..].find("</script>").unwrap_or(0);
        let data: Value = serde_json::from_str(&html[start..end]).unwrap_or_default();
        assert_eq!(data["curves"][0]["name"], hostile);
        assert!(data["curves"][0]["y"][1].is_null(), "a gap");
    }
}
