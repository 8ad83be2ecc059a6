//! The browser of the report pages, with errors as failures of the test.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// A browser with one page.
pub struct Browser(lifelike_report::browser::Browser);

impl Browser {
    /// Starts a browser with its files in `folder`; says so and returns nothing where there is none.
    pub fn start(folder: &Path) -> Option<Self> {
        let browser = lifelike_report::browser::Browser::start(folder).unwrap();
        if browser.is_none() {
            eprintln!("NOT RUN: no Chromium here (apt install chromium)");
        }
        browser.map(Self)
    }

    /// Opens a page of a file, and waits until its program has run.
    #[allow(dead_code)] // the studio has an address
    pub fn open(&mut self, page: &Path, query: &str, size: (u32, u32), theme: &str) {
        self.open_address(&format!("file://{}{query}", page.display()), size, theme);
    }

    /// Opens an address, and waits until its program has run.
    pub fn open_address(&mut self, address: &str, size: (u32, u32), theme: &str) {
        self.0.open(address, size, theme).unwrap();
    }

    /// Sends an event of the left mouse button: `mouseMoved`, `mousePressed` or `mouseReleased`.
    #[allow(dead_code)] // of the pages, only the studio is dragged
    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let buttons = i32::from(kind != "mouseReleased");
        let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.0.call("Input.dispatchMouseEvent", event).unwrap();
    }

    /// Returns the value of an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        self.0.evaluate(expression).unwrap()
    }

    /// Returns the value of an expression that is a number.
    pub fn number(&mut self, expression: &str) -> f64 {
        self.evaluate(expression).as_f64().unwrap()
    }

    /// Exceptions and errors of the page since it was opened.
    pub fn errors(&self) -> &[String] {
        &self.0.errors
    }

    /// Folder of saved files.
    #[allow(dead_code)] // the studio saves on its own side
    pub fn downloads(&self) -> &Path {
        &self.0.downloads
    }
}

/// Waits until something holds, at most so many seconds.
pub fn within(seconds: u64, what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < Duration::from_secs(seconds), "not within {seconds} s: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}
