//! Frames as files: PNG, GIF, MP4.

use std::borrow::Cow;
use std::collections::HashMap;

use color_quant::NeuQuant;
use serde_json::Value;

use super::mp4::{Sample, muxed};
use super::{Camera, Engine, Image, damaged, drawn};
use crate::ReportError;
use crate::base64::decode;

/// Frames that the palette of a GIF is made from, at most.
const PALETTE_FRAMES: usize = 12;
/// Colours of a GIF; one more index means that a pixel stays as it was.
const COLOURS: usize = 255;
/// Frames that the page encodes in one call.
const BATCH: usize = 15;

/// Returns an instant (s) as a PNG.
///
/// # Errors
/// The browser fails.
pub fn png(camera: &mut Camera, time: f64) -> Result<Vec<u8>, ReportError> {
    match &mut camera.engine {
        Engine::Page(browser, _) => drawn(browser, time),
        Engine::Software(raster) => {
            let image = raster.draw(time);
            crate::png::encode(&image.rgb, image.size).ok_or_else(|| damaged("a picture"))
        }
    }
}

/// Returns a film of these instants (s) as an animated GIF of `fps` frames a second that repeats for ever.
///
/// # Errors
/// The browser fails.
pub fn gif(
    camera: &mut Camera,
    times: &[f64],
    fps: f64,
    mut progress: impl FnMut(usize),
) -> Result<Vec<u8>, ReportError> {
    let refused =
        |error: &dyn std::fmt::Display| ReportError::Browser { what: "GIF".into(), reason: error.to_string() };
    let (palette, (width, height)) = palette(camera, times)?;
    let colours = palette.color_map_rgb();
    let (mut nearest, mut before): (HashMap<[u8; 3], u8>, Vec<u8>) = (HashMap::new(), Vec::new());
    let mut file = Vec::new();
    let mut encoder = gif::Encoder::new(&mut file, width, height, &colours).map_err(|e| refused(&e))?;
    encoder.set_repeat(gif::Repeat::Infinite).map_err(|e| refused(&e))?;
    let mut shown = 0.0;
    for (i, time) in times.iter().enumerate() {
        let image = camera.image(*time)?;
        let mut index = |p: &[u8]| {
            let rgb = [p[0], p[1], p[2]];
            *nearest
                .entry(rgb)
                .or_insert_with(|| palette.index_of(&[rgb[0], rgb[1], rgb[2], 255]).min(COLOURS - 1) as u8)
        };
        let now: Vec<u8> = image.rgb.chunks_exact(3).map(&mut index).collect();
        let unchanged = COLOURS as u8;
        let pixels: Vec<u8> = match before.len() == now.len() {
            true => now.iter().zip(&before).map(|(now, was)| if now == was { unchanged } else { *now }).collect(),
            false => now.clone(),
        };
        before = now;
        // Durations are hundredths of a second; what one frame loses by rounding, the next one gets.
        let until = ((i + 1) as f64 * 100.0 / fps).round();
        let frame = gif::Frame {
            width,
            height,
            delay: (until - shown) as u16,
            transparent: Some(unchanged),
            buffer: Cow::Owned(pixels),
            ..gif::Frame::default()
        };
        shown = until;
        encoder.write_frame(&frame).map_err(|e| refused(&e))?;
        progress(i + 1);
    }
    drop(encoder);
    Ok(file)
}

/// Returns one palette for a whole film, so that colours do not flicker, and the size of its frames.
fn palette(camera: &mut Camera, times: &[f64]) -> Result<(NeuQuant, (u16, u16)), ReportError> {
    let step = times.len().div_ceil(PALETTE_FRAMES).max(1);
    let (mut pixels, mut size) = (Vec::new(), (1, 1));
    for time in times.iter().step_by(step) {
        let image = camera.image(*time)?;
        size = (image.size.0 as u16, image.size.1 as u16);
        // Every seventh pixel; an odd step meets no column twice in a row.
        pixels.extend(image.rgb.chunks_exact(3).step_by(7).flat_map(|p| [p[0], p[1], p[2], 255]));
    }
    Ok((NeuQuant::new(3, COLOURS, &pixels), size))
}

/// Returns a film of these instants (s) as H.264 in MP4.
///
/// # Errors
/// There is no browser, or its encoder fails.
pub fn mp4(
    camera: &mut Camera,
    times: &[f64],
    fps: f64,
    mut progress: impl FnMut(usize),
) -> Result<Vec<u8>, ReportError> {
    let missing =
        |reason: &str| ReportError::Browser { what: "MP4".into(), reason: format!("{reason}; a *.gif needs none") };
    let Engine::Page(browser, _) = &mut camera.engine else {
        return Err(missing("the video encoder is a browser's: expected Chromium here (Debian: apt install chromium)"));
    };
    let number = |browser: &mut crate::browser::Browser, name: &str| {
        browser.evaluate(&format!("document.querySelector('canvas').{name}")).map(|v| v.as_u64().unwrap_or(0) as u32)
    };
    let size = (number(browser, "width")?, number(browser, "height")?);
    // A tenth of a bit a pixel is without visible loss for flat colours.
    let bitrate = (f64::from(size.0 * size.1) * fps * 0.16).clamp(8e5, 2e7) as u64;
    if browser.evaluate(&format!("film.begin({fps}, {bitrate})"))? != Value::Bool(true) {
        return Err(missing("expected a browser with an encoder for H.264, got one without"));
    }
    let (mut samples, mut description) = (Vec::new(), None);
    let mut done = 0;
    for batch in times.chunks(BATCH) {
        let answer = browser.evaluate(&format!("film.add({done}, {}, {fps})", serde_json::json!(batch)))?;
        keep(&answer, &mut samples, &mut description)?;
        done += batch.len();
        progress(done);
    }
    keep(&browser.evaluate("film.end()")?, &mut samples, &mut description)?;
    let description = description.ok_or_else(|| damaged("the film's parameters"))?;
    if samples.len() != times.len() {
        let reason = format!("expected {} frames, got {}", times.len(), samples.len());
        return Err(ReportError::Browser { what: "the video encoder".into(), reason });
    }
    Ok(muxed(&samples, &description, size, fps))
}

/// Takes encoded frames out of an answer of the page.
fn keep(answer: &Value, samples: &mut Vec<Sample>, description: &mut Option<Vec<u8>>) -> Result<(), ReportError> {
    for sample in answer["samples"].as_array().into_iter().flatten() {
        let data = sample[1].as_str().and_then(decode).ok_or_else(|| damaged("an encoded frame"))?;
        samples.push(Sample { is_key: sample[0] == Value::Bool(true), data });
    }
    if let Some(text) = answer["description"].as_str() {
        *description = Some(decode(text).ok_or_else(|| damaged("the film's parameters"))?);
    }
    Ok(())
}

/// Reads a PNG of the page.
pub(super) fn decoded(png: &[u8]) -> Result<Image, ReportError> {
    let (size, rgb) = crate::png::decode(png).ok_or_else(|| damaged("a picture of the page"))?;
    Ok(Image { size, rgb })
}
