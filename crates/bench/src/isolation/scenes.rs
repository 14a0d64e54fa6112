//! Scenes that are small files and take long to draw.

use serde_json::{Value, json};

/// Makes `count` copies of a triangle in front of everything, at one position. A different `name` gives a different
/// file.
pub fn triangles(count: u32, name: &str) -> Vec<u8> {
    let indices: Vec<u8> = (0..count).flat_map(|_| [0_u32, 1, 2]).flat_map(u32::to_le_bytes).collect();
    let accessor = json!({"bufferView": 1, "componentType": 5125, "count": 3 * count, "type": "SCALAR"});
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    glb(name, &[primitive], Some((indices, accessor)))
}

/// Makes `count` primitives of one triangle, at one position.
pub fn primitives(count: usize, name: &str) -> Vec<u8> {
    let primitive = json!({"attributes": {"POSITION": 0}});
    glb(name, &vec![primitive; count], None)
}

/// Makes a file of one mesh with `primitives` that share three corners.
fn glb(name: &str, primitives: &[Value], indices: Option<(Vec<u8>, Value)>) -> Vec<u8> {
    let corners = [[-1.0_f32, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|coordinate| coordinate.to_le_bytes()).collect();
    let corner_bytes = bytes.len();
    let mut views = vec![json!({"buffer": 0, "byteOffset": 0, "byteLength": corner_bytes})];
    let mut accessors = vec![json!({
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0],
    })];
    if let Some((indices, accessor)) = indices {
        views.push(json!({"buffer": 0, "byteOffset": corner_bytes, "byteLength": indices.len()}));
        accessors.push(accessor);
        bytes.extend(indices);
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"name": name, "nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "buffers": [{"byteLength": bytes.len()}],
        "bufferViews": views,
        "accessors": accessors,
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let chunk = |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], &kind[..], data].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &bytes)].concat();
    let length = (12 + chunks.len()) as u32;
    [&b"glTF"[..], &2_u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The files are as small as the table states, and their geometry is drawn.
    #[test]
    fn scenes_are_small_and_read() {
        let cases = [
            (triangles(16_000, "a"), 188, 16_000),
            (triangles(64_000, "a"), 750, 64_000),
            (primitives(100_000, "a"), 2_930, 100_000),
        ];
        for (glb, kib, triangles) in cases {
            assert_eq!(glb.len() / 1024, kib);
            let scene = assets::load_bytes(&glb).expect("a scene").scene;
            let primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
            assert_eq!(primitives.map(|primitive| primitive.indices.len() / 3).sum::<usize>(), triangles);
        }
    }
}
