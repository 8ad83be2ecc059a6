//! A character's shapes as markers that move with its frames.

use lifelike_character::{Character, Geom, GeomShape, Quat, Vec3};

use super::cdr::Message;

/// Types of `visualization_msgs/Marker`.
const CUBE: i32 = 1;
const SPHERE: i32 = 2;
const CYLINDER: i32 = 3;
const TRIANGLES: i32 = 11;
/// Colour of the reference: the page's.
const GHOST: [f32; 4] = [0.18, 0.61, 0.55, 0.35];
/// MuJoCo's colour of geoms without one, and the colour shown instead.
const GREY: [f32; 3] = [0.5; 3];
const PLAIN: [f32; 4] = [0.86, 0.52, 0.33, 1.0];

/// One marker of a body.
struct Marker {
    kind: i32,
    position: Vec3,
    orientation: Quat,
    scale: Vec3,
    points: Vec<Vec3>,
}

/// Returns a `visualization_msgs/MarkerArray` of everything that is drawn.
pub(super) fn markers(character: &Character, prefix: &str, ghost: bool) -> Message {
    let drawn = character.geoms.iter().filter(|geom| geom.body != 0 && character.is_drawn(geom));
    let all: Vec<(&Geom, Marker)> = drawn.flat_map(|g| of(g, character).into_iter().map(move |m| (g, m))).collect();
    let mut message = Message::new().len(all.len());
    for (id, (geom, marker)) in all.iter().enumerate() {
        let [r, g, b, _] = geom.rgba;
        let own = if [r, g, b] == GREY { PLAIN } else { geom.rgba };
        let frame = format!("{prefix}/{}", character.bodies[geom.body].name);
        message = message.header(0, &frame).text(prefix).put(id as i32).put(marker.kind).put(0_i32);
        message = message.pose(&marker.position, &marker.orientation).vector(&marker.scale);
        message = (if ghost { GHOST } else { own }).iter().fold(message, |message, c| message.put(*c));
        // It never expires, and moves with its frame.
        message = message.put(0_i32).put(0_u32).put(1_u8);
        message = marker.points.iter().fold(message.len(marker.points.len()), |message, p| message.vector(p));
        message = message.len(0).text("").text("").put(0_u8);
    }
    message
}

/// Returns the markers of a geom; none where its mesh cannot be read.
fn of(geom: &Geom, character: &Character) -> Vec<Marker> {
    let marker = |kind: i32, along: f64, scale: Vec3| Marker {
        kind,
        position: geom.position + geom.orientation * (Vec3::z() * along),
        orientation: geom.orientation,
        scale,
        points: Vec::new(),
    };
    match &geom.shape {
        GeomShape::Sphere(r) => vec![marker(SPHERE, 0.0, Vec3::repeat(2.0 * r))],
        GeomShape::Ellipsoid(half) => vec![marker(SPHERE, 0.0, half * 2.0)],
        GeomShape::Box(half) => vec![marker(CUBE, 0.0, half * 2.0)],
        GeomShape::Cylinder(r, half) => vec![marker(CYLINDER, 0.0, Vec3::new(2.0 * r, 2.0 * r, 2.0 * half))],
        GeomShape::Capsule(r, half) => vec![
            marker(CYLINDER, 0.0, Vec3::new(2.0 * r, 2.0 * r, 2.0 * half)),
            marker(SPHERE, *half, Vec3::repeat(2.0 * r)),
            marker(SPHERE, -half, Vec3::repeat(2.0 * r)),
        ],
        GeomShape::Mesh(name) => {
            let Some(Ok(mesh)) = character.meshes.get(name).map(|mesh| mesh.triangles()) else { return Vec::new() };
            let point = |i: &u32| mesh.points.get(*i as usize).map(|p| Vec3::from(p.map(f64::from)));
            let points = mesh.faces.iter().flatten().filter_map(point).collect();
            vec![Marker { points, ..marker(TRIANGLES, 0.0, Vec3::repeat(1.0)) }]
        }
        GeomShape::Plane | GeomShape::HeightField(_) => Vec::new(),
    }
}
