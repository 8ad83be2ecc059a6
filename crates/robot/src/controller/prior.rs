//! The frozen encoder of a motion prior: the motion around a frame → z_t.

use lifelike_checkpoint::Checkpoint;
use lifelike_motion::resample::{frame_at, locate};
use lifelike_motion::window::{WindowSpec, write_window};
use lifelike_motion::{FeatureLayout, Frame, MotionClip};

use crate::network::{ComponentEncoder, ConvEncoder, ConvSizes, Weights, Workspace};
use crate::reference::{LatentEncoder, ReferenceStream};
use crate::{FromInput, RobotError};

/// Kinds of priors, as their files say.
const CONVOLUTIONAL: &str = "motion prior";
const COMPONENTS: &str = "principal components of motion";
const SPLINE: &str = "spline motion prior";
/// Prefixes in files.
const NETWORK: &str = "vae";
const STATISTICS: &str = "statistics";
/// Windows per pass: as many as when the prior was trained, so that codes come out of the same products.
const CHUNK: usize = 256;

/// Windows, names and sizes of a motion prior.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorHeader {
    /// Joints and end effectors, in order.
    pub layout: FeatureLayout,
    /// Rate of the frames (Hz).
    pub frame_rate: f64,
    /// W of eq. 4.2: a window has 2W + 1 samples.
    pub half_width: usize,
    /// Time that a window covers (s).
    pub window_seconds: f64,
    /// Size of a code, d_z.
    pub latent: usize,
    /// Width of the convolutions; 0: there are none, and the code is the window's principal components.
    pub channels: usize,
    /// Residual blocks of the encoder.
    pub blocks: usize,
    /// The window's principal components are added to the code.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub linear_path: bool,
}

/// The keys of a β-VAE's plan that its encoder needs.
#[derive(serde::Deserialize)]
struct Plan {
    #[serde(flatten)]
    windows: Windows,
    latent: usize,
    channels: usize,
    blocks: usize,
    #[serde(default)]
    linear_path: bool,
}

/// Those of principal components.
#[derive(serde::Deserialize)]
struct ComponentsPlan {
    windows: Windows,
    latent: usize,
}

#[derive(serde::Deserialize)]
struct Windows {
    frame_rate: f64,
    half_width: usize,
    window_seconds: f64,
}

impl PriorHeader {
    fn check(&self) -> Result<(), RobotError> {
        let within = |what: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(RobotError::mismatch(format!("motion prior: {what}"), format!("{low} to {high}"), value))
        };
        within("frame_rate", self.frame_rate, 1.0, 1000.0)?;
        within("half_width", self.half_width as f64, 1.0, 500.0)?;
        within("window_seconds", self.window_seconds, 0.02, 20.0)?;
        within("latent", self.latent as f64, 1.0, 4096.0)?;
        // Something has to say what a code is.
        within("channels", self.channels as f64, if self.linear_path { 0.0 } else { 1.0 }, 4096.0)?;
        within("blocks", self.blocks as f64, 0.0, 64.0)
    }

    fn sizes(&self) -> ConvSizes {
        ConvSizes {
            samples: self.window().len(),
            features: self.layout.size(),
            channels: self.channels,
            blocks: self.blocks,
            latent: self.latent,
        }
    }

    /// The window in time.
    pub fn window(&self) -> WindowSpec {
        WindowSpec { half_width: self.half_width, dt: self.window_seconds / (2 * self.half_width) as f64 }
    }
}

/// Statistics and network of a motion prior's encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorEncoder {
    header: PriorHeader,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    /// The network of these, if the header has one; codes are their sum.
    network: Option<ConvEncoder>,
    components: Option<ComponentEncoder>,
}

impl PriorEncoder {
    /// Reads the encoder of a prior's own file.
    ///
    /// # Errors
    /// The file is neither a convolutional motion prior nor one of principal components, or is damaged.
    pub fn from_prior(file: &Checkpoint) -> Result<Self, RobotError> {
        let kind: String = file.meta("kind")?;
        let plan = match kind.as_str() {
            CONVOLUTIONAL => file.meta("plan")?,
            COMPONENTS => {
                let ComponentsPlan { windows, latent } = file.meta("plan")?;
                Plan { windows, latent, channels: 0, blocks: 0, linear_path: true }
            }
            other => {
                let got = match other {
                    SPLINE => "a Spline-based Transformer, whose encoder needs the training framework: codes can be \
                               computed beforehand, not in a controller"
                        .to_string(),
                    other => format!("a '{other}'"),
                };
                let what = "motion prior of a controller";
                return Err(RobotError::mismatch(what, "a convolutional one, or principal components", got));
            }
        };
        let Plan { windows: Windows { frame_rate, half_width, window_seconds }, latent, channels, blocks, linear_path } =
            plan;
        let layout = file.meta("layout")?;
        let header =
            PriorHeader { layout, frame_rate, half_width, window_seconds, latent, channels, blocks, linear_path };
        Self::load(file, header)
    }

    /// Reads the arrays of a header, which must confirm its sizes.
    pub(super) fn load(file: &Checkpoint, header: PriorHeader) -> Result<Self, RobotError> {
        header.check()?;
        let (size, statistics) = (header.layout.size(), Weights::under(file, STATISTICS));
        Ok(Self {
            mean: statistics.f64s("mean", &[size])?,
            deviation: statistics.f64s("spread", &[size])?,
            network: (header.channels > 0).then(|| ConvEncoder::load(file, NETWORK, header.sizes())).transpose()?,
            components: header
                .linear_path
                .then(|| ComponentEncoder::load(file, header.window().len() * size, header.latent))
                .transpose()?,
            header,
        })
    }

    pub(super) fn save_into(&self, file: &mut Checkpoint) -> Result<(), RobotError> {
        let size = self.mean.len();
        file.put_f64(&format!("{STATISTICS}.mean"), &[size], self.mean.clone())?;
        file.put_f64(&format!("{STATISTICS}.spread"), &[size], self.deviation.clone())?;
        if let Some(network) = &self.network {
            network.save_into(file, NETWORK)?;
        }
        if let Some(components) = &self.components {
            components.save_into(file)?;
        }
        Ok(())
    }

    /// Writes codes `[B, d_z]` of normalised windows, `[B, 2W + 1, F]`.
    fn codes(&self, windows: &[f32], work: &mut Workspace, codes: &mut [f32]) {
        match &self.network {
            Some(network) => network.encode(windows, work, codes),
            None => codes.fill(0.0),
        }
        if let Some(components) = &self.components {
            components.add(windows, codes);
        }
    }

    /// Names, window and sizes.
    pub fn header(&self) -> &PriorHeader {
        &self.header
    }

    /// Mean and standard deviation of the features that it was trained on (SI), `[F]` each.
    pub fn statistics(&self) -> (&[f64], &[f64]) {
        (&self.mean, &self.deviation)
    }

    /// Normalises windows in SI units into the network's numbers.
    fn normalize(&self, windows: &[f64], out: &mut [f32]) {
        let rows = windows.chunks_exact(self.mean.len()).zip(out.chunks_exact_mut(self.mean.len()));
        for (row, out) in rows {
            for (((out, x), mean), deviation) in out.iter_mut().zip(row).zip(&self.mean).zip(&self.deviation) {
                *out = ((x - mean) / deviation) as f32;
            }
        }
    }

    /// Writes codes `[B, d_z]` of windows in SI units, `[B, 2W + 1, F]`.
    pub(super) fn encode_windows(&self, windows: &[f64], work: &mut Workspace, codes: &mut [f32]) {
        let mut rows = vec![0.0; windows.len()];
        self.normalize(windows, &mut rows);
        self.codes(&rows, work, codes);
    }

    /// The code of the motion around a reference's target.
    pub(super) fn encode_around<'a>(
        &self,
        reference: &dyn ReferenceStream,
        scratch: &'a mut PriorScratch,
    ) -> &'a [f32] {
        let PriorScratch { work, pair, frame, window, rows, code } = scratch;
        let (spec, size) = (self.header.window(), self.mean.len());
        reference.write_frame(0, frame);
        let centre = frame.root_orientation;
        for (i, row) in window.chunks_exact_mut(size).enumerate() {
            let steps = (i as f64 - spec.half_width as f64) * spec.dt * self.header.frame_rate;
            let before = steps.floor();
            let [a, b] = pair;
            reference.write_frame(before as i32, a);
            reference.write_frame(before as i32 + 1, b);
            // A sample on a frame is that frame; only between two is there anything to blend (and to reuse).
            match locate(steps - before, 2) {
                (at, 0.0) => pair[at].write_features(&centre, row),
                _ => {
                    frame_at(pair, steps - before, frame);
                    frame.write_features(&centre, row);
                }
            }
        }
        self.normalize(window, rows);
        self.codes(rows, work, code);
        code
    }

    fn check_frames(&self, clip: &str, frames: &[Frame]) -> Result<(), RobotError> {
        let Some((i, expected, got)) = self.header.layout.first_misfit(frames) else { return Ok(()) };
        Err(RobotError::mismatch(format!("clip '{clip}' for the motion prior, frame {i}"), expected, got))
    }
}

impl LatentEncoder for PriorEncoder {
    fn latent_size(&self) -> usize {
        self.header.latent
    }

    fn encode(&self, clip: &MotionClip, frames: &[Frame], fps: f64) -> Result<Vec<f32>, RobotError> {
        let rate = self.header.frame_rate;
        if (rate - fps).abs() > 1e-9 {
            let what = format!("clip '{}' for the motion prior (frames per second)", clip.name);
            return Err(RobotError::mismatch(what, rate, fps));
        }
        self.check_frames(&clip.name, frames)?;
        let (spec, latent) = (self.header.window(), self.header.latent);
        let width = spec.len() * self.mean.len();
        let mut work = Workspace::batched();
        let mut codes = vec![0.0; frames.len() * latent];
        let mut windows = vec![0.0; width * frames.len().min(CHUNK)];
        for (chunk, codes) in codes.chunks_mut(CHUNK * latent).enumerate() {
            let windows = &mut windows[..codes.len() / latent * width];
            for (i, window) in windows.chunks_exact_mut(width).enumerate() {
                write_window(frames, rate, (chunk * CHUNK + i) as f64 / rate, spec, window)?;
            }
            self.encode_windows(windows, &mut work, codes);
        }
        Ok(codes)
    }
}

/// Buffers for one window and its code.
#[derive(Debug, Clone)]
pub(super) struct PriorScratch {
    work: Workspace,
    pair: [Frame; 2],
    frame: Frame,
    window: Vec<f64>,
    rows: Vec<f32>,
    code: Vec<f32>,
}

impl PriorScratch {
    pub(super) fn new(encoder: Option<&PriorEncoder>) -> Self {
        let empty = || Frame {
            root_position: Default::default(),
            root_orientation: Default::default(),
            linear_velocity_w: Default::default(),
            angular_velocity_w: Default::default(),
            joint_positions: Vec::new(),
            joint_velocities: Vec::new(),
            effectors_w: Vec::new(),
        };
        let (numbers, latent) = encoder.map_or((0, 0), |e| (e.header.window().len() * e.mean.len(), e.header.latent));
        Self {
            work: Workspace::live(),
            pair: [empty(), empty()],
            frame: empty(),
            window: vec![0.0; numbers],
            rows: vec![0.0; numbers],
            code: vec![0.0; latent],
        }
    }
}
