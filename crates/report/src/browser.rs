//! Chromium without a window, driven by its DevTools protocol through two pipes.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::{FromInput, ReportError};

const PROGRAMS: [&str; 5] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
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
/// Longest life of a browser (s): one that hangs is ended.
const LIFE: &str = "3600";

/// A browser with one page.
#[derive(Debug)]
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
    /// Starts a browser with its files in `folder`. Returns nothing where no Chromium is installed.
    ///
    /// # Errors
    /// The browser does not start, or ends at once.
    pub fn start(folder: &Path) -> Result<Option<Self>, ReportError> {
        let Some(program) = installed() else { return Ok(None) };
        let home = folder.join("browser");
        let downloads = home.join("downloads");
        std::fs::create_dir_all(&downloads).map_err(ReportError::io(&downloads))?;
        let pipes = Command::new("mkfifo").args(["to", "from"]).current_dir(&home).status();
        if !pipes.map_err(ReportError::io(&home))?.success() {
            return Err(failed("mkfifo", "no named pipes in the temporary folder"));
        }
        // The protocol's pipes are the file descriptors 3 and 4.
        let mut shell = Command::new("sh");
        shell.args(["-c", "exec timeout \"$0\" \"$@\" 3<to 4>from", LIFE, &program]).args(ARGUMENTS);
        shell.arg(format!("--user-data-dir={}", home.join("profile").display()));
        shell.current_dir(&home).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let process = shell.spawn().map_err(ReportError::io(Path::new(&program)))?;
        let pipe = |name: &str, write: bool| {
            let path = home.join(name);
            File::options().write(write).read(!write).open(&path).map_err(ReportError::io(&path))
        };
        let (commands, messages) = (pipe("to", true)?, BufReader::new(pipe("from", false)?));
        let mut browser = Self { process, commands, messages, session: None, number: 0, errors: Vec::new(), downloads };
        let saved = json!({ "behavior": "allow", "downloadPath": browser.downloads });
        browser.call("Browser.setDownloadBehavior", saved)?;
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }))?["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }))?;
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for part in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(part, json!({}))?;
        }
        Ok(Some(browser))
    }

    /// Calls a method of the protocol, and waits for its result; errors of the page are kept meanwhile.
    ///
    /// # Errors
    /// The method fails, or the browser has ended.
    pub fn call(&mut self, method: &str, parameters: Value) -> Result<Value, ReportError> {
        self.number += 1;
        let mut message = json!({ "id": self.number, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let ended = |_| failed(method, "the browser has ended");
        self.commands.write_all(format!("{message}\0").as_bytes()).map_err(ended)?;
        loop {
            let mut bytes = Vec::new();
            if self.messages.read_until(0, &mut bytes).map_err(ended)? == 0 {
                return Err(failed(method, "the browser has ended"));
            }
            bytes.pop();
            let mut message: Value =
                serde_json::from_slice(&bytes).map_err(|error| failed(method, &error.to_string()))?;
            if message["id"] == json!(self.number) {
                let refused = message["error"]["message"].as_str().map(|text| failed(method, text));
                return refused.map_or_else(|| Ok(message["result"].take()), Err);
            }
            self.errors.extend(error_in(&message));
        }
    }

    /// Opens an address on a screen of `width x height` pixels, with the theme `light` or `dark`. Waits until the page has
    /// set `data-ready` on its root element.
    ///
    /// # Errors
    /// The page is not ready within a minute.
    pub fn open(&mut self, address: &str, (width, height): (u32, u32), theme: &str) -> Result<(), ReportError> {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", screen)?;
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": theme }] });
        self.call("Emulation.setEmulatedMedia", media)?;
        self.call("Page.navigate", json!({ "url": "about:blank" }))?;
        self.errors.clear();
        self.call("Page.navigate", json!({ "url": address }))?;
        let began = Instant::now();
        while self.evaluate("document.documentElement?.dataset.ready ?? ''")? != json!("1") {
            if began.elapsed() > Duration::from_secs(60) {
                let errors = self.errors.join("; ");
                return Err(failed(address, &format!("the page is not ready after 60 s {errors}")));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// Returns the value of an expression in the page; of a promise, its result.
    ///
    /// # Errors
    /// The expression throws.
    pub fn evaluate(&mut self, expression: &str) -> Result<Value, ReportError> {
        let question = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", question)?;
        let thrown = &answer["exceptionDetails"];
        if thrown.is_null() {
            return Ok(answer["result"]["value"].take());
        }
        let text = thrown["exception"]["description"].as_str().or(thrown["text"].as_str()).unwrap_or("an exception");
        Err(failed(expression, text))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.commands.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.process.wait();
    }
}

/// Returns the Chromium on the path, where pipes can be passed to it. `LIFELIKE_BROWSER` names another; empty means none.
fn installed() -> Option<String> {
    let runs = |program: &String| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    if cfg!(not(unix)) {
        return None;
    }
    match std::env::var("LIFELIKE_BROWSER") {
        Ok(named) => Some(named).filter(runs),
        Err(_) => PROGRAMS.map(String::from).into_iter().find(runs),
    }
}

fn failed(what: &str, reason: &str) -> ReportError {
    ReportError::Browser { what: what.chars().take(120).collect(), reason: reason.to_string() }
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
