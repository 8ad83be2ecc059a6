//! The server: the page, one WebSocket for each viewer, files in and out. Loopback only.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Sender;

use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post, put};
use lifelike_character::Role;
use tokio::net::TcpListener;
use tokio::sync::oneshot;

use crate::access::{Access, Permission};
use crate::document::Document;
use crate::engine::Engine;
use crate::request::{Message, Screen};
use crate::scene::Scene;
use crate::stage::{self, Stage};
use crate::{StudioError, assets, files, socket};

/// Largest file that may be dropped (bytes).
const MAX_DROP: usize = 64 << 20;

/// Returns the command line that runs a scene on a robot.
pub type RunCommand = dyn Fn(&Scene) -> String + Send + Sync;

/// Parts that every request needs.
#[derive(Clone)]
struct Shared {
    access: Arc<Access>,
    engine: Sender<Message>,
    screen: Screen,
    stage: Arc<Stage>,
    scene: PathBuf,
    command: Arc<RunCommand>,
}

/// A studio that is ready to be opened.
pub struct Studio {
    listener: std::net::TcpListener,
    shared: Shared,
}

impl Studio {
    /// Starts the engine and takes a port of this machine, any free one for 0. With `read_only` nobody may change the scene.
    /// The page shows the command line of `command`.
    ///
    /// # Errors
    /// The port is taken, or the robot cannot be simulated.
    pub fn new(
        stage: Stage,
        document: Document,
        port: u16,
        read_only: bool,
        command: Arc<RunCommand>,
    ) -> Result<Self, StudioError> {
        let failed = |error: std::io::Error| StudioError::Server(error.to_string());
        let listener = std::net::TcpListener::bind(("127.0.0.1", port)).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let (scene, folder) = (document.path().to_path_buf(), Arc::new(stage.clone()));
        let (engine, screen) = Engine::start(stage, document)?;
        let access = Arc::new(Access::new(port, read_only)?);
        Ok(Self { listener, shared: Shared { access, engine, screen, stage: folder, scene, command } })
    }

    /// Returns the address that may change the scene, and the one that may only watch.
    pub fn addresses(&self) -> [String; 2] {
        [Permission::Edit, Permission::Watch].map(|permission| self.shared.access.address(permission))
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// [`StudioError::Server`].
    pub fn serve(self) -> Result<(), StudioError> {
        let failed = |error: std::io::Error| StudioError::Server(error.to_string());
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build().map_err(failed)?;
        runtime.block_on(async move {
            let listener = TcpListener::from_std(self.listener).map_err(failed)?;
            let routes = Router::new()
                .route("/{word}/", get(page))
                .route("/{word}/live", get(live))
                .route("/{word}/robot.json", get(robot))
                .route("/{word}/export/{what}", get(export))
                .route("/{word}/drop/{name}", put(dropped))
                .route("/{word}/run", post(run))
                .route("/{word}/{file}", get(file))
                .layer(DefaultBodyLimit::max(MAX_DROP))
                .with_state(self.shared);
            axum::serve(listener, routes).await.map_err(failed)
        })
    }
}

/// A response with headers that keep it out of caches and other pages.
fn reply(kind: &'static str, body: impl Into<axum::body::Body>) -> Response {
    let policy = "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self' \
                  ws://127.0.0.1:* ws://localhost:*; base-uri 'none'; frame-ancestors 'none'";
    let headers = [
        (CONTENT_TYPE.as_str(), kind),
        (CACHE_CONTROL.as_str(), "no-store"),
        ("content-security-policy", policy),
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
    ];
    (headers, body.into()).into_response()
}

fn refused() -> Response {
    (StatusCode::FORBIDDEN, "open the address that `lifelike studio` printed").into_response()
}

async fn page(State(shared): State<Shared>, Path(word): Path<String>, headers: HeaderMap) -> Response {
    match shared.access.of(&word, &headers, false) {
        Some(_) => reply("text/html; charset=utf-8", assets::INDEX),
        None => refused(),
    }
}

async fn file(
    State(shared): State<Shared>,
    Path((word, file)): Path<(String, String)>,
    headers: HeaderMap,
) -> Response {
    if shared.access.of(&word, &headers, false).is_none() {
        return refused();
    }
    match assets::find(&file) {
        Some((kind, text)) => reply(kind, text),
        None => (StatusCode::NOT_FOUND, "no such file").into_response(),
    }
}

async fn robot(State(shared): State<Shared>, Path(word): Path<String>, headers: HeaderMap) -> Response {
    if shared.access.of(&word, &headers, false).is_none() {
        return refused();
    }
    let robot = shared.stage.robot();
    let scalar = |name: &String| robot.character.joints.iter().find(|joint| joint.name == *name);
    let body_of = |joint: &lifelike_character::Joint| joint.body.saturating_sub(1);
    let bodies: Vec<usize> = robot.layout.joints.iter().map(|name| scalar(name).map_or(0, body_of)).collect();
    let value = serde_json::json!({
        "character": lifelike_report::character_json(&robot.character),
        "hz": robot.control_hz,
        "joints": robot.layout.joints,
        "jointBodies": bodies,
        "heaviest": heaviest(robot),
        "weight": robot.character.mass() * robot.character.gravity.norm(),
        "handles": handles(robot),
        "parts": PARTS,
        "bends": shared.stage.spline.as_ref().map_or(0.0, |spline| spline.spacing()),
        "searches": shared.stage.prior.is_some(),
        "policies": shared.stage.policies.names,
        "clips": files::clips(&shared.stage.folder),
        "mayEdit": shared.access.of(&word, &headers, false) == Some(Permission::Edit),
    });
    reply("application/json", value.to_string())
}

/// Parts of the body that are laid over other motion.
const PARTS: [&str; 7] = ["arms", "left_arm", "right_arm", "upper_body", "legs", "head", "torso"];
/// Points that are dragged in the picture.
const HANDLES: [Role; 6] = [Role::LeftHand, Role::RightHand, Role::LeftFoot, Role::RightFoot, Role::Head, Role::Pelvis];

fn handles(robot: &lifelike_robot::Robot) -> Vec<serde_json::Value> {
    let places = HANDLES.iter().filter_map(|role| Some((role, robot.anatomy.places.get(role)?)));
    let handles = places.map(|(role, place)| {
        serde_json::json!({ "name": role, "body": place.body.saturating_sub(1), "point": place.point.as_slice() })
    });
    handles.collect()
}

/// Returns the body that pushes and loads act on where nobody says which.
fn heaviest(robot: &lifelike_robot::Robot) -> &str {
    let bodies = robot.character.bodies.iter().skip(1);
    let most = bodies.max_by(|a, b| a.inertial.mass.total_cmp(&b.inertial.mass));
    most.map_or("", |body| body.name.as_str())
}

async fn live(
    State(shared): State<Shared>,
    Path(word): Path<String>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let Some(permission) = shared.access.of(&word, &headers, true) else { return refused() };
    let upgrade = upgrade.max_message_size(socket::MAX_REQUEST).max_frame_size(socket::MAX_REQUEST);
    upgrade.on_upgrade(move |socket| socket::serve(socket, permission, shared.screen, shared.engine))
}

/// Asks the engine for the scene, saved or as it is. None: the engine ended.
async fn ask<T>(engine: &Sender<Message>, question: fn(oneshot::Sender<T>) -> Message) -> Option<T> {
    let (sender, answer) = oneshot::channel();
    engine.send(question(sender)).ok()?;
    answer.await.ok()
}

fn ended() -> Response {
    (StatusCode::INTERNAL_SERVER_ERROR, "the engine ended").into_response()
}

async fn export(
    State(shared): State<Shared>,
    Path((word, what)): Path<(String, String)>,
    headers: HeaderMap,
) -> Response {
    if shared.access.of(&word, &headers, false).is_none() {
        return refused();
    }
    let Some(scene) = ask(&shared.engine, Message::Scene).await else { return ended() };
    let (stage, name) = (Arc::clone(&shared.stage), stage::name_of(&shared.scene));
    let made = tokio::task::spawn_blocking(move || files::export(&stage, &scene, &name, &what)).await;
    match made {
        Ok(Ok(export)) => {
            let disposition = format!("attachment; filename=\"{}\"", export.name);
            let headers = [(CONTENT_TYPE.as_str(), export.kind), (CONTENT_DISPOSITION.as_str(), disposition.as_str())];
            (headers, export.bytes).into_response()
        }
        Ok(Err(error)) => (StatusCode::BAD_REQUEST, error.to_string()).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// Saves the scene, and answers the command line that runs it on a robot.
async fn run(State(shared): State<Shared>, Path(word): Path<String>, headers: HeaderMap) -> Response {
    if shared.access.of(&word, &headers, true) != Some(Permission::Edit) {
        return refused();
    }
    match ask(&shared.engine, Message::Save).await {
        Some(Ok(scene)) => reply("text/plain; charset=utf-8", (shared.command)(&scene)),
        Some(Err(error)) => (StatusCode::INTERNAL_SERVER_ERROR, error).into_response(),
        None => ended(),
    }
}

async fn dropped(
    State(shared): State<Shared>,
    Path((word, name)): Path<(String, String)>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    if shared.access.of(&word, &headers, true) != Some(Permission::Edit) {
        return refused();
    }
    let stage = Arc::clone(&shared.stage);
    match tokio::task::spawn_blocking(move || files::take(&stage, &name, &body)).await {
        Ok(Ok(file)) => reply("application/json", serde_json::json!({ "clip": file.0, "told": file.1 }).to_string()),
        Ok(Err(error)) => (StatusCode::BAD_REQUEST, error.to_string()).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}
