//! The binary part of a glTF file, and what describes it.

use serde_json::{Value, json};

use super::Surface;
use lifelike_character::Vec3;

/// Numbers of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
/// Uses of a view.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Bytes, with a view and an accessor for each list of numbers.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds the times of frames (s); returns its accessor.
    pub fn times(&mut self, times: &[f32]) -> usize {
        let ends = json!({ "min": [times.first()], "max": [times.last()] });
        self.add(&times.iter().map(|time| [*time]).collect::<Vec<_>>(), "SCALAR", None, &ends)
    }

    /// Adds vectors of an animation.
    pub fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        self.add(vectors, if N == 3 { "VEC3" } else { "VEC4" }, None, &json!({}))
    }

    /// Adds a surface; returns its primitive.
    pub fn primitive(&mut self, surface: &Surface, material: usize) -> Value {
        let single = |all: &[Vec3]| all.iter().map(|v| v.map(|x| x as f32).into()).collect::<Vec<[f32; 3]>>();
        let points = single(&surface.points);
        let bound =
            |pick: fn(f32, f32) -> f32, start: f32| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).fold(start, pick));
        let ends = json!({ "min": bound(f32::min, f32::INFINITY), "max": bound(f32::max, f32::NEG_INFINITY) });
        let mut attributes = json!({ "POSITION": self.add(&points, "VEC3", Some(VERTICES), &ends) });
        if !surface.normals.is_empty() {
            attributes["NORMAL"] = json!(self.add(&single(&surface.normals), "VEC3", Some(VERTICES), &json!({})));
        }
        let bytes: Vec<u8> = surface.faces.iter().flatten().flat_map(|index| index.to_le_bytes()).collect();
        let indices = self.append(&bytes, 3 * surface.faces.len(), UNSIGNED, "SCALAR", Some(INDICES), &json!({}));
        json!({ "attributes": attributes, "indices": indices, "material": material })
    }

    fn add<const N: usize>(&mut self, rows: &[[f32; N]], kind: &str, target: Option<u32>, ends: &Value) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.append(&bytes, rows.len(), FLOAT, kind, target, ends)
    }

    fn append(
        &mut self,
        bytes: &[u8],
        count: usize,
        number: u32,
        kind: &str,
        target: Option<u32>,
        ends: &Value,
    ) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        let mut accessor =
            json!({ "bufferView": self.views.len(), "componentType": number, "count": count, "type": kind });
        for (name, value) in ends.as_object().into_iter().flatten() {
            accessor[name] = value.clone();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Returns the file: the document with what describes these bytes, then the bytes.
    pub fn into_file(self, mut document: Value) -> Vec<u8> {
        document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        document["bufferViews"] = Value::Array(self.views);
        document["accessors"] = Value::Array(self.accessors);
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut file = b"glTF".to_vec();
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        for number in [2, length as u32, text.len() as u32] {
            file.extend(number.to_le_bytes());
        }
        file.extend(b"JSON");
        file.extend(text);
        // Every number has four bytes, so their end is a multiple of four.
        file.extend((self.bytes.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(self.bytes);
        file
    }
}
