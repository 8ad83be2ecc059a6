//! Viewers that misbehave: one that stops reading, ten at once, a hundred cut connections, strangers, a robot of 80 bodies.

#![allow(clippy::unwrap_used)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lifelike_generation::generator::Generator;
use lifelike_robot::{Controller, Robot};
use lifelike_studio::{Document, Policies, Scene, Stage, Studio};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

fn assets(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../lifelike/assets").join(name)
}

/// Starts a studio of a robot; returns its addresses.
fn start(folder: &Path, robot: &str) -> [String; 2] {
    let robot = Arc::new(Robot::load(robot).unwrap());
    let controller = Controller::load(&assets("lima-path.controller.safetensors"), robot).unwrap();
    let generator = Generator::load(&assets("lima.generator.safetensors")).unwrap();
    let generator = Some(Arc::new(generator));
    let (policies, controller) = (Policies::default(), Arc::new(controller));
    let stage = Stage { controller, generator, spline: None, prior: None, folder: folder.into(), policies };
    let document = Document::open(&folder.join("a.scene.toml"), Scene::default).unwrap();
    let studio = Studio::new(stage, document, 0, false, Arc::new(|_| String::new())).unwrap();
    let addresses = studio.addresses();
    std::thread::spawn(move || studio.serve().unwrap());
    addresses
}

struct Viewer {
    socket: WebSocket<TcpStream>,
}

impl Viewer {
    fn open(address: &str) -> Self {
        let origin = address.split('/').take(3).collect::<Vec<_>>().join("/");
        Self::with_origin(address, &origin).unwrap()
    }

    fn with_origin(address: &str, origin: &str) -> Result<Self, String> {
        let host = address.split('/').nth(2).unwrap();
        let mut request = format!("{}live", address.replace("http", "ws")).into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let stream = TcpStream::connect(host).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let (socket, _) = tungstenite::client(request, stream).map_err(|error| error.to_string())?;
        Ok(Self { socket })
    }

    fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap();
    }

    /// Reads and acknowledges the next payload.
    fn next(&mut self) -> Message {
        let message = self.socket.read().unwrap();
        let answer = matches!(&message, Message::Text(text) if text.starts_with("{\"refused"));
        if !answer {
            self.send("seen");
        }
        message
    }

    /// Reads until a frame for which something holds; returns its frame, simulated frames and length.
    fn frame(&mut self, holds: impl Fn(u8, [u32; 3]) -> bool) -> ([u32; 3], usize) {
        loop {
            let Message::Binary(packet) = self.next() else { continue };
            let count = |at: usize| u32::from_le_bytes(packet[at..at + 4].try_into().unwrap());
            if packet[0] == 1 && holds(packet[1], [8, 12, 16].map(count)) {
                return ([8, 12, 16].map(count), packet.len());
            }
        }
    }

    /// Reads until a frame is under a held force, or free of one.
    fn until_force(&mut self, held: bool) {
        loop {
            let Message::Binary(packet) = self.next() else { continue };
            if packet[0] == 1 && (packet[28..32] != [0; 4]) == held {
                return;
            }
        }
    }

    fn settle(&mut self) -> [u32; 3] {
        self.frame(|flags, [_, known, frames]| flags & 4 == 0 && known == frames && frames > 200).0
    }
}

const SAY: &str = r#"{"operation":{"do":"say","text":"a person walks forward"}}"#;

fn get(address: &str, path: &str, headers: &str) -> String {
    let host = address.split('/').nth(2).unwrap();
    let word = address.split('/').nth(3).unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    let host = if headers.contains("Host:") { String::new() } else { format!("Host: {host}\r\n") };
    write!(stream, "GET /{word}/{path} HTTP/1.1\r\n{host}{headers}Connection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap_or_default();
    answer
}

#[test]
fn one_that_stops_reading_and_ten_that_read_and_a_hundred_that_are_cut() {
    let folder = tempfile::tempdir().unwrap();
    let [edit, watch] = start(folder.path(), "lima");
    let mut viewer = Viewer::open(&edit);
    viewer.send(SAY);
    let [_, _, frames] = viewer.settle();
    // One never acknowledges, and reads nothing.
    let mut silent = Viewer::open(&edit);
    let mut others: Vec<Viewer> = (0..10).map(|_| Viewer::open(&watch)).collect();
    for _ in 0..100 {
        let cut = Viewer::open(&edit);
        drop(cut.socket.get_ref().shutdown(std::net::Shutdown::Both));
    }
    viewer.send(r#"{"seek":0}"#);
    viewer.send(r#"{"play":true}"#);
    let began = Instant::now();
    let (mut seen, mut last) = (0, 0);
    while began.elapsed() < Duration::from_secs(3) {
        let ([frame, ..], _) = viewer.frame(|_, _| true);
        (seen, last) = (seen + 1, frame);
        for other in &mut others {
            let _ = other.next();
        }
    }
    let lag = 50.0 * began.elapsed().as_secs_f64() - f64::from(last);
    println!("3 s with ten viewers: {seen} frames drawn by the first, the last {lag:.1} frames old");
    assert!(lag < 15.0, "the clock went on: frame {last} of {frames}");
    // The silent one has three payloads in flight, and now gets the newest state, not three seconds of it.
    let mut late = 0;
    loop {
        let Message::Binary(packet) = silent.next() else { continue };
        if packet[0] != 1 {
            continue;
        }
        late += 1;
        let frame = u32::from_le_bytes(packet[8..12].try_into().unwrap());
        if frame >= last {
            break;
        }
        assert!(late < 5, "{late} old frames were queued");
    }
}

#[test]
fn strangers_are_refused_and_nobody_leads_out_of_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    std::fs::write(folder.path().join("secret.bvh"), "HIERARCHY").unwrap();
    let [edit, watch] = start(&folder.path().join("scenes"), "lima");
    assert!(get(&edit, "", "").starts_with("HTTP/1.1 200"));
    assert!(get(&edit, "renderer.js", "").contains("export { Camera"));
    assert!(get(&edit, "", "Host: evil.example\r\n").starts_with("HTTP/1.1 403"));
    assert!(get(&edit, "", "Origin: http://evil.example\r\n").starts_with("HTTP/1.1 403"));
    assert!(
        get("http://x/y".replace('x', edit.split('/').nth(2).unwrap()).as_str(), "", "").starts_with("HTTP/1.1 403")
    );
    for path in ["../secret.bvh", "..%2fsecret.bvh", "%2e%2e/secret.bvh", "export/..%2f", "Cargo.toml"] {
        let answer = get(&edit, path, "");
        assert!(!answer.starts_with("HTTP/1.1 200") && !answer.contains("HIERARCHY"), "{path}: {answer}");
    }
    assert!(Viewer::with_origin(&edit, "http://evil.example").is_err());
    // A watcher sees, and changes nothing.
    let mut watcher = Viewer::open(&watch);
    watcher.send(SAY);
    loop {
        if let Message::Text(text) = watcher.next()
            && text.contains("may only watch")
        {
            break;
        }
    }
    assert!(!folder.path().join("scenes/a.scene.toml").exists());
    // Nonsense is answered, and the connection stays.
    let mut viewer = Viewer::open(&edit);
    for text in ["", "{", "{\"seek\":\"x\"}", "{\"rate\":99}", "{\"seek\":1e999}", "{\"step\":-9223372036854775808}"] {
        viewer.send(text);
    }
    let outside = r#"{"operation":{"do":"add","clip":"../secret.bvh"}}"#;
    viewer.send(outside);
    loop {
        if let Message::Text(text) = viewer.next()
            && text.contains("expected a file below")
        {
            break;
        }
    }
}

#[test]
fn a_robot_of_eighty_bodies_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot/robots");
    let model = std::fs::read_to_string(robots.join("lima.xml")).unwrap();
    let at = model.rfind("</worldbody>").unwrap();
    let at = model[..at].rfind("</body>").unwrap();
    let beads: String = (0..60)
        .map(|i| {
            let x = 0.001 * f64::from(i);
            format!("<body name=\"bead{i}\" pos=\"{x} 0 0.05\"><inertial pos=\"0 0 0\" mass=\"1e-5\" diaginertia=\"1e-9 1e-9 1e-9\"/></body>\n")
        })
        .collect();
    let file = folder.path().join("beads.xml");
    std::fs::write(&file, format!("{}{beads}{}", &model[..at], &model[at..])).unwrap();
    std::fs::copy(robots.join("lima.toml"), folder.path().join("beads.toml")).unwrap();
    let [edit, _] = start(folder.path(), file.to_str().unwrap());
    let mut viewer = Viewer::open(&edit);
    viewer.send(SAY);
    viewer.settle();
    viewer.send(r#"{"play":true}"#);
    let (_, length) = viewer.frame(|_, [frame, ..]| frame > 100);
    println!("81 bodies: {length} bytes a frame");
    assert!(length < 4000 && length > 32 + 28 * 80);
}

/// Returns a share of sorted times (ms).
fn at(times: &[f64], share: f64) -> f64 {
    times[((times.len() - 1) as f64 * share) as usize]
}

#[test]
fn pushes_and_sentences_are_answered_soon() {
    let folder = tempfile::tempdir().unwrap();
    let [edit, _] = start(folder.path(), "lima");
    let mut viewer = Viewer::open(&edit);
    viewer.send(SAY);
    viewer.settle();
    let body = Robot::load("lima").unwrap().character.bodies[1].name.clone();
    viewer.send(r#"{"seek":0}"#);
    viewer.send(r#"{"play":true}"#);
    let mut times = Vec::new();
    for i in 0..60 {
        viewer.until_force(false);
        let began = Instant::now();
        viewer.send(&format!(r#"{{"pull":{{"body":"{body}","newtons":[{},0,0]}}}}"#, 10 + i % 3));
        // A frame with a force is the one after the push.
        viewer.until_force(true);
        times.push(1e3 * began.elapsed().as_secs_f64());
        viewer.send("\"release\"");
        std::thread::sleep(Duration::from_millis(13));
        if i % 20 == 19 {
            viewer.send(r#"{"seek":0}"#);
            viewer.send(r#"{"play":true}"#);
        }
    }
    times.sort_by(f64::total_cmp);
    println!("push to the first changed frame: median {:.1} ms, p95 {:.1} ms", at(&times, 0.5), at(&times, 0.95));
    let mut said = Vec::new();
    for i in 0..10 {
        let began = Instant::now();
        viewer.send(&format!(r#"{{"operation":{{"do":"say","text":"a person waves","index":{i}}}}}"#));
        let built = |text: &str| {
            text.contains("\"building\":false") && text.contains(&format!("\"id\":\"m{}\",\"from\"", i + 2))
        };
        loop {
            if let Message::Text(text) = viewer.next()
                && built(&text)
            {
                break;
            }
        }
        said.push(1e3 * began.elapsed().as_secs_f64());
    }
    said.sort_by(f64::total_cmp);
    println!("sentence to its motion in physics: median {:.0} ms, worst {:.0} ms", at(&said, 0.5), at(&said, 1.0));
}

/// Memory during four minutes of edits and pulls, printed for `docs/results/studio.md`.
#[test]
#[ignore = "takes four minutes"]
fn memory_stays_flat() {
    let folder = tempfile::tempdir().unwrap();
    let [edit, _] = start(folder.path(), "lima");
    let mut viewer = Viewer::open(&edit);
    (0..3).for_each(|_| viewer.send(SAY));
    viewer.settle();
    let megabytes = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1e3
    };
    let (began, mut minutes, mut edits) = (Instant::now(), 0, 0);
    while minutes < 4 {
        let _ = viewer.next();
        let seconds = began.elapsed().as_secs();
        if seconds >= 3 * edits {
            edits += 1;
            viewer.send(r#"{"seek":0}"#);
            viewer.send(r#"{"play":true}"#);
            viewer.send(r#"{"operation":{"do":"mirror","id":"m2"}}"#);
            viewer.send("\"undo\"");
            viewer.send(r#"{"pull":{"body":"pelvis","newtons":[20,0,0]}}"#);
            // Some frames of the clock, so that there is a pull to undo.
            std::thread::sleep(Duration::from_millis(100));
            viewer.send("\"release\"");
            viewer.send("\"undo\"");
        }
        if seconds >= 60 * (minutes + 1) {
            minutes += 1;
            println!("after {minutes} min: {:.1} MB", megabytes());
        }
    }
}
