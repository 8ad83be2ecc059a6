//! Definitions of the ROS 2 messages in a record, as a record must carry them.

pub(super) const TF: &str = "tf2_msgs/msg/TFMessage";
pub(super) const JOINTS: &str = "sensor_msgs/msg/JointState";
pub(super) const WRENCH: &str = "geometry_msgs/msg/WrenchStamped";
pub(super) const MARKERS: &str = "visualization_msgs/msg/MarkerArray";

/// Messages that others are made of, with their fields.
const PARTS: [(&str, &str); 12] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    ("geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    (
        "visualization_msgs/Marker",
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
         geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n\
         bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring text\n\
         string mesh_resource\nbool mesh_use_embedded_materials\n",
    ),
];

/// Returns the definition of a message, followed by those of its parts.
pub(super) fn text(kind: &str) -> String {
    let own = match kind {
        TF => "geometry_msgs/TransformStamped[] transforms\n",
        JOINTS => "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        WRENCH => "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
        _ => "visualization_msgs/Marker[] markers\n",
    };
    let mut text = own.to_string();
    let mut wanted = parts_of(own);
    let mut done = Vec::new();
    while let Some((name, fields)) = wanted.pop() {
        if !done.contains(&name) {
            done.push(name);
            text += &format!("{}\nMSG: {name}\n{fields}", "=".repeat(80));
            wanted.extend(parts_of(fields));
        }
    }
    text
}

/// Returns the messages that fields are made of.
fn parts_of(fields: &str) -> Vec<(&'static str, &'static str)> {
    let types = |line: &str| line.split([' ', '[']).next().unwrap_or_default().to_string();
    let all: Vec<String> = fields.lines().map(types).collect();
    PARTS.into_iter().filter(|(name, _)| all.iter().any(|t| t == name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_a_definition_is_defined() {
        for kind in [TF, JOINTS, WRENCH, MARKERS] {
            let text = text(kind);
            for line in text.lines().filter(|l| !l.starts_with("MSG") && l.contains('/')) {
                let name = line.split([' ', '[']).next().unwrap_or_default();
                assert!(text.contains(&format!("MSG: {name}\n")), "{kind}: {name}");
            }
        }
    }
}
