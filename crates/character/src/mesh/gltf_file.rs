//! glTF 2.0: binary (`.glb`), or text with buffers in files beside it.

use std::path::Path;

use gltf::Gltf;
use gltf::buffer::Source;
use gltf::mesh::Mode;

use super::Triangles;

/// Reads all triangles of a file's scenes, each where its node puts it. glTF has y up; a robot's file turns it where it has to.
///
/// # Errors
/// A sentence: the file cannot be read, or a buffer is missing.
pub(super) fn read(path: &Path) -> Result<Triangles, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let file = Gltf::from_slice(&bytes).map_err(|e| e.to_string())?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut buffers = Vec::new();
    for buffer in file.buffers() {
        buffers.push(match buffer.source() {
            Source::Bin => file.blob.clone().ok_or("expected a binary part, got none")?,
            Source::Uri(uri) if uri.starts_with("data:") => {
                return Err("expected buffers in a .glb or in files, got a data: URI".into());
            }
            Source::Uri(uri) => std::fs::read(folder.join(uri)).map_err(|e| format!("{uri}: {e}"))?,
        });
    }
    let mut all = Triangles::default();
    let mut nodes: Vec<(gltf::Node, Placement)> =
        file.scenes().flat_map(|scene| scene.nodes().map(|node| (node, IDENTITY)).collect::<Vec<_>>()).collect();
    while let Some((node, outer)) = nodes.pop() {
        let place = product(&outer, &node.transform().matrix());
        nodes.extend(node.children().map(|child| (child, place)));
        for part in node.mesh().iter().flat_map(gltf::Mesh::primitives).filter(|part| part.mode() == Mode::Triangles) {
            let reader = part.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
            let points: Vec<[f32; 3]> =
                reader.read_positions().into_iter().flatten().map(|p| moved(&place, p)).collect();
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..points.len() as u32).collect(),
            };
            all.append(points, indices.chunks_exact(3).map(|face| [face[0], face[1], face[2]]).collect());
        }
    }
    Ok(all)
}

/// A transformation as four columns.
type Placement = [[f32; 4]; 4];

const IDENTITY: Placement = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn product(a: &Placement, b: &Placement) -> Placement {
    b.map(|column| [0, 1, 2, 3].map(|row| (0..4).map(|k| a[k][row] * column[k]).sum()))
}

fn moved(place: &Placement, p: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|row| place[3][row] + (0..3).map(|k| place[k][row] * p[k]).sum::<f32>())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_triangle_stands_where_its_node_puts_it() {
        let folder = tempfile::tempdir().unwrap();
        let points: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let bytes: Vec<u8> = points.iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(folder.path().join("t.bin"), bytes).unwrap();
        let text = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
            "nodes":[{"children":[1],"translation":[0,0,2]},{"mesh":0,"scale":[3,1,1]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "buffers":[{"uri":"t.bin","byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
        let file = folder.path().join("t.gltf");
        std::fs::write(&file, text).unwrap();
        let read = read(&file).unwrap();
        assert_eq!(read.points, [[0.0, 0.0, 2.0], [3.0, 0.0, 2.0], [0.0, 1.0, 2.0]]);
        assert_eq!(read.faces, [[0, 1, 2]]);
    }
}
