//! A studio that is served, and its page in a browser.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use super::browser::{Browser, within};

/// A running `lifelike studio`.
pub struct Served {
    process: Child,
    /// Address that may change the scene.
    pub address: String,
    /// Address that may watch.
    pub watch: String,
}

impl Served {
    /// Starts it in a folder.
    pub fn start(folder: &Path, scene: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_lifelike"))
            .args(["studio", scene, "--no-browser", "--json"])
            .current_dir(folder)
            .env("XDG_CACHE_HOME", folder.join("cache"))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines().map(Result::unwrap);
        let mut text = String::new();
        for line in lines {
            text += &line;
            if line == "}" {
                break;
            }
        }
        let value: Value = serde_json::from_str(&text).unwrap();
        let address = |key: &str| value[key].as_str().unwrap().to_string();
        Self { process, address: address("address"), watch: address("watch") }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The page.
pub struct Page {
    /// Its browser.
    pub browser: Browser,
}

impl Page {
    /// Opens the page without its tour, and waits for the first frame.
    pub fn open(mut browser: Browser, address: &str) -> Self {
        browser.open_address(&format!("{address}?no-tour"), (1280, 720), "light");
        let mut page = Self { browser };
        page.until("the first frame", "studio.head !== null && studio.view !== null");
        page
    }

    /// Returns the value of an expression.
    pub fn value(&mut self, expression: &str) -> Value {
        self.browser.evaluate(expression)
    }

    /// Runs a statement.
    pub fn run(&mut self, statement: &str) {
        self.value(&format!("(() => {{ {statement}; }})()"));
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, what: &str, expression: &str) {
        within(60, what, || self.value(&format!("Boolean({expression})")) == json!(true));
    }

    /// Types a sentence into its field, and presses the button.
    pub fn say(&mut self, text: &str) {
        let text = json!(text);
        self.run(&format!("document.querySelector('[data-is=sentence]').value = {text}"));
        self.run("document.querySelector('.go').click()");
    }

    /// Does what a key does.
    pub fn act(&mut self, name: &str) {
        self.run(&format!("studio.act('{name}')"));
    }

    /// Presses the mouse on the robot, drags it some pixels to the right, holds it for a while, and lets go.
    pub fn pull(&mut self, pixels: f64) {
        let place = self.value(
            "(() => { const all = []; const box = studio.scene.canvas.getBoundingClientRect();
             for (let y = box.top; y < box.bottom; y += 8) for (let x = box.left; x < box.right - 300; x += 8)
               if (studio.scene.pick(x, y) !== null) all.push([x, y]);
             return all[all.length >> 1]; })()",
        );
        let (x, y) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
        self.browser.mouse("mouseMoved", x, y);
        self.browser.mouse("mousePressed", x, y);
        for step in 1..=6 {
            self.browser.mouse("mouseMoved", x + pixels * f64::from(step) / 6.0, y);
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        self.until("the force acts", "studio.head.force > 0 && studio.head.playing");
        std::thread::sleep(std::time::Duration::from_millis(200));
        self.browser.mouse("mouseReleased", x + pixels, y);
    }

    /// Drops a file on the page.
    pub fn drop(&mut self, name: &str, content: &str) {
        let (name, content) = (json!(name), json!(content));
        self.run(&format!(
            "const files = new DataTransfer(); files.items.add(new File([{content}], {name}));
             dispatchEvent(new DragEvent('drop', {{ dataTransfer: files, cancelable: true }}))"
        ));
    }

    /// Returns the number of colours on the canvas, in 32 steps a channel.
    pub fn colours(&mut self) -> f64 {
        self.browser.number(
            "(() => { const small = document.createElement('canvas'); [small.width, small.height] = [64, 64];
             const context = small.getContext('2d');
             context.drawImage(document.querySelector('[data-is=canvas]'), 0, 0, 64, 64);
             const { data } = context.getImageData(0, 0, 64, 64); const seen = new Set();
             for (let i = 0; i < data.length; i += 4) seen.add(data[i] >> 3 << 10 | data[i + 1] >> 3 << 5 | data[i + 2] >> 3);
             return seen.size; })()",
        )
    }

    /// Fails where the page reported an error. A refused file is one that the browser logs by itself.
    pub fn no_errors(&mut self) {
        self.value("1");
        let errors: Vec<&String> = self.browser.errors().iter().filter(|error| !error.contains("broken.bvh")).collect();
        assert!(errors.is_empty(), "{errors:?}");
    }
}
