//! One viewer's WebSocket: the newest of everything, and a few payloads in flight until they are acknowledged.

use std::sync::mpsc::Sender;

use axum::extract::ws::{Message as Packet, WebSocket};

use crate::access::Permission;
use crate::request::{Message, Request, Screen};

/// Largest request (bytes).
pub const MAX_REQUEST: usize = 64 << 10;
/// Payloads that are sent before one is acknowledged: a page that draws acknowledges between two pictures only.
const MAX_IN_FLIGHT: usize = 3;
/// Acknowledgement of a payload.
const SEEN: &str = "seen";

/// Serves a viewer until it goes. One that stops reading keeps only itself waiting.
pub async fn serve(mut socket: WebSocket, permission: Permission, mut screen: Screen, engine: Sender<Message>) {
    screen.frame.mark_changed();
    screen.view.mark_changed();
    screen.strips.mark_changed();
    let (mut in_flight, mut was_frame) = (0_usize, false);
    loop {
        tokio::select! {
            biased;
            packet = socket.recv() => match packet {
                Some(Ok(Packet::Text(text))) if text.as_str() == SEEN => in_flight = in_flight.saturating_sub(1),
                Some(Ok(Packet::Text(text))) => {
                    let told = request(text.as_str(), permission, &engine);
                    if let Err(told) = told
                        && socket.send(Packet::text(serde_json::json!({ "refused": told }).to_string())).await.is_err()
                    {
                        return;
                    }
                }
                Some(Ok(Packet::Ping(_) | Packet::Pong(_) | Packet::Binary(_))) => {}
                Some(Ok(Packet::Close(_)) | Err(_)) | None => return,
            },
            payload = newest(&mut screen, !was_frame), if in_flight < MAX_IN_FLIGHT => {
                let Some((payload, frame)) = payload else { return };
                (in_flight, was_frame) = (in_flight + 1, frame);
                if socket.send(payload).await.is_err() {
                    return;
                }
            }
        }
    }
}

/// Waits for the next payload, and whether it is a frame: frames and the rest take turns, a view before strips.
async fn newest(screen: &mut Screen, frame_first: bool) -> Option<(Packet, bool)> {
    loop {
        if frame_first && screen.frame.has_changed().ok()? {
            let frame = binary(&screen.frame.borrow_and_update());
            if let Some(frame) = frame {
                return Some((frame, true));
            }
        }
        let payload = tokio::select! {
            biased;
            changed = screen.view.changed() => {
                changed.ok()?;
                let view = screen.view.borrow_and_update();
                (!view.is_empty()).then(|| (Packet::text(view.as_str()), false))
            }
            changed = screen.strips.changed() => {
                changed.ok()?;
                binary(&screen.strips.borrow_and_update()).map(|strips| (strips, false))
            }
            changed = screen.frame.changed() => {
                changed.ok()?;
                binary(&screen.frame.borrow_and_update()).map(|frame| (frame, true))
            }
        };
        // Before the engine has anything to show there is nothing to send.
        if payload.is_some() {
            return payload;
        }
    }
}

fn binary(bytes: &[u8]) -> Option<Packet> {
    (!bytes.is_empty()).then(|| Packet::binary(bytes.to_vec()))
}

/// Passes a request on to the engine.
fn request(text: &str, permission: Permission, engine: &Sender<Message>) -> Result<(), String> {
    let request: Request = serde_json::from_str(text).map_err(|error| format!("request: {error}"))?;
    if permission == Permission::Watch {
        return Err("this address may only watch".into());
    }
    engine.send(Message::Request(request)).map_err(|_| "the engine ended".to_string())
}
