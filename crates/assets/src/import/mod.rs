//! Import of glTF 2.0 in one direction: bytes, JSON, checks, then each kind of object once.
//!
//! The `gltf` crate supplies the types of the JSON and resolves indices. Its importer and its iterators are not
//! used: they fetch any address, allocate memory before they check, and panic on some broken files.

mod accessors;
mod addresses;
mod cameras;
mod check;
mod container;
mod images;
mod instances;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod pack;
mod placement;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use document::SceneContents;
use glam::DAffine3;
use gltf::json::Root;
pub use pack::pack;
use scene::Scene;

use crate::limits::{Budget, MAX_COORDINATE, MAX_NAME_CHARS};
use crate::notes::Notes;
use crate::{AssetFault, ImportLimit, LoadedScene};

/// Input of all readers: the checked document and its bytes.
struct ImportSource<'a> {
    /// Document that has passed [`check::check_document`].
    root: &'a Root,
    /// Path of the scene file, beside which the other files lie; `None` if there are no others.
    file: Option<&'a Path>,
    /// Bytes of each glTF buffer, at least as long as its declared length.
    buffers: Vec<Cow<'a, [u8]>>,
}

/// Used budget and notes of one load.
#[derive(Default)]
struct ImportReport {
    budget: Budget,
    notes: Notes,
}

/// Reads the scene file at `path` and the files that it refers to.
pub fn import_file(path: &Path) -> Result<LoadedScene, AssetFault> {
    let mut report = ImportReport::default();
    let bytes = addresses::read_file(path, &mut report.budget)?;
    import(&bytes, Some(path), report)
}

/// Reads a scene file that refers to no others.
pub fn import_bytes(bytes: &[u8]) -> Result<LoadedScene, AssetFault> {
    let mut report = ImportReport::default();
    report.budget.spend(ImportLimit::BytesRead, bytes.len() as u64)?;
    import(bytes, None, report)
}

fn import(bytes: &[u8], file: Option<&Path>, mut report: ImportReport) -> Result<LoadedScene, AssetFault> {
    let container = container::split(bytes)?;
    let root = check::check_document(container::parse(container.json)?, &mut report.notes)?;
    let buffers = addresses::buffers(&root, container.bin, file, &mut report.budget)?;
    let (scene, contents) = build(&ImportSource { root: &root, file, buffers }, &mut report)?;
    scene.check()?;
    Ok(LoadedScene { scene, contents, name: name(&root), notes: report.notes.into_sentences() })
}

/// Returns the name of the drawn scene, or `None` if it is too long, has control characters, or is the "Scene"
/// of every export.
fn name(root: &Root) -> Option<String> {
    let drawn = root.scenes.get(root.scene.map_or(0, |scene| scene.value()))?;
    let name = drawn.name.as_deref()?.trim();
    let fits = (1..=light::MAX_NAME_BYTES).contains(&name.len()) && !name.contains(char::is_control);
    let says_something = !name.eq_ignore_ascii_case("scene");
    (fits && says_something).then(|| name.to_owned())
}

fn build(source: &ImportSource, report: &mut ImportReport) -> Result<(Scene, SceneContents), AssetFault> {
    let mut scene = Scene::default();
    let placed = nodes::place_nodes(source, report)?;
    let (images, materials) = materials::read(source, report)?;
    let cameras = cameras::read(source, &placed, &mut report.notes);
    let lights = lights::read(source, &placed, &mut report.notes);

    let mut scene_mesh: BTreeMap<usize, usize> = BTreeMap::new();
    for node in &placed {
        if let Some(mesh) = node.mesh
            && !scene_mesh.contains_key(&mesh)
        {
            scene_mesh.insert(mesh, scene.meshes.len());
            scene.meshes.push(meshes::read(source, mesh, &materials, report)?);
        }
        scene.nodes.push(scene::Node {
            name: node.name.clone(),
            parent: node.parent,
            parent_from_local: node.parent_from_local,
            mesh: node.mesh.map(|m| scene_mesh[&m]),
        });
    }
    scene.materials = materials.into_iter().map(|m| m.material).collect();
    scene.images = images;
    check_extent(&scene, placed.iter().map(|p| p.world_from_local))?;
    Ok((scene, SceneContents { lights, cameras }))
}

/// Checks the number of placed triangles and every world coordinate. The coordinates are bounded by each mesh's
/// largest one.
fn check_extent(scene: &Scene, world_from_node: impl Iterator<Item = DAffine3>) -> Result<(), AssetFault> {
    let extents: Vec<f64> = scene.meshes.iter().map(largest_coordinate).collect();
    let triangles = |mesh: usize| scene.meshes[mesh].primitives.iter().map(|p| p.indices.len() as u64 / 3).sum();
    let mut budget = Budget::default();
    for (node, world_from_local) in scene.nodes.iter().zip(world_from_node) {
        let axes = world_from_local.matrix3;
        let extent = node.mesh.map_or(0.0, |m| extents[m]);
        let reach =
            (axes.x_axis.abs() + axes.y_axis.abs() + axes.z_axis.abs()) * extent + world_from_local.translation.abs();
        // This form also refuses NaN, which an overflow along the hierarchy can give.
        let inside = reach.max_element() <= MAX_COORDINATE as f64 && world_from_local.is_finite();
        if !inside {
            let found = (reach.max_element() as u64).max(MAX_COORDINATE + 1);
            return Err(AssetFault::Limit { limit: ImportLimit::Coordinate, found });
        }
        budget.spend(ImportLimit::Triangles, node.mesh.map_or(0, triangles))?;
    }
    Ok(())
}

fn largest_coordinate(mesh: &scene::Mesh) -> f64 {
    let positions = mesh.primitives.iter().flat_map(|p| &p.positions);
    positions.fold(0.0, |most, v| most.max(f64::from(v.abs().max_element())))
}

/// Returns the name to show for an object: its own, shortened, or its kind and index.
fn display_name(name: Option<&str>, kind: &str, index: usize) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            let mut name = crate::fault::excerpt(name, MAX_NAME_CHARS);
            name.truncate(name.floor_char_boundary(light::MAX_NAME_BYTES));
            name
        }
        _ => format!("{kind} {index}"),
    }
}
