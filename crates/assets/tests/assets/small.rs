//! Tests with small files, one feature each, against results computed by hand.

use std::f64::consts::FRAC_PI_3;
use std::path::Path;

use assets::{AssetError, AssetFault, ImportLimit, LoadedScene};
use document::SceneContents;
use glam::{DVec3, Vec2, Vec3, Vec4};
use light::parameters::{COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, INTENSITY, RANGE};
use light::{Decay, LightShape};
use scene::{Primitive, Projection, Sampler, Wrap};

/// File under construction: JSON members as text, and one buffer.
#[derive(Default)]
struct File {
    accessors: Vec<String>,
    views: Vec<String>,
    bytes: Vec<u8>,
    members: Vec<String>,
}

impl File {
    /// Makes a file with an accessor over the first `count` corners of [`QUAD`], and returns the accessor's index.
    fn with_corners(count: usize) -> (Self, usize) {
        let mut file = Self::default();
        let positions = file.floats(&QUAD[..count]);
        (file, positions)
    }

    /// Adds an accessor over `bytes`; `about` holds its type and count.
    fn accessor(&mut self, about: &str, bytes: &[u8]) -> usize {
        let (offset, view) = (self.bytes.len(), self.views.len());
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}}}"#, bytes.len()));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.accessors.push(format!(r#"{{"bufferView":{view},{about}}}"#));
        self.accessors.len() - 1
    }

    /// Adds a float accessor of vectors of `N` components.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let about = format!(r#""componentType":5126,"type":"VEC{N}","count":{}"#, values.len());
        self.accessor(&about, &bytes)
    }

    /// Adds a top-level member of the JSON.
    fn with(mut self, member: impl Into<String>) -> Self {
        self.members.push(member.into());
        self
    }

    fn json(&self) -> String {
        let mut members = self.members.clone();
        if !self.bytes.is_empty() {
            members.push(format!(r#""accessors":[{}]"#, self.accessors.join(",")));
            members.push(format!(r#""bufferViews":[{}]"#, self.views.join(",")));
            members.push(format!(r#""buffers":[{{"byteLength":{},"uri":"a%20b.bin"}}]"#, self.bytes.len()));
        }
        format!(r#"{{"asset":{{"version":"2.0"}},{}}}"#, members.join(","))
    }

    fn load(&self) -> Result<LoadedScene, AssetError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a b.bin"), &self.bytes).unwrap();
        std::fs::write(folder.path().join("scene.gltf"), self.json()).unwrap();
        assets::load(&folder.path().join("scene.gltf"))
    }
}

/// Corners of a quad in strip order, in the plane z = 0.
const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

/// Returns the members for one node with one mesh with one primitive.
fn one(primitive: &str) -> String {
    format!(r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{{primitive}}}]}}]"#)
}

/// Returns the members for one triangle list with positions alone.
fn positioned(positions: usize) -> String {
    one(&format!(r#""attributes":{{"POSITION":{positions}}}"#))
}

fn only_primitive(loaded: &LoadedScene) -> &Primitive {
    assert_eq!((loaded.scene.meshes.len(), loaded.scene.meshes[0].primitives.len()), (1, 1));
    &loaded.scene.meshes[0].primitives[0]
}

/// Returns the corner positions in drawing order.
fn corners(primitive: &Primitive) -> Vec<Vec3> {
    primitive.indices.iter().map(|&i| primitive.positions[i as usize]).collect()
}

fn pick(order: &[usize]) -> Vec<Vec3> {
    order.iter().map(|&i| Vec3::from_array(QUAD[i])).collect()
}

#[test]
fn strips_and_fans_become_lists_that_wind_alike() {
    for (mode, expected) in [(5, [0, 1, 2, 1, 3, 2]), (6, [1, 2, 0, 2, 3, 0])] {
        let (file, positions) = File::with_corners(4);
        let loaded =
            file.with(one(&format!(r#""mode":{mode},"attributes":{{"POSITION":{positions}}}"#))).load().unwrap();
        assert_eq!(corners(only_primitive(&loaded)), pick(&expected), "mode {mode}");
        assert_eq!(only_primitive(&loaded).normals[0], Vec3::Z, "the first triangle of both faces +Z");
    }
}

#[test]
fn indices_of_every_type_are_read() {
    let order = [2_u8, 1, 3];
    let wide: Vec<u8> = order.iter().flat_map(|&i| u16::from(i).to_le_bytes()).collect();
    let widest: Vec<u8> = order.iter().flat_map(|&i| u32::from(i).to_le_bytes()).collect();
    for (kind, bytes) in [(5121, order.to_vec()), (5123, wide), (5125, widest)] {
        let (mut file, positions) = File::with_corners(4);
        let indices = file.accessor(&format!(r#""componentType":{kind},"type":"SCALAR","count":3"#), &bytes);
        let primitive = format!(r#""attributes":{{"POSITION":{positions}}},"indices":{indices}"#);
        assert_eq!(corners(only_primitive(&file.with(one(&primitive)).load().unwrap())), pick(&[2, 1, 3]), "{kind}");
    }
}

#[test]
fn lines_are_left_out_with_a_note_and_half_a_triangle_too() {
    for (mode, message) in [(1, "points and lines"), (4, "without a whole triangle")] {
        let (file, positions) = File::with_corners(2);
        let loaded =
            file.with(one(&format!(r#""mode":{mode},"attributes":{{"POSITION":{positions}}}"#))).load().unwrap();
        assert!(loaded.scene.meshes[0].primitives.is_empty());
        assert!(loaded.notes[0].contains(message), "{:?}", loaded.notes);
    }
}

#[test]
fn quantized_attributes_are_scaled_as_declared() {
    let mut file = File::default();
    // glTF aligns elements to four bytes: here by a fourth component that the view's stride skips.
    let about = |kind: u32, normalized: bool| {
        format!(r#""componentType":{kind},"type":"VEC3","count":3,"normalized":{normalized}"#)
    };
    let positions = file.accessor(&about(5121, false), &[0, 0, 0, 0, 200, 0, 0, 0, 0, 200, 0, 0]);
    let normals = file.accessor(&about(5120, true), &[0, 0, 0x81, 0, 0, 0, 127, 0, 0, 0, 127, 0]);
    for view in &mut file.views {
        *view = view.replace('}', r#","byteStride":4}"#);
    }
    let colors = file.accessor(r#""componentType":5121,"type":"VEC4","count":3"#, &[255, 0, 51, 255].repeat(3));
    let primitive = format!(r#""attributes":{{"POSITION":{positions},"NORMAL":{normals},"COLOR_0":{colors}}}"#);
    let file = file.with(r#""extensionsRequired":["KHR_mesh_quantization"]"#).with(one(&primitive));
    let loaded = file.load().unwrap();
    let made = only_primitive(&loaded);
    assert_eq!(made.positions, [Vec3::ZERO, Vec3::X * 200.0, Vec3::Y * 200.0]);
    assert_eq!(made.normals, [-Vec3::Z, Vec3::Z, Vec3::Z]);
    assert_eq!(made.colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
}

#[test]
fn sparse_elements_replace_those_of_the_view_or_zeros() {
    let mut file = File::default();
    let dense = file.floats(&QUAD[..3]);
    let at = file.accessor(r#""componentType":5121,"type":"SCALAR","count":1"#, &[1]);
    let to = file.floats(&[[7.0_f32, 8.0, 9.0]]);
    let sparse = format!(
        r#""sparse":{{"count":1,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{to}}}}}"#
    );
    let about = r#""componentType":5126,"type":"VEC3","count":3"#;
    for (base, first) in [(format!(r#""bufferView":{dense},"#), Vec3::Y), (String::new(), Vec3::ZERO)] {
        let mut file = File {
            accessors: file.accessors.clone(),
            views: file.views.clone(),
            bytes: file.bytes.clone(),
            ..File::default()
        };
        file.accessors.push(format!("{{{base}{about},{sparse}}}"));
        let positions = file.accessors.len() - 1;
        let loaded = file.with(positioned(positions)).load().unwrap();
        assert_eq!(only_primitive(&loaded).positions, [Vec3::ZERO, Vec3::new(7.0, 8.0, 9.0), first]);
    }
}

/// Sparse indices that repeat or are out of order are refused (glTF 2.0, section 3.6.2.3).
#[test]
fn sparse_indices_increase() {
    let loaded = |indices: [u8; 2]| {
        let mut file = File::default();
        let at = file.accessor(r#""componentType":5121,"type":"SCALAR","count":2"#, &indices);
        let to = file.floats(&[[7.0_f32, 8.0, 9.0], [1.0, 2.0, 3.0]]);
        file.accessors.push(format!(
            r#"{{"componentType":5126,"type":"VEC3","count":3,"sparse":{{"count":2,
            "indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{to}}}}}}}"#
        ));
        let positions = file.accessors.len() - 1;
        file.with(positioned(positions)).load()
    };
    let sound = loaded([0, 2]).unwrap();
    assert_eq!(only_primitive(&sound).positions[2], Vec3::new(1.0, 2.0, 3.0));
    for indices in [[2, 0], [1, 1]] {
        let message = loaded(indices).unwrap_err().to_string();
        assert!(message.contains("the indices of a sparse accessor do not strictly increase"), "{message}");
        assert_eq!(message.lines().count(), 1);
    }
}

#[test]
fn nodes_compose_from_matrix_and_parts() {
    let (file, positions) = File::with_corners(3);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let nodes = format!(
        r#""nodes":[{{"children":[1],"matrix":[2,0,0,0, 0,2,0,0, 0,0,2,0, 10,0,0,1]}},
        {{"mesh":0,"translation":[0,1,0],"rotation":[0,0,{half},{half}],"scale":[1,3,1]}}],"scenes":[{{"nodes":[0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}}}}]}}]"#
    );
    let scene = file.with(nodes).load().unwrap().scene;
    let posed = scene::pose(scene, 0.0);
    let world = |v: DVec3| posed.primitives[0].world_from_local.transform_point3(v);
    // Scale, quarter turn about Z, translation, then the parent: (x, y) -> (-3y, x) -> (10 - 6y, 2x + 2).
    for (local, expected) in
        [(DVec3::ZERO, [10.0, 2.0, 0.0]), (DVec3::X, [10.0, 4.0, 0.0]), (DVec3::Y, [4.0, 2.0, 0.0])]
    {
        // The quaternion is stored in f32.
        assert!((world(local) - DVec3::from_array(expected)).length() < 1e-5, "{local}");
    }
}

#[test]
fn textures_have_their_sampler_coordinates_and_transform() {
    let mut png = Vec::new();
    let pixels = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 0, 255, 128]).unwrap();
    pixels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let (mut file, positions) = File::with_corners(3);
    let (first, second) = (file.floats(&[[9.0_f32, 9.0]; 3]), file.floats(&[[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]]));
    let picture = file.accessor(r#""componentType":5121,"type":"SCALAR","count":1"#, &png);
    let attributes = format!(r#""POSITION":{positions},"TEXCOORD_0":{first},"TEXCOORD_1":{second}"#);
    let loaded = file
        .with(format!(r#""images":[{{"bufferView":{picture},"mimeType":"image/png"}}]"#))
        .with(r#""samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}],"textures":[{"source":0,"sampler":0},{"source":0}]"#)
        .with(
            r#""materials":[{"alphaMode":"MASK","doubleSided":true,"pbrMetallicRoughness":{"metallicFactor":0,
            "baseColorTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[2,3]}}},
            "metallicRoughnessTexture":{"index":1}}}]"#,
        )
        .with(one(&format!(r#""attributes":{{{attributes}}},"material":0"#)))
        .load()
        .unwrap();
    assert_eq!(only_primitive(&loaded).uvs, [Vec2::new(0.5, 0.0), Vec2::new(2.5, 0.0), Vec2::new(0.5, 3.0)]);
    let material = &loaded.scene.materials[0];
    let base = material.base_color_texture.unwrap();
    let sampler = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::MirroredRepeat, nearest: true };
    assert_eq!((base.image, base.sampler), (0, sampler));
    assert_eq!(material.metallic_roughness_texture.unwrap().sampler, Sampler::default());
    assert_eq!((material.alpha_cutoff, material.double_sided), (Some(0.5), true));
    assert_eq!(loaded.scene.images.len(), 1, "decoded once");
    assert_eq!(loaded.scene.images[0].rgba8, pixels.into_raw());
    assert!(loaded.notes[0].contains("placed as its base colour"), "{:?}", loaded.notes);
}

#[test]
fn lights_and_cameras_stand_rigid_in_the_world() {
    let loaded = File::default()
        .with(
            r#""extensions":{"KHR_lights_punctual":{"lights":[
            {"type":"spot","intensity":40,"color":[1,0.5,0],"range":9,"spot":{"innerConeAngle":0.4,"outerConeAngle":0.5}},
            {"type":"point","name":"bulb","intensity":60,"range":4},{"type":"spot","intensity":-1,"spot":{"outerConeAngle":0}},
            {"type":"directional","intensity":3,"color":[1,-2,0.5],"range":0}]}}"#,
        )
        .with(
            r#""cameras":[{"type":"perspective","perspective":{"yfov":1.0471975511965976,"znear":0.1}},
            {"type":"orthographic","orthographic":{"xmag":2,"ymag":1,"znear":0,"zfar":5}}]"#,
        )
        .with(
            r#""nodes":[{"name":"rig","translation":[1,2,3],"scale":[5,1,2],"rotation":[0,0.7071067811865476,0,0.7071067811865476],
            "camera":0,"extensions":{"KHR_lights_punctual":{"light":0}}},
            {"camera":1,"extensions":{"KHR_lights_punctual":{"light":1}}},{"extensions":{"KHR_lights_punctual":{"light":2}}},
            {"name":"sun","rotation":[-0.7071067811865476,0,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":3}}}]"#,
        )
        .load()
        .unwrap();
    let SceneContents { lights, cameras } = loaded.contents;
    let spot = lights[0].light();
    assert_eq!((lights.len(), spot.shape(), spot.name()), (4, &LightShape::Spot, "rig"));
    assert!((spot.get(CONE_ANGLE) - 0.5_f64.to_degrees()).abs() < 1e-5);
    assert!((spot.get(CONE_SOFTNESS) - 0.2).abs() < 1e-6);
    assert_eq!((spot.get(RANGE), spot.get(INTENSITY)), (Some(9.0), 40.0));
    let shines_along = spot.transform().rotation * DVec3::NEG_Z;
    assert!((shines_along - DVec3::NEG_X).length() < 1e-6, "a quarter turn about Y takes -Z to -X: {shines_along}");
    let [bulb, broken, sun] = [1, 2, 3].map(|index| lights[index].light());
    assert_eq!((bulb.shape(), bulb.name(), bulb.get(DECAY)), (&LightShape::Omni, "bulb", Decay::InverseSquare));
    assert_eq!((bulb.get(RANGE), bulb.get(INTENSITY)), (Some(4.0), 60.0));
    assert_eq!((sun.shape(), sun.name(), sun.get(INTENSITY)), (&LightShape::Directional, "sun", 3.0));
    assert_eq!(sun.get(COLOR), DVec3::new(1.0, 0.0, 0.5));
    assert!((sun.transform().rotation * DVec3::NEG_Z - DVec3::NEG_Y).length() < 1e-6);
    // A light with invalid numbers is repaired, so that its author can find it.
    assert_eq!((broken.shape(), broken.get(INTENSITY)), (&LightShape::Spot, 0.0));
    assert_eq!(broken.get(CONE_ANGLE), 45.0);
    let looks_along = cameras[0].rotation * DVec3::NEG_Z;
    assert!((looks_along - DVec3::NEG_X).length() < 1e-6, "{looks_along}");
    let Projection::Perspective { yfov, .. } = cameras[0].projection else { panic!("perspective") };
    assert!((yfov - FRAC_PI_3).abs() < 1e-7);
    assert_eq!(
        cameras[1].projection,
        Projection::Orthographic { ymag: 1.0, aspect_ratio: Some(2.0), znear: 0.0, zfar: 5.0 }
    );
    let repaired = [
        "colors and intensities below 0 are taken as 0: light 2 and 1 more",
        "cone angles that are not more than 0 are taken as 45 degrees: light 2",
    ];
    assert_eq!(loaded.notes, repaired);
}

/// A name has more bytes than characters.
#[test]
fn long_names_of_lights_are_cut() {
    let name = "\u{5149}".repeat(300);
    let file = File::default()
        .with(r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"directional"}]}}"#)
        .with(format!(r#""nodes":[{{"name":"{name}","extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#));
    let loaded = file.load().unwrap();
    let lights = loaded.contents.lights;
    assert_eq!(lights.len(), 1);
    assert_eq!(lights[0].light().name(), "\u{5149}".repeat(85), "256 bytes hold so many");
}

#[test]
fn cameras_keep_their_shape() {
    let read = |camera: &str| {
        let file = File::default().with(format!(r#""cameras":[{camera}],"nodes":[{{"camera":0}}]"#));
        let loaded = file.load().unwrap();
        (loaded.contents.cameras[0].projection.aspect_ratio(), loaded.notes.len())
    };
    let perspective = |more: &str| format!(r#"{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1{more}}}}}"#);
    assert_eq!(read(&perspective(r#","aspectRatio":1.5"#)), (Some(1.5), 0));
    assert_eq!(read(&perspective("")), (None, 0), "the picture's own");
    let orthographic = |xmag: f64| {
        format!(r#"{{"type":"orthographic","orthographic":{{"xmag":{xmag},"ymag":4,"znear":0,"zfar":5}}}}"#)
    };
    assert_eq!(read(&orthographic(2.0)), (Some(0.5), 0));
    for bad in [perspective(r#","aspectRatio":0"#), perspective(r#","aspectRatio":-2"#), orthographic(-1.0)] {
        assert_eq!(read(&bad), (None, 1), "a note: {bad}");
    }
}

#[test]
fn instances_have_the_transforms_of_their_accessors() {
    let (mut file, positions) = File::with_corners(3);
    let at = file.floats(&[[1.0_f32, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    let node = format!(
        r#""nodes":[{{"mesh":0,"translation":[0,0,9],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{at}}}}}}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}}}}]}}]"#
    );
    let scene = file.with(node).load().unwrap().scene;
    let translations: Vec<DVec3> =
        scene::pose(scene, 0.0).primitives.iter().map(|p| p.world_from_local.translation).collect();
    assert_eq!(translations, [DVec3::new(1.0, 0.0, 9.0), DVec3::new(0.0, 5.0, 9.0)]);
}

#[test]
fn errors_name_the_exceeded_limit() {
    let many = vec!["{}"; 600_000].join(",");
    let fault = File::default().with(format!(r#""nodes":[{many}]"#)).load().unwrap_err().fault;
    assert!(matches!(fault, AssetFault::Limit { limit: ImportLimit::JsonValues, .. }), "{fault}");

    let (mut file, positions) = File::with_corners(3);
    file.accessors[positions] = r#"{"componentType":5126,"type":"VEC3","count":900000000}"#.into();
    let fault = file.with(positioned(positions)).load().unwrap_err().fault;
    assert!(matches!(fault, AssetFault::Limit { limit: ImportLimit::Vertices, .. }), "{fault}");

    let (file, positions) = File::with_corners(3);
    let far = positioned(positions).replace(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[2e9,1,1]}"#);
    let fault = file.with(far).load().unwrap_err().fault;
    assert!(matches!(fault, AssetFault::Limit { limit: ImportLimit::Coordinate, .. }), "{fault}");
}

#[test]
fn a_mesh_with_an_index_of_no_accessor_is_refused_not_followed() {
    let fault = File::default().with(one(r#""attributes":{"POSITION":7}"#)).load().unwrap_err().fault;
    assert!(fault.to_string().contains("accessor 7"), "{fault}");
}

#[test]
fn required_extensions_are_refused_by_name() {
    let error = File::default().with(r#""extensionsRequired":["VENDOR_magic"]"#).load().unwrap_err().to_string();
    assert!(
        error.ends_with("scene.gltf: VENDOR_magic is required but not supported: export the scene without it"),
        "{error}"
    );
}

/// An extension that changes only appearance is left out with a note, even if required. One that changes the
/// reading of geometry is refused.
#[test]
fn required_extensions_that_change_only_looks_are_noted() {
    for name in ["KHR_materials_clearcoat", "KHR_materials_transmission", "KHR_materials_pbrSpecularGlossiness"] {
        let listed = format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"]"#);
        let loaded = File::default().with(listed).load().unwrap();
        let note = format!("extensions that are not drawn: {name}");
        assert_eq!(loaded.notes.concat(), note);
        let only_required = format!(r#""extensionsRequired":["{name}"]"#);
        assert_eq!(File::default().with(only_required).load().unwrap().notes.concat(), note);
    }
    let decoding = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu"];
    for name in decoding.into_iter().chain(["KHR_node_visibility", "KHR_materials_clearcoat2"]) {
        let required = format!(r#""extensionsRequired":["KHR_materials_clearcoat","{name}"]"#);
        let error = File::default().with(required).load().unwrap_err().to_string();
        assert!(
            error.ends_with(&format!("{name} is required but not supported: export the scene without it")),
            "{error}"
        );
    }
}

/// A channel without a target node is ignored (glTF 2.0, section 3.11). One whose node does not exist is an
/// error.
#[test]
fn animation_channels_may_have_no_node() {
    let animated = |targets: &[&str]| {
        let (mut file, positions) = File::with_corners(3);
        let times = file.accessor(r#""componentType":5126,"type":"SCALAR","count":1"#, &0_f32.to_le_bytes());
        let translations = file.floats(&[[0.0_f32, 1.0, 0.0]]);
        let channels: Vec<_> = targets.iter().map(|target| format!(r#"{{"sampler":0,"target":{target}}}"#)).collect();
        file.with(positioned(positions))
            .with(format!(
                r#""animations":[{{"samplers":[{{"input":{times},"output":{translations}}}],"channels":[{}]}}]"#,
                channels.join(",")
            ))
            .load()
    };
    let targetless = r#"{"path":"translation"}"#;
    let pointer = r#"{"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":"/materials/0"}}}"#;
    for targets in [&[targetless][..], &[r#"{"node":0,"path":"translation"}"#, targetless], &[pointer]] {
        let loaded = animated(targets).unwrap();
        assert_eq!(loaded.notes, ["animations are not played, everything is at rest: 1 of them"]);
        assert_eq!(only_primitive(&loaded).positions.len(), 3);
    }
    let broken = animated(&[targetless, r#"{"node":1,"path":"translation"}"#]).unwrap_err().to_string();
    assert!(broken.contains("node 1"), "{broken}");
    assert!(animated(&["7"]).is_err() && animated(&[r#"{"node":0}"#]).is_err());
}

#[test]
fn paths_that_are_no_files_are_refused() {
    for path in ["no/such/file.glb", "/dev/zero", "."] {
        let error = assets::load(Path::new(path)).unwrap_err().to_string();
        assert!(error.starts_with(path), "{error}");
    }
}

#[test]
fn a_loaded_scene_has_the_name_of_the_drawn_scene() {
    let name = |member: &str| File::default().with(member).load().unwrap().name;
    assert_eq!(
        name(r#""scenes":[{"nodes":[],"name":"Kitchen"},{"nodes":[],"name":"Attic"}]"#).as_deref(),
        Some("Kitchen")
    );
    assert_eq!(
        name(r#""scene":1,"scenes":[{"nodes":[],"name":"Kitchen"},{"nodes":[],"name":" Attic "}]"#).as_deref(),
        Some("Attic")
    );
    let long = format!(r#""scenes":[{{"nodes":[],"name":"{}"}}]"#, "x".repeat(light::MAX_NAME_BYTES + 1));
    // No name, a name that documents refuse, and the name that exporters give every scene.
    for nameless in [
        r#""nodes":[]"#,
        r#""scenes":[{"nodes":[]}]"#,
        r#""scenes":[{"nodes":[],"name":" "}]"#,
        r#""scenes":[{"nodes":[],"name":"a\nb"}]"#,
        &long,
    ] {
        assert_eq!(name(nameless), None, "{nameless}");
    }
    assert_eq!(name(r#""scenes":[{"nodes":[],"name":"Scene"}]"#), None);
    let demo = assets::load_bytes(&assets::demo_bytes("arbor").unwrap()).unwrap();
    assert_eq!(demo.name.as_deref(), Some("demo:arbor"));
}
