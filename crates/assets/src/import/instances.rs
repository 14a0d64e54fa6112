//! `EXT_mesh_gpu_instancing`: instances of one node's mesh.

use glam::DAffine3;
use gltf::json::Node;

use super::accessors::IntegerConversion;
use super::placement::compose;
use super::{ImportReport, ImportSource};
use crate::fault::invalid_gltf;
use crate::{AssetFault, ImportLimit};

/// Returns the transform of each instance in the node's space, or `None` if the node has no instances.
pub fn read(
    source: &ImportSource,
    node: &Node,
    report: &mut ImportReport,
) -> Result<Option<Vec<DAffine3>>, AssetFault> {
    let extension = node.extensions.as_ref().and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
    let Some(attributes) = extension.and_then(|e| e.get("attributes")?.as_object()) else { return Ok(None) };
    let accessor = |name: &str| {
        let Some(index) = attributes.get(name) else { return Ok(None) };
        let found = index.as_u64().and_then(|i| source.root.accessors.get(usize::try_from(i).ok()?));
        found.map(Some).ok_or_else(|| invalid_gltf(format!("instances use accessor {index}, which does not exist")))
    };
    let (translation, rotation, scale) = (accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?);
    let mut counts = [translation, rotation, scale].into_iter().flatten().map(|a| a.count.0);
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        return Err(invalid_gltf("the attributes of its instances differ in length"));
    }
    report.budget.spend(ImportLimit::Nodes, count)?;

    let all = |value| vec![value; count as usize];
    let translations =
        translation.map_or_else(|| Ok(all([0.0; 3])), |a| source.floats(a, IntegerConversion::AsDeclared))?;
    let scales = scale.map_or_else(|| Ok(all([1.0; 3])), |a| source.floats(a, IntegerConversion::AsDeclared))?;
    let no_rotations = || Ok(vec![[0.0, 0.0, 0.0, 1.0]; count as usize]);
    let rotations = rotation.map_or_else(no_rotations, |a| source.floats(a, IntegerConversion::Normalized))?;
    let parts = translations.into_iter().zip(rotations).zip(scales);
    Ok(Some(parts.map(|((translation, rotation), scale)| compose(translation, rotation, scale)).collect()))
}
