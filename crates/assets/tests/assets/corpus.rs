//! Tests with real files of many exporters: each loads, or is refused with the unsupported feature named.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assets::AssetFault;
use document::SceneContents;
use serde_json::Value;

/// Returns the scene files in a folder and below it, sorted.
fn scene_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(scene_files(&path));
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            files.push(path);
        }
    }
    files.sort();
    files
}

#[test]
#[ignore = "needs ../shared/assets"]
fn every_file_of_shared_assets_loads_or_names_the_missing_feature() {
    let folder = crate::support::assets_folder();
    let files = [scene_files(&folder.join("gltf")), scene_files(&folder.join("scenes"))].concat();
    let mut refused = Vec::new();
    for path in &files {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        match assets::load(path) {
            Ok(loaded) => {
                let scene = &loaded.scene;
                crate::support::assert_sound(&loaded, &name);
                let triangles = scene::pose(scene.clone(), 0.0).triangle_count();
                let SceneContents { lights, cameras } = &loaded.contents;
                let (lights, cameras, images) = (lights.len(), cameras.len(), scene.images.len());
                println!("{name}: {triangles} triangles, {lights} lights, {cameras} cameras, {images} pictures");
                loaded.notes.iter().for_each(|note| println!("    {note}"));
            }
            Err(error) => {
                println!("{error}");
                let incomplete =
                    matches!(error.fault, AssetFault::Address { .. }) && name.ends_with("assimp-Cameras.gltf");
                assert!(matches!(error.fault, AssetFault::RequiredExtension(_)) || incomplete, "{error}");
                refused.push(path.file_stem().unwrap().to_string_lossy().into_owned());
            }
        }
    }
    // Files that an extension compresses, and the one whose buffer is missing from the collection.
    let compressed = ["DracoSparseMesh", "Horse-draco", "heart_draco", "meshopt-no-fallback"];
    assert_eq!(refused, [&compressed[..], &["assimp-Cameras", "DenseSphere"]].concat());
}

#[test]
#[ignore = "needs ../shared/assets"]
fn counts_are_those_of_the_files_of_shared_assets() {
    let folder = crate::support::assets_folder();
    // Triangles as the collection's LICENSES.md lists them, then the numbers of spotlights and cameras.
    for (file, triangles, lights, cameras) in [
        ("scenes/bench.glb", 106_242, 1, 1),
        ("scenes/usd-shaderball.glb", 63_856, 0, 0),
        ("gltf/compressed/horse_morph-sparse.glb", 2182, 0, 0),
        ("gltf/compressed/horse_morph-quantized.glb", 2182, 0, 0),
        ("gltf/instancing/pc-simple-instancing.glb", 1500, 0, 0),
        ("gltf/khronos/BoxInterleaved.glb", 12, 0, 0),
        ("gltf/khronos/Fox.glb", 576, 0, 0),
    ] {
        let loaded = assets::load(&folder.join(file)).unwrap();
        let posed = scene::pose(loaded.scene.clone(), 0.0).triangle_count();
        assert_eq!(
            (posed, loaded.contents.lights.len(), loaded.contents.cameras.len()),
            (triangles, lights, cameras),
            "{file}"
        );
    }
}

/// Three exports of one mesh: plain, quantized to 16 bits, and with sparse morph targets.
#[test]
#[ignore = "needs ../shared/assets"]
fn quantised_and_sparse_shared_assets_hold_the_plain_ones_shape() {
    let folder = crate::support::assets_folder();
    let bounds = |file: &str| scene::world_bounds(&assets::load(&folder.join(file)).unwrap().scene).unwrap();
    let (min, max) = bounds("scenes/horse_morph.glb");
    for file in ["gltf/compressed/horse_morph-quantized.glb", "gltf/compressed/horse_morph-sparse.glb"] {
        let (found_min, found_max) = bounds(file);
        // Half a step of 2^-15 of the size, and a margin for the fit of the quantization box.
        let tolerance = (max - min).max_element() / f64::from(1 << 13);
        assert!((found_min - min).length() < tolerance && (found_max - max).length() < tolerance, "{file}");
    }
}

/// Every file gives the same scene from its packed bytes, and hostile files are still refused.
#[test]
#[ignore = "needs ../shared/assets"]
fn packed_shared_assets_load_as_the_same_scenes() {
    let folder = crate::support::assets_folder();
    let (mut same, mut inlined) = (0, 0);
    for path in scene_files(&folder) {
        let file = assets::load(&path);
        let Ok(bytes) = assets::pack(&path) else {
            assert!(file.is_err(), "{} loads but cannot be packed", path.display());
            continue;
        };
        match (file, assets::load_bytes(&bytes)) {
            (Ok(file), Ok(packed)) => {
                assert_eq!(
                    format!("{:?}", (&file.scene, &file.contents)),
                    format!("{:?}", (&packed.scene, &packed.contents)),
                    "{}",
                    path.display()
                );
                let images = file.scene.images.iter().zip(&packed.scene.images);
                assert!(images.into_iter().all(|(a, b)| a.rgba8 == b.rgba8), "{}", path.display());
                assert_eq!(file.notes, packed.notes);
                same += 1;
            }
            (Err(_), Err(_)) => {}
            (file, packed) => panic!("{}: {:?} {:?}", path.display(), file.err(), packed.err()),
        }
        inlined += usize::from(bytes != std::fs::read(&path).unwrap());
    }
    println!("{same} scenes the same, {inlined} files made of several");
    assert!(same > 30 && inlined > 5, "{same} {inlined}");
}

/// Counts the lights on the nodes of the drawn scene from the file's JSON alone.
fn punctual_lights(file: &[u8]) -> usize {
    // In a binary file the JSON follows 12 bytes of header and the head of its chunk, which has its length.
    let json = match file.strip_prefix(b"glTF") {
        Some(binary) => {
            let length = u32::from_le_bytes(binary[8..12].try_into().expect("four bytes")) as usize;
            &binary[16..16 + length]
        }
        None => file,
    };
    let has_light = |node: &Value| node["extensions"]["KHR_lights_punctual"]["light"].is_u64();
    let root: Value = serde_json::from_slice(json).expect("JSON");
    let node = |index: &Value| &root["nodes"][index.as_u64().expect("an index") as usize];
    let drawn = root["scene"].as_u64().unwrap_or(0) as usize;
    // Without a scene all nodes are drawn.
    let Some(roots) = root["scenes"][drawn]["nodes"].as_array() else {
        return root["nodes"].as_array().into_iter().flatten().filter(|node| has_light(node)).count();
    };
    let mut waiting: Vec<&Value> = roots.iter().map(node).collect();
    let mut count = 0;
    while let Some(at) = waiting.pop() {
        count += usize::from(has_light(at));
        waiting.extend(at["children"].as_array().into_iter().flatten().map(node));
    }
    count
}

/// Returns the number of lights that notes report as left out. A note names the first.
fn left_out(notes: &[String]) -> usize {
    let note = notes.iter().find(|note| note.contains("lights that stand infinitely far away"));
    let others = |note: &String| note.rsplit_once(" and ")?.1.strip_suffix(" more")?.parse::<usize>().ok();
    note.map_or(0, |note| 1 + others(note).unwrap_or(0))
}

/// Every light of every file is imported, or a note says that it is left out. Every file with visible geometry
/// has a light.
#[test]
#[ignore = "needs ../shared/assets"]
fn no_light_of_shared_assets_is_dropped() {
    let folder = crate::support::assets_folder();
    let mut files_by_lights: BTreeMap<usize, usize> = BTreeMap::new();
    for path in scene_files(&folder) {
        let Ok(loaded) = assets::load(&path) else { continue };
        let name = path.display();
        let count = punctual_lights(&std::fs::read(&path).expect("it has just been read"));
        let read = loaded.contents.lights.len();
        assert_eq!(read + left_out(&loaded.notes), count, "{name}");
        let triangles = scene::pose(loaded.scene.clone(), 0.0).triangle_count();
        let lit = loaded.with_default_light();
        let is_key = |note: &String| note.ends_with("default key");
        let gets_key = read == 0 && triangles > 0;
        assert_eq!(lit.contents.lights.len(), read + usize::from(gets_key), "{name}");
        assert_eq!(lit.notes.iter().any(is_key), gets_key, "{name}: {:?}", lit.notes);
        *files_by_lights.entry(count).or_default() += 1;
    }
    println!("files by how many lights they have: {files_by_lights:?}");
    assert!(files_by_lights[&0] > 30 && files_by_lights.len() > 1, "{files_by_lights:?}");
}
