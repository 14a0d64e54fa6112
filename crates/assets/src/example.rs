//! Scene of `bendylights example`: a glTF file that anybody may open, change and redistribute.

use glam::{DQuat, DVec3, Vec3};
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, INTENSITY, NAME};
use light::{Light, Transform};
use scene::{Camera, Primitive, Projection, Scene};
use serde_json::{Value, json};

use crate::demo;

/// Chunk types of a `.glb` file: JSON and binary data.
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;
/// glTF's constants for component types.
const F32: u32 = 5126;
const U32: u32 = 5125;

/// Returns the scene `demo:vases` as a `.glb` file with its camera. A spotlight called `lamp` replaces its
/// BendyLight at the same position, for the user to bend.
pub fn example_glb() -> Vec<u8> {
    let loaded = demo("vases").expect("a demo scene");
    let translation = loaded.contents.lights[0].light().transform().translation;
    let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, (DVec3::new(0.0, 0.3, 0.0) - translation).normalize());
    let lamp = Light::spot()
        .with_transform(Transform { translation, rotation, scale: 1.0 })
        .with(NAME, "lamp".into())
        .with(INTENSITY, 80.0)
        .with(CONE_ANGLE, 25.0)
        .with(CONE_SOFTNESS, 0.3);
    glb(&loaded.scene, &loaded.contents.cameras, &lamp)
}

/// Returns the BendyLight of the scene `demo:vases`, for a light file.
pub fn example_light() -> Light {
    demo("vases").expect("a demo scene").contents.lights[0].light().clone()
}

/// Serializes a scene without textures, with its cameras and a spotlight. Nodes must have no parents.
fn glb(scene: &Scene, cameras: &[Camera], lamp: &Light) -> Vec<u8> {
    let mut file = GlbBuilder::default();
    let meshes: Vec<Value> = scene.meshes.iter().map(|mesh| file.mesh(&mesh.name, &mesh.primitives)).collect();
    let materials: Vec<Value> = (scene.materials.iter())
        .map(|material| {
            json!({
                "name": material.name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": material.base_color.to_array(),
                    "metallicFactor": material.metallic,
                    "roughnessFactor": material.roughness,
                },
            })
        })
        .collect();
    let mut nodes: Vec<Value> = (scene.nodes.iter())
        .map(|node| {
            let (_, rotation, translation) = node.parent_from_local.to_scale_rotation_translation();
            let mut placed = node_json(&node.name, translation, rotation);
            placed["mesh"] = json!(node.mesh);
            placed
        })
        .collect();
    for (index, camera) in cameras.iter().enumerate() {
        let mut placed = node_json(&camera.name, camera.translation, camera.rotation);
        placed["camera"] = json!(index);
        nodes.push(placed);
    }
    let transform = lamp.transform();
    let mut placed = node_json(lamp.name(), transform.translation, transform.rotation);
    placed["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    nodes.push(placed);
    let cone = lamp.get(CONE_ANGLE).to_radians();
    let document = json!({
        "asset": {"version": "2.0", "generator": "bendylights example"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{
            "type": "spot",
            "name": lamp.name(),
            "intensity": lamp.get(INTENSITY),
            "spot": {"innerConeAngle": cone * (1.0 - lamp.get(CONE_SOFTNESS)), "outerConeAngle": cone},
        }]}},
        "scene": 0,
        "scenes": [{"name": "room", "nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "cameras": cameras.iter().map(written_camera).collect::<Vec<_>>(),
        "meshes": meshes,
        "materials": materials,
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.bytes.len()}],
    });
    container(document.to_string().into_bytes(), file.bytes)
}

fn node_json(name: &str, translation: DVec3, rotation: DQuat) -> Value {
    json!({"name": name, "translation": translation.to_array(), "rotation": rotation.to_array()})
}

fn written_camera(camera: &Camera) -> Value {
    match camera.projection {
        Projection::Perspective { yfov, znear, .. } => {
            json!({"name": camera.name, "type": "perspective", "perspective": {"yfov": yfov, "znear": znear}})
        }
        Projection::Orthographic { ymag, znear, zfar, .. } => json!({
            "name": camera.name,
            "type": "orthographic",
            "orthographic": {"xmag": ymag, "ymag": ymag, "znear": znear, "zfar": zfar},
        }),
    }
}

/// Binary chunk of the file, and the JSON that describes it.
#[derive(Default)]
struct GlbBuilder {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbBuilder {
    fn mesh(&mut self, name: &str, primitives: &[Primitive]) -> Value {
        let primitives: Vec<Value> = (primitives.iter())
            .map(|primitive| {
                json!({
                    "attributes": {
                        "POSITION": self.vectors(&primitive.positions),
                        "NORMAL": self.vectors(&primitive.normals),
                    },
                    "indices": self.indices(&primitive.indices),
                    "material": primitive.material,
                })
            })
            .collect();
        json!({"name": name, "primitives": primitives})
    }

    fn vectors(&mut self, vectors: &[Vec3]) -> usize {
        let bytes = vectors.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect();
        let (low, high) =
            vectors.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        let bounds = json!({"min": low.to_array(), "max": high.to_array()});
        self.accessor(bytes, json!({"type": "VEC3", "componentType": F32, "count": vectors.len()}), &bounds)
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(bytes, json!({"type": "SCALAR", "componentType": U32, "count": indices.len()}), &json!({}))
    }

    /// Adds an accessor with a buffer view of its own. All its numbers have four bytes.
    fn accessor(&mut self, bytes: Vec<u8>, mut accessor: Value, bounds: &Value) -> usize {
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        accessor["bufferView"] = json!(self.views.len() - 1);
        for (name, bound) in bounds.as_object().into_iter().flatten() {
            accessor[name] = bound.clone();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// Returns a GLB container: a header and two chunks, each padded to four bytes.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(length);
    file.extend(b"glTF");
    for number in [2, length as u32, json.len() as u32, JSON_CHUNK] {
        file.extend(number.to_le_bytes());
    }
    file.extend(json);
    for number in [binary.len() as u32, BINARY_CHUNK] {
        file.extend(number.to_le_bytes());
    }
    file.extend(binary);
    file
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_bytes;

    #[test]
    fn the_example_is_read_as_it_was_written() {
        let (made, read) = (demo("vases").expect("a demo"), load_bytes(&example_glb()).expect("glTF"));
        assert_eq!(read.notes, [""; 0]);
        let primitives =
            |scene: &Scene| scene.meshes.iter().flat_map(|mesh| mesh.primitives.clone()).collect::<Vec<_>>();
        let [ours, theirs] = [&made, &read].map(|loaded| primitives(&loaded.scene));
        assert_eq!(ours.len(), theirs.len());
        for (ours, theirs) in ours.iter().zip(&theirs) {
            assert!(ours.positions == theirs.positions && ours.indices == theirs.indices);
            // The import normalizes them again.
            let mut normals = ours.normals.iter().zip(&theirs.normals);
            assert!(normals.all(|(ours, theirs)| ours.distance(*theirs) < 1e-6));
        }
        let colors = |scene: &Scene| -> Vec<_> {
            scene.materials.iter().map(|m| (m.name.clone(), m.base_color, m.roughness, m.metallic)).collect()
        };
        // The import adds a material for primitives without one.
        assert_eq!(colors(&read.scene)[..made.scene.materials.len()], colors(&made.scene));
        let [camera, written] = [&read, &made].map(|loaded| loaded.contents.cameras[0].clone());
        assert!(camera.translation.distance(written.translation) < 1e-6, "f32 of glTF's JSON");
        let lamp = read.contents.lights[0].light();
        assert_eq!((read.contents.lights.len(), lamp.name()), (1, "lamp"));
        assert!((lamp.get(CONE_ANGLE) - 25.0).abs() < 1e-5 && (lamp.get(CONE_SOFTNESS) - 0.3).abs() < 1e-5);
    }
}
