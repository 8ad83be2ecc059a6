//! Pictures and films of the motion on a page.
//!
//! The page's own renderer draws in a headless Chromium, where one is installed. Elsewhere a small rasterizer draws the
//! same scene, without shadows on bodies. [`Camera::renderer`] says which of the two it was.

mod encode;
mod mp4;
mod raster;
mod shapes;
mod track;

use std::path::Path;

use serde_json::Value;

use crate::browser::Browser;
use crate::{FromInput, ReportBuilder, ReportError};
use raster::Raster;

pub use encode::{gif, mp4, png};

/// A page whose motion can be filmed.
#[derive(Debug)]
pub struct Film {
    html: String,
    data: Value,
}

/// A view of one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Number of the clip on the page.
    pub clip: usize,
    /// Width and height (pixels).
    pub size: (u32, u32),
    /// Direction from which the camera looks: 0 from the front of x, counterclockwise (rad).
    pub azimuth: f64,
    /// Angle above the ground (rad).
    pub elevation: f64,
    /// Distance from the robot (heights of the robot).
    pub distance: f64,
    /// Light or dark.
    pub dark: bool,
    /// Place of the reference.
    pub reference: ReferenceView,
    /// Ground forces as arrows, planned contacts as discs.
    pub contacts: bool,
    /// True if the camera follows the robot.
    pub follow: bool,
}

/// Place of the reference in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceView {
    /// Transparent, where the robot is.
    Overlay,
    /// Beside the robot.
    Beside,
    /// Left out, where there is physics.
    Off,
}

/// One picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Width and height (pixels).
    pub size: (u32, u32),
    /// Rows from the top, red, green and blue (0 to 255).
    pub rgb: Vec<u8>,
}

/// Draws frames of one view.
#[derive(Debug)]
pub struct Camera {
    engine: Engine,
    /// Frames per second that were recorded.
    pub fps: f64,
    /// Length of the clip (s).
    pub seconds: f64,
}

#[derive(Debug)]
enum Engine {
    /// The page in a browser, which must end before its folder goes.
    Page(Browser, #[allow(dead_code)] tempfile::TempDir),
    Software(Box<Raster>),
}

impl Default for View {
    fn default() -> Self {
        Self {
            clip: 0,
            size: (1280, 720),
            azimuth: -0.9,
            elevation: 0.2,
            distance: 2.6,
            dark: false,
            reference: ReferenceView::Overlay,
            contacts: true,
            follow: true,
        }
    }
}

impl Film {
    /// Returns the film of a page in the making.
    ///
    /// # Errors
    /// As [`Self::of_html`].
    pub fn new(page: &ReportBuilder) -> Result<Self, ReportError> {
        Self::of_html(page.to_html(), "page")
    }

    /// Reads a report page.
    ///
    /// # Errors
    /// The file cannot be read, or is no page of this version.
    pub fn read(path: &Path) -> Result<Self, ReportError> {
        let html = std::fs::read_to_string(path).map_err(ReportError::io(path))?;
        Self::of_html(html, &path.display().to_string())
    }

    /// Takes the data out of a page.
    fn of_html(html: String, path: &str) -> Result<Self, ReportError> {
        let refused = |got: &str| ReportError::format(path, "a report page of this version with motion in it", got);
        const OPENING: &str = "<script type=\"application/json\" id=\"data\">";
        let start = html.find(OPENING).ok_or_else(|| refused("a file without a report's data"))? + OPENING.len();
        let length = html[start..].find("</script>").ok_or_else(|| refused("a file that ends too early"))?;
        let data: Value =
            serde_json::from_str(&html[start..start + length]).map_err(|error| refused(&error.to_string()))?;
        if data["playbacks"].as_array().is_none_or(Vec::is_empty) {
            return Err(refused("a page without motion"));
        }
        Ok(Self { html, data })
    }

    /// Returns name and length (s) of every clip.
    pub fn clips(&self) -> Vec<(String, f64)> {
        let named = |p: &Value| {
            let frames = p["frames"].as_f64().unwrap_or_default();
            (p["name"].as_str().unwrap_or_default().to_string(), (frames - 1.0) / p["fps"].as_f64().unwrap_or(1.0))
        };
        self.data["playbacks"].as_array().into_iter().flatten().map(named).collect()
    }

    /// Returns a camera on a view; `software` uses no browser.
    ///
    /// # Errors
    /// The clip is not on the page, its data are damaged, or the browser fails.
    pub fn camera(&self, view: &View, software: bool) -> Result<Camera, ReportError> {
        let clips = self.clips();
        let Some((_, seconds)) = clips.get(view.clip) else {
            return Err(ReportError::mismatch("clip", format!("a number below {}", clips.len()), view.clip));
        };
        let fps = self.data["playbacks"][view.clip]["fps"].as_f64().unwrap_or(1.0);
        let page = if software { None } else { self.page(view)? };
        let engine = match page {
            Some(engine) => engine,
            None => Engine::Software(Box::new(Raster::new(&self.data, view)?)),
        };
        Ok(Camera { engine, fps, seconds: *seconds })
    }

    fn page(&self, view: &View) -> Result<Option<Engine>, ReportError> {
        let folder = tempfile::tempdir().map_err(ReportError::io(Path::new("a temporary folder")))?;
        let Some(mut browser) = Browser::start(folder.path())? else { return Ok(None) };
        let page = folder.path().join("page.html");
        std::fs::write(&page, &self.html).map_err(ReportError::io(&page))?;
        let reference = match view.reference {
            ReferenceView::Overlay => "overlay",
            ReferenceView::Beside => "beside",
            ReferenceView::Off => "off",
        };
        let (contacts, still) = (u8::from(view.contacts), if view.follow { "" } else { "&still" });
        let address = format!(
            "file://{}?film&clip={}&azimuth={}&elevation={}&distance={}&reference={reference}&contacts={contacts}{still}",
            page.display(),
            view.clip,
            view.azimuth,
            view.elevation,
            view.distance
        );
        browser.open(&address, view.size, if view.dark { "dark" } else { "light" })?;
        if let Some(error) = browser.errors.first() {
            return Err(ReportError::Browser { what: "the page".into(), reason: error.clone() });
        }
        Ok(Some(Engine::Page(browser, folder)))
    }
}

impl Camera {
    /// Returns the renderer's name.
    pub fn renderer(&self) -> &'static str {
        match &self.engine {
            Engine::Page(..) => "the page in a headless Chromium",
            Engine::Software(_) => "the software rasterizer",
        }
    }

    /// Draws an instant (s) as a picture.
    ///
    /// # Errors
    /// The browser fails.
    pub fn image(&mut self, time: f64) -> Result<Image, ReportError> {
        match &mut self.engine {
            Engine::Page(browser, _) => encode::decoded(&drawn(browser, time)?),
            Engine::Software(raster) => Ok(raster.draw(time)),
        }
    }
}

/// Returns an instant as the page draws it, as the bytes of a PNG.
fn drawn(browser: &mut Browser, time: f64) -> Result<Vec<u8>, ReportError> {
    let text = browser.evaluate(&format!("film.png({time})"))?;
    text.as_str().and_then(crate::base64::decode).ok_or_else(|| damaged("a picture of the page"))
}

fn damaged(what: &str) -> ReportError {
    ReportError::Browser { what: what.into(), reason: "expected base64, got something else".into() }
}
