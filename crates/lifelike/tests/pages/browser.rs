//! Chromium without a window, driven by its DevTools protocol through two pipes.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// WebGL without a graphics card; nothing is asked of any network.
const ARGUMENTS: [&str; 9] = [
    "--headless",
    "--remote-debugging-pipe",
    "--no-sandbox",
    "--no-first-run",
    "--disable-gpu",
    "--disable-background-networking",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "about:blank",
];

/// A browser with one page.
pub struct Browser {
    process: Child,
    commands: File,
    messages: BufReader<File>,
    session: Option<String>,
    number: u64,
    /// Exceptions and errors of the page since it was opened.
    pub errors: Vec<String>,
    /// Folder of saved files.
    pub downloads: PathBuf,
}

impl Browser {
    /// Starts a browser with its files in `folder`; says so and returns nothing where there is none.
    pub fn start(folder: &Path) -> Option<Self> {
        let is_there =
            |program: &&&str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
        let Some(program) = PROGRAMS.iter().find(is_there) else {
            eprintln!("NOT RUN: no Chromium here (apt install chromium)");
            return None;
        };
        let home = folder.join("browser");
        std::fs::create_dir(&home).unwrap();
        assert!(Command::new("mkfifo").args(["to", "from"]).current_dir(&home).status().unwrap().success());
        // The protocol's pipes are the file descriptors 3 and 4. A browser that hangs is ended.
        let mut shell = Command::new("sh");
        shell.args(["-c", "exec timeout 580 \"$0\" \"$@\" 3<to 4>from", program]).args(ARGUMENTS);
        shell.arg(format!("--user-data-dir={}", home.join("profile").display()));
        let process = shell.current_dir(&home).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let commands = File::options().write(true).open(home.join("to")).unwrap();
        let messages = BufReader::new(File::open(home.join("from")).unwrap());
        let downloads = home.join("downloads");
        std::fs::create_dir(&downloads).unwrap();
        let mut browser = Self { process, commands, messages, session: None, number: 0, errors: Vec::new(), downloads };
        let saved = json!({ "behavior": "allow", "downloadPath": browser.downloads });
        browser.call("Browser.setDownloadBehavior", saved);
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for part in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(part, json!({}));
        }
        Some(browser)
    }

    /// Calls a method, and waits for its result; what the page reports meanwhile is kept.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut message = json!({ "id": self.number, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut bytes = Vec::new();
            let length = self.messages.read_until(0, &mut bytes).unwrap();
            assert!(length > 0, "the browser ended during {method}");
            let mut message: Value = serde_json::from_slice(&bytes[..length - 1]).unwrap();
            if message["id"] == json!(self.number) {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].take();
            }
            self.errors.extend(error_in(&message));
        }
    }

    /// Opens a page of a file, and waits until its program has run.
    #[allow(dead_code)] // the studio has an address
    pub fn open(&mut self, page: &Path, query: &str, screen: (u32, u32), theme: &str) {
        self.open_address(&format!("file://{}{query}", page.display()), screen, theme);
    }

    /// Opens an address, and waits until its program has run.
    pub fn open_address(&mut self, address: &str, (width, height): (u32, u32), theme: &str) {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", screen);
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": theme }] });
        self.call("Emulation.setEmulatedMedia", media);
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.errors.clear();
        self.call("Page.navigate", json!({ "url": address }));
        within(60, &format!("{address} is ready"), || {
            self.evaluate("document.documentElement?.dataset.ready ?? ''") == json!("1")
        });
    }

    /// Returns the value of an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let question = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", question);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].take()
    }

    /// Sends an event of the left mouse button: `mouseMoved`, `mousePressed` or `mouseReleased`.
    #[allow(dead_code)] // of the pages, only the studio is dragged
    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let buttons = i32::from(kind != "mouseReleased");
        let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Returns the value of an expression that is a number.
    pub fn number(&mut self, expression: &str) -> f64 {
        self.evaluate(expression).as_f64().unwrap()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.commands.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.process.wait();
    }
}

/// Returns the error that an event of the protocol reports.
fn error_in(event: &Value) -> Option<String> {
    let (method, of) = (event["method"].as_str()?, &event["params"]);
    let is_error = match method {
        "Runtime.exceptionThrown" => true,
        "Runtime.consoleAPICalled" => of["type"] == json!("error"),
        "Log.entryAdded" => of["entry"]["level"] == json!("error"),
        _ => false,
    };
    is_error.then(|| of.to_string())
}

/// Waits until something holds, at most so many seconds.
pub fn within(seconds: u64, what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < Duration::from_secs(seconds), "not within {seconds} s: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}
