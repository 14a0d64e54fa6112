//! Tests of packing a scene of several files, and of loading from bytes.

use std::path::Path;

use assets::{AssetFault, LoadedScene};

/// Returns a whole scene as text, including the texels of its images.
fn all_of(loaded: &LoadedScene) -> String {
    let LoadedScene { scene, contents, .. } = loaded;
    let pixels: Vec<_> = scene.images.iter().map(|image| &image.rgba8).collect();
    format!("{scene:?} {contents:?} {pixels:?}")
}

/// Packs a glTF file whose buffer and image are files of their own, after `change` has edited its JSON. Also returns
/// the loaded scene as text, empty if `load` refuses it.
fn packed(change: impl Fn(String) -> String) -> (Result<Vec<u8>, assets::AssetError>, String) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    write("a b.bin", &corners.map(f32::to_le_bytes).concat());
    let mut picture = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_pixel(2, 1, image::Rgb([9, 8, 7]));
    pixels.write_to(&mut picture, image::ImageFormat::Png).unwrap();
    write("skin.png", picture.get_ref());
    let json = r#"{
        "asset": {"version": "2.0", "copyright": "a \"quoted\" name"},
        "buffers": [{"byteLength": 36, "uri": "a%20b.bin"}],
        "images": [{"uri": "skin.png", "name": "skin"}, {"uri": "skin.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.1}}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [{"mesh": 0, "translation": [0.1, 0.2, 1e-7]}],
        "scenes": [{"nodes": [0]}], "scene": 0
    }"#;
    let json = change(json.into());
    write("scene.gltf", json.as_bytes());
    let file = folder.path().join("scene.gltf");
    let loaded = assets::load(&file).map_or(String::new(), |loaded| all_of(&loaded));
    (assets::pack(&file), loaded)
}

#[test]
fn several_files_become_one() {
    let (bytes, loaded) = packed(|json| json);
    let bytes = bytes.unwrap();
    let again = assets::load_bytes(&bytes).unwrap();
    assert_eq!(all_of(&again), loaded);
    assert_eq!(again.scene.images[0].rgba8, [9, 8, 7, 255, 9, 8, 7, 255]);
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains("data:image/png;base64,") && !text.contains("skin.png"), "{text}");
    // Packing is deterministic, and packing a packed file changes nothing.
    assert_eq!(packed(|json| json).0.unwrap(), bytes);
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), &bytes).unwrap();
    assert_eq!(assets::pack(file.path()).unwrap(), bytes);
    // Deliberate fault that the check must detect: another position shows in the text.
    assert_ne!(packed(|json| json.replace("0.1, 0.2", "0.1, 0.3")).1, loaded);
}

/// `pack` refuses files that `load` refuses. It also refuses a file that names a missing image, even if no texture uses
/// that image and `load` never reads it.
#[test]
fn files_that_cannot_be_packed_are_refused() {
    for address in ["../a%20b.bin", "/etc/hostname", "http://example.org/a.bin", "none.bin", ""] {
        let fault = packed(|json| json.replace("a%20b.bin", address)).0.unwrap_err().fault;
        assert!(matches!(fault, AssetFault::Address { .. }), "{address}: {fault}");
    }
    let unused = packed(|json| json.replace(r#"{"uri": "skin.png"}"#, r#"{"uri": "none.png"}"#));
    assert!(!unused.1.is_empty(), "it can be loaded");
    assert!(matches!(unused.0.unwrap_err().fault, AssetFault::Address { .. }));
    let broken = packed(|json| json.replace("[0]}]", "[7]}]")).0.unwrap_err().fault;
    assert!(matches!(broken, AssetFault::InvalidGltf(_)), "{broken}");
    assert!(matches!(assets::pack(Path::new(".")).unwrap_err().fault, AssetFault::NotAFile));
}

#[test]
fn bytes_refer_to_no_file() {
    let text = String::from_utf8(packed(|json| json).0.unwrap()).unwrap();
    let start = text.find("data:image").unwrap();
    let end = start + text[start..].find('"').unwrap();
    for address in ["skin.png", "/etc/hostname", "../skin.png", "Cargo.toml"] {
        let error = assets::load_bytes(format!("{}{address}{}", &text[..start], &text[end..]).as_bytes()).unwrap_err();
        assert!(matches!(error.fault, AssetFault::Address { .. }), "{error}");
        assert!(error.to_string().starts_with("the scene: refers to"), "{error}");
    }
    for bytes in [&b""[..], b"{", b"glTF", &[0xff; 64]] {
        assert!(assets::load_bytes(bytes).is_err());
    }
}

#[test]
fn a_demo_is_named_by_a_line() {
    for (name, _) in assets::DEMO_NAMES {
        let bytes = assets::demo_bytes(name).unwrap();
        let loaded = assets::load_bytes(&bytes).unwrap();
        assert_eq!(all_of(&loaded), all_of(&assets::demo(name).unwrap()));
    }
    assert_eq!(assets::demo_bytes("vases").unwrap(), b"bendylights demo vases 1\n");
    assert!(assets::demo_bytes("no such scene").is_none());
    for line in ["bendylights demo vases 0\n", "bendylights demo vases 1", "bendylights demo cups 1\n"] {
        let error = assets::load_bytes(line.as_bytes()).unwrap_err();
        assert!(matches!(error.fault, AssetFault::UnknownDemo(_)), "{error}");
        assert!(!error.to_string().contains('\n'));
    }
}
