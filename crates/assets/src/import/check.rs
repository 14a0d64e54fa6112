//! First check of a glTF document, before any of it is used: versions, extensions, indices, the node tree, and
//! the position of every accessor in its buffer.

use std::collections::BTreeSet;

use gltf::json::validation::{Error, Validate};
use gltf::json::{Path, Root};

use super::accessors;
use crate::AssetFault;
use crate::fault::{excerpt, invalid_gltf};
use crate::limits::MAX_MESSAGE_CHARS;
use crate::notes::Notes;

/// Extensions that are drawn as specified, or by a fallback that their specification allows.
const SUPPORTED: [&str; 6] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions that change only appearance, or only animation, which is not played. A file may require them and
/// is drawn without them. Any other required extension changes the geometry, or the way to read it.
const IGNORABLE: [&str; 16] = [
    "KHR_animation_pointer",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Checks the whole document, including unused parts.
pub fn check_document(mut root: Root, notes: &mut Notes) -> Result<Root, AssetFault> {
    version(&root)?;
    extensions(&root, notes)?;
    // The bounds are never used, and the validation below would copy them for every primitive that shares the
    // accessor.
    for accessor in &mut root.accessors {
        (accessor.min, accessor.max) = (None, None);
    }
    indices(&root)?;
    node_tree(&root)?;
    accessors::check(&root)?;
    note_rest_pose(&root, notes);
    Ok(root)
}

fn version(root: &Root) -> Result<(), AssetFault> {
    let is_2 = |version: &str| version.split('.').next() == Some("2");
    let minimum = root.asset.min_version.as_deref().unwrap_or("2.0");
    if is_2(&root.asset.version) && minimum == "2.0" {
        return Ok(());
    }
    let needed = if is_2(&root.asset.version) { minimum } else { &root.asset.version };
    Err(invalid_gltf(format!("it is for glTF {}", excerpt(needed, MAX_MESSAGE_CHARS))))
}

fn extensions(root: &Root, notes: &mut Notes) -> Result<(), AssetFault> {
    let supported = |name: &&String| SUPPORTED.contains(&name.as_str());
    let ignorable = |name: &String| IGNORABLE.contains(&name.as_str());
    let mut needed = root.extensions_required.iter().filter(|name| !supported(name));
    if let Some(name) = needed.find(|name| !ignorable(name)) {
        return Err(AssetFault::RequiredExtension(excerpt(name, MAX_MESSAGE_CHARS)));
    }
    // Required extensions should be listed as used too, but some files omit them there.
    let named: BTreeSet<_> = root.extensions_used.iter().chain(&root.extensions_required).collect();
    for name in named.into_iter().filter(|name| !supported(name)) {
        notes.add("extensions that are not drawn", excerpt(name, MAX_MESSAGE_CHARS));
    }
    Ok(())
}

/// Checks that every index exists and every enumeration is known: the `gltf` crate's validation, and the checks
/// that it lacks.
fn indices(root: &Root) -> Result<(), AssetFault> {
    // The validation does not check this index before it uses it, and would panic.
    let mut attributes = root.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(index) = attributes.find(|a| a.value() >= root.accessors.len()) {
        return Err(invalid_gltf(format!("a mesh uses accessor {}, which does not exist", index.value())));
    }
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        if first.is_none() && error != Error::Unsupported && !(error == Error::Missing && is_optional(&path())) {
            first =
                Some(invalid_gltf(format!("{} at {}", describe(error), excerpt(path().as_str(), MAX_MESSAGE_CHARS))));
        }
    });
    if let Some(fault) = first {
        return Err(fault);
    }
    let mut targets = root.animations.iter().flat_map(|a| &a.channels).map(|c| c.target.node.value());
    if let Some(node) = targets.find(|&node| node >= root.nodes.len()) {
        return Err(invalid_gltf(format!("an animation moves node {node}, which does not exist")));
    }
    match root.skins.iter().position(|skin| skin.joints.is_empty()) {
        Some(skin) => Err(invalid_gltf(format!("skin {skin} has no joints"))),
        None => Ok(()),
    }
}

/// Returns true for fields that may be missing: bounds are not used, an accessor without a view is all zeros,
/// and a primitive without positions draws nothing.
fn is_optional(path: &Path) -> bool {
    [".min", ".max", ".bufferView", "[\"POSITION\"]"].iter().any(|end| path.as_str().ends_with(end))
}

fn describe(error: Error) -> &'static str {
    match error {
        Error::IndexOutOfBounds => "something that does not exist is named",
        Error::Missing => "something is missing",
        Error::Oversize => "a size is too large",
        Error::Invalid | Error::Unsupported => "a value is not allowed",
    }
}

/// Checks that every node has at most one parent and that a scene's roots have none, so that every scene is a
/// forest.
fn node_tree(root: &Root) -> Result<(), AssetFault> {
    let mut has_parent = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if std::mem::replace(&mut has_parent[child.value()], true) {
            return Err(invalid_gltf(format!("node {} has two parents", child.value())));
        }
    }
    let mut listed_in = vec![None; root.nodes.len()];
    for (index, scene) in root.scenes.iter().enumerate() {
        for node in scene.nodes.iter().map(gltf::json::Index::value) {
            if has_parent[node] || listed_in[node].replace(index) == Some(index) {
                return Err(invalid_gltf(format!("node {node} is not a root, or is listed twice")));
            }
        }
    }
    Ok(())
}

fn note_rest_pose(root: &Root, notes: &mut Notes) {
    if !root.animations.is_empty() {
        notes.add("animations are not played, everything is at rest", format!("{} of them", root.animations.len()));
    }
    for (index, mesh) in root.meshes.iter().enumerate() {
        if mesh.primitives.iter().any(|p| p.targets.as_ref().is_some_and(|t| !t.is_empty())) {
            notes.add("morph targets are not applied", super::display_name(mesh.name.as_deref(), "mesh", index));
        }
    }
    for (index, skin) in root.skins.iter().enumerate() {
        notes.add("skins are not posed", super::display_name(skin.name.as_deref(), "skin", index));
    }
}
