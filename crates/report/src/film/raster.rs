//! The scene of a page drawn without a browser: triangles with a depth buffer, four samples a pixel.

use lifelike_character::Vec3;
use serde_json::Value;

use super::shapes::{Corner, Surface, bodies, cone};
use super::track::Track;
use super::{Image, ReferenceView, View};
use crate::ReportError;
use crate::base64::decode;
use crate::playback::BodyPose;

/// Samples a pixel, along each side.
const SAMPLES: usize = 2;
/// Vertical angle of view (rad).
const ANGLE: f64 = 0.5;
/// Direction towards the sun.
const SUN: [f64; 3] = [0.42, -0.28, 0.86];
/// Opacity of a reference over the robot.
const GLASS: f64 = 0.32;

/// Colours of the scene (0 to 1); those of the page's style.
#[derive(Debug, Clone, Copy)]
struct Theme {
    paper: [f64; 3],
    floor: [f64; 3],
    line: [f64; 3],
    ghost: [f64; 3],
    force: [f64; 3],
    sky: [f64; 3],
    shadow: f64,
}

const LIGHT: Theme = Theme {
    paper: [0.945, 0.937, 0.918],
    floor: [0.918, 0.906, 0.878],
    line: [0.827, 0.812, 0.773],
    ghost: [0.184, 0.612, 0.549],
    force: [0.227, 0.435, 0.847],
    sky: [0.74, 0.77, 0.82],
    shadow: 0.3,
};
const DARK: Theme = Theme {
    paper: [0.098, 0.110, 0.129],
    floor: [0.133, 0.149, 0.173],
    line: [0.204, 0.224, 0.255],
    ghost: [0.310, 0.765, 0.702],
    force: [0.478, 0.647, 1.0],
    sky: [0.5, 0.53, 0.6],
    shadow: 0.62,
};

/// A foot's contacts.
#[derive(Debug)]
struct Foot {
    body: usize,
    at: Vec3,
    down: Vec<u8>,
    force: Vec<u8>,
}

/// The scene of one view.
#[derive(Debug)]
pub(super) struct Raster {
    view: View,
    height: f64,
    simulated: Option<Track>,
    reference: Option<Track>,
    robot: Vec<Vec<Surface>>,
    shadow: Vec<Vec<Surface>>,
    feet: Vec<Foot>,
    fps: f64,
}

/// Samples of one frame.
struct Canvas {
    width: usize,
    height: usize,
    colour: Vec<[f32; 3]>,
    depth: Vec<f32>,
}

/// A camera in the scene.
struct Lens {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    back: Vec3,
    focal: f64,
    near: f64,
    middle: [f64; 2],
}

impl Raster {
    /// Reads the scene of a view.
    pub fn new(data: &Value, view: &View) -> Result<Self, ReportError> {
        let clip = &data["playbacks"][view.clip];
        let number = |value: &Value| value.as_u64().unwrap_or_default() as usize;
        let character = |key: &str| &data["characters"][number(&clip[key])];
        let (robot, shadow) = (bodies(character("character")), bodies(character("referenceCharacter")));
        let (frames, fps) = (number(&clip["frames"]), clip["fps"].as_f64().unwrap_or(1.0));
        let bytes = |value: &Value| value.as_str().and_then(decode).unwrap_or_default();
        let foot = |foot: &Value| Foot {
            body: number(&foot["body"]),
            at: Vec3::from([0, 1, 2].map(|k| foot["at"][k].as_f64().unwrap_or_default())),
            down: bytes(&foot["down"]),
            force: bytes(&foot["force"]),
        };
        Ok(Self {
            view: view.clone(),
            height: character("character")["height"].as_f64().unwrap_or(1.0),
            simulated: Track::read(&clip["simulated"], frames, robot.len(), fps)?,
            reference: Track::read(&clip["reference"], frames, shadow.len(), fps)?,
            robot,
            shadow,
            feet: clip["feet"].as_array().into_iter().flatten().map(foot).collect(),
            fps,
        })
    }

    /// Draws an instant (s).
    pub fn draw(&self, time: f64) -> Image {
        let theme = if self.view.dark { DARK } else { LIGHT };
        let (width, height) = (self.view.size.0 as usize * SAMPLES, self.view.size.1 as usize * SAMPLES);
        let Some(main) = self.simulated.as_ref().or(self.reference.as_ref()) else {
            return Image { size: self.view.size, rgb: vec![255; 3 * (self.view.size.0 * self.view.size.1) as usize] };
        };
        let beside =
            self.view.reference == ReferenceView::Beside && self.simulated.is_some() && self.reference.is_some();
        let right = Vec3::new(-self.view.azimuth.sin(), self.view.azimuth.cos(), 0.0);
        let gap = if beside { right * (0.75 * self.height) } else { Vec3::zeros() };
        let mut target = if self.view.follow { main.calm_root(time) } else { main.pose(0.0)[0].0 };
        target.z = self.height * 0.46;
        let lens = self.lens(target + gap / 2.0, width, height);
        let mut canvas = Canvas::new(width, height);

        let robot = self.simulated.as_ref().map(|track| placed(&self.robot, &track.pose(time), Vec3::zeros(), None));
        let shown = self.view.reference != ReferenceView::Off || self.simulated.is_none();
        let ghost = self.reference.as_ref().filter(|_| shown);
        let ghost = ghost.map(|track| placed(&self.shadow, &track.pose(time), gap, Some(theme.ghost)));
        let is_glass = robot.is_some() && !beside;
        let solid = [robot.as_ref(), ghost.as_ref().filter(|_| !is_glass)];

        let mut shade = Canvas::new(width, height);
        solid.iter().flatten().flat_map(|surfaces| surfaces.iter()).for_each(|s| shade.drop_shadow(&lens, s));
        canvas.floor(&lens, &theme, &shade, target, self.view.distance * self.height * 2.6);
        solid.iter().flatten().flat_map(|surfaces| surfaces.iter()).for_each(|s| canvas.fill(&lens, s, &theme));
        if let Some(ghost) = ghost.as_ref().filter(|_| is_glass) {
            let mut glass = Canvas::new(width, height);
            ghost.iter().for_each(|s| glass.fill(&lens, s, &theme));
            canvas.blend(&glass, GLASS);
        }
        let mut marks = Canvas::new(width, height);
        self.marks(time, gap, &theme).iter().for_each(|s| marks.fill(&lens, s, &theme));
        canvas.blend(&marks, 0.8);
        canvas.image(self.view.size)
    }

    fn lens(&self, target: Vec3, width: usize, height: usize) -> Lens {
        let (azimuth, elevation) = (self.view.azimuth, self.view.elevation);
        let distance = self.view.distance * self.height;
        let flat = elevation.cos() * distance;
        let mut eye = target + Vec3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin() * distance);
        eye.z = eye.z.max(0.02);
        let back = (eye - target).normalize();
        let right = Vec3::z().cross(&back).try_normalize(1e-9).unwrap_or_else(Vec3::y);
        Lens {
            eye,
            right,
            up: back.cross(&right),
            back,
            focal: height as f64 / 2.0 / (ANGLE / 2.0).tan(),
            near: distance * 0.05,
            middle: [width as f64 / 2.0, height as f64 / 2.0],
        }
    }

    /// Returns ground forces as arrows and planned contacts as discs.
    fn marks(&self, time: f64, gap: Vec3, theme: &Theme) -> Vec<Surface> {
        let frame = ((time + 0.5 / self.fps) * self.fps).max(0.0) as usize;
        let pose = |track: &Option<Track>, shift: Vec3| track.as_ref().map(|t| (t.pose(time), shift));
        let same = self.shadow.len() == self.robot.len();
        let figure = pose(&self.simulated, Vec3::zeros()).or_else(|| pose(&self.reference, gap));
        let planned = pose(&self.reference, gap).filter(|_| same).or_else(|| pose(&self.simulated, Vec3::zeros()));
        let (Some(figure), Some(planned), true) = (figure, planned, self.view.contacts) else { return Vec::new() };
        let sole_of = |(pose, shift): &(Vec<BodyPose>, Vec3), foot: &Foot| {
            pose.get(foot.body).map_or_else(Vec3::zeros, |(p, q)| p + q * foot.at + shift)
        };
        let moved = |corners: Vec<Corner>, to: Vec3| corners.into_iter().map(|(p, n)| (p + to, n)).collect::<Vec<_>>();
        let mut out = Vec::new();
        for foot in &self.feet {
            if foot.down.get(frame).is_some_and(|down| *down != 0) {
                let mut to = sole_of(&planned, foot);
                to.z = to.z.max(0.0) + 0.003;
                let radius = 0.075 * self.height;
                out.push(Surface { corners: moved(cone([radius, radius], [0.0, 0.001]), to), colour: theme.ghost });
            }
            let force = foot.force.get(frame).map_or(0.0, |share| f64::from(*share) / 100.0);
            if force > 0.02 {
                let (radius, length) = (0.02 * self.height, 0.5 * self.height * force);
                let shaft = cone([0.35 * radius, 0.35 * radius], [0.0, 0.8 * length]);
                let arrow = [shaft, cone([radius, 0.0], [0.8 * length, length])].concat();
                out.push(Surface { corners: moved(arrow, sole_of(&figure, foot)), colour: theme.force });
            }
        }
        out
    }
}

/// Returns the surfaces of a figure in the world.
fn placed(figure: &[Vec<Surface>], pose: &[BodyPose], shift: Vec3, colour: Option<[f64; 3]>) -> Vec<Surface> {
    let moved = |surface: &Surface, (p, q): &BodyPose| Surface {
        corners: surface.corners.iter().map(|(x, n)| (q * x + p + shift, q * n)).collect(),
        colour: colour.unwrap_or(surface.colour),
    };
    figure.iter().zip(pose).flat_map(|(body, pose)| body.iter().map(|s| moved(s, pose))).collect()
}

impl Lens {
    /// Returns column, row and distance of a point; nothing behind the camera.
    fn project(&self, point: Vec3) -> Option<[f64; 3]> {
        let v = point - self.eye;
        let depth = -v.dot(&self.back);
        let [x, y] = [v.dot(&self.right), v.dot(&self.up)].map(|c| c * self.focal / depth);
        (depth > self.near).then_some([self.middle[0] + x, self.middle[1] - y, depth])
    }

    /// Returns the direction through a sample (not of unit length).
    fn ray(&self, column: usize, row: usize) -> Vec3 {
        let (x, y) = (column as f64 + 0.5 - self.middle[0], self.middle[1] - row as f64 - 0.5);
        self.right * x + self.up * y - self.back * self.focal
    }
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        let n = width * height;
        Self { width, height, colour: vec![[0.0; 3]; n], depth: vec![f32::INFINITY; n] }
    }

    /// Draws triangles; nearer ones hide others.
    fn fill(&mut self, lens: &Lens, surface: &Surface, theme: &Theme) {
        for t in surface.corners.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|corner| lens.project(corner.0));
            let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
            let lit = [t[0], t[1], t[2]].map(|corner| shaded(corner, surface.colour, lens.eye, theme));
            self.triangle([a, b, c], |weights| {
                [0, 1, 2].map(|k| (0..3).map(|i| weights[i] * lit[i][k]).sum::<f64>() as f32)
            });
        }
    }

    /// Draws the shadow of triangles on the ground.
    fn drop_shadow(&mut self, lens: &Lens, surface: &Surface) {
        let sun = Vec3::from(SUN);
        for t in surface.corners.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|(p, _)| lens.project(p - sun * (p.z.max(0.0) / sun.z)));
            let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
            self.triangle([a, b, c], |_| [1.0; 3]);
        }
    }

    /// Fills one triangle of projected corners.
    fn triangle(&mut self, [a, b, c]: [[f64; 3]; 3], colour: impl Fn([f64; 3]) -> [f32; 3]) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-9 {
            return;
        }
        let range = |axis: usize, most: usize| {
            let values = [a[axis], b[axis], c[axis]];
            let low = values.iter().copied().fold(f64::INFINITY, f64::min).floor().max(0.0) as usize;
            let high = values.iter().copied().fold(0.0, f64::max).ceil().min(most as f64) as usize;
            low..high
        };
        for row in range(1, self.height) {
            for column in range(0, self.width) {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let edge = |p: [f64; 3], q: [f64; 3]| ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area;
                let flat = [edge(b, c), edge(c, a), edge(a, b)];
                if flat.iter().any(|w| *w < 0.0) {
                    continue;
                }
                // Linear in the picture is the reciprocal of the distance.
                let weights = [flat[0] / a[2], flat[1] / b[2], flat[2] / c[2]];
                let depth = 1.0 / weights.iter().sum::<f64>();
                let at = row * self.width + column;
                if (depth as f32) < self.depth[at] {
                    self.depth[at] = depth as f32;
                    self.colour[at] = colour(weights.map(|w| w * depth));
                }
            }
        }
    }

    /// Fills with the ground and its lines, which fade into the paper.
    fn floor(&mut self, lens: &Lens, theme: &Theme, shade: &Self, focus: Vec3, reach: f64) {
        for row in 0..self.height {
            for column in 0..self.width {
                let at = row * self.width + column;
                let ray = lens.ray(column, row);
                let along = -lens.eye.z / ray.z;
                let colour = if ray.z < 0.0 {
                    let p = lens.eye + ray * along;
                    // Metres along x and y from one sample to the next column, and to the next row.
                    let [across, down] = [lens.right, lens.up].map(|step| (step + ray * (-step.z / ray.z)) * along);
                    let footprint = [0, 1].map(|k| across[k].abs() + down[k].abs());
                    ground(theme, p, footprint, shade.depth[at].is_finite(), (p - focus).xy().norm() / reach)
                } else {
                    theme.paper
                };
                self.colour[at] = colour.map(|c| c as f32);
            }
        }
    }

    /// Lays another canvas over this one where it is nearer.
    fn blend(&mut self, other: &Self, alpha: f64) {
        let alpha = alpha as f32;
        for at in 0..self.colour.len() {
            if other.depth[at] < self.depth[at] {
                let mixed = |k: usize| self.colour[at][k] * (1.0 - alpha) + other.colour[at][k] * alpha;
                self.colour[at] = [mixed(0), mixed(1), mixed(2)];
            }
        }
    }

    /// Averages the samples of every pixel.
    fn image(&self, (width, height): (u32, u32)) -> Image {
        let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
        for row in 0..height as usize {
            for column in 0..width as usize {
                for k in 0..3 {
                    let sample = |i: usize| {
                        let (y, x) = (row * SAMPLES + i / SAMPLES, column * SAMPLES + i % SAMPLES);
                        self.colour[y * self.width + x][k]
                    };
                    let mean = (0..SAMPLES * SAMPLES).map(sample).sum::<f32>() / (SAMPLES * SAMPLES) as f32;
                    rgb.push((mean.clamp(0.0, 1.0) * 255.0).round() as u8);
                }
            }
        }
        Image { size: (width, height), rgb }
    }
}

/// Returns the colour of a point of the ground; `away` is its distance from the robot in units of what is shown.
fn ground(theme: &Theme, p: Vec3, footprint: [f64; 2], is_dark: bool, away: f64) -> [f64; 3] {
    let smooth = |low: f64, high: f64, x: f64| {
        let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let line = |cell: f64, half: f64| {
        let off = |x: f64| ((x / cell - 0.5).rem_euclid(1.0) - 0.5).abs() * cell;
        let strength = |k: usize| 1.0 - smooth(half, half + 1.2 * footprint[k], off(p[k]));
        strength(0).max(strength(1)) * (0.22 * cell / footprint[0].max(footprint[1])).clamp(0.0, 1.0)
    };
    let fine = 0.5 * line(0.25, 0.001) * (1.0 - smooth(0.0, 0.45, away));
    let coarse = line(1.0, 0.003);
    let fade = 1.0 - smooth(0.35, 1.0, away);
    let dark = if is_dark { 1.0 - theme.shadow } else { 1.0 };
    [0, 1, 2].map(|k| {
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let c = mix(mix(theme.floor[k], theme.line[k], fine), theme.line[k], coarse);
        mix(theme.paper[k], c * dark, fade)
    })
}

/// Returns the colour of a corner under sun and sky.
fn shaded((p, n): Corner, colour: [f64; 3], eye: Vec3, theme: &Theme) -> [f64; 3] {
    let sun = Vec3::from(SUN).normalize();
    let v = (eye - p).normalize();
    let direct = n.dot(&sun).max(0.0);
    let near_ground = 0.62 + 0.38 * ((p.z + 0.02) / 0.27).clamp(0.0, 1.0);
    let spark = 0.16 * n.dot(&(sun + v).normalize()).max(0.0).powi(42) * direct;
    let rim = 0.35 * (1.0 - n.dot(&v).max(0.0)).powi(3);
    let half = n.z * 0.5 + 0.5;
    let (below, warm) = ([0.30, 0.28, 0.27], [1.02, 0.97, 0.9]);
    [0, 1, 2].map(|k| {
        let base = colour[k].powf(2.2);
        let sky = below[k] + (theme.sky[k] - below[k]) * half;
        (base * (sky * near_ground + direct * warm[k] + rim) + spark).max(0.0).powf(1.0 / 2.2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_triangle_is_seen_and_depth_is_right() {
        let mut canvas = Canvas::new(8, 8);
        let square = |depth: f64| [[0.0, 0.0, depth], [16.0, 0.0, depth], [0.0, 16.0, depth]];
        canvas.triangle(square(2.0), |_| [1.0; 3]);
        canvas.triangle(square(5.0), |_| [0.0; 3]);
        assert!(canvas.colour.iter().all(|c| *c == [1.0; 3]));
        assert!(canvas.depth.iter().all(|d| (*d - 2.0).abs() < 1e-6));
    }

    #[test]
    fn a_point_is_projected_as_a_pinhole_does() {
        let lens = Lens {
            eye: Vec3::new(4.0, 0.0, 0.0),
            right: Vec3::y(),
            up: Vec3::z(),
            back: Vec3::x(),
            focal: 100.0,
            near: 0.1,
            middle: [50.0, 50.0],
        };
        // Four metres away, one to the right and half a metre up.
        assert_eq!(lens.project(Vec3::new(0.0, 1.0, 0.5)), Some([75.0, 37.5, 4.0]));
        assert_eq!(lens.project(Vec3::new(5.0, 0.0, 0.0)), None);
    }
}
