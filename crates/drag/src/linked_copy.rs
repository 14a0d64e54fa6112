//! Split of a light into a dragged part and a copy that stays, by the nodes that each illuminates.

use glam::DVec3;
use light::parameters::{LIGHT_LINK, NAME};
use light::{CheckedLight, Light, Links, MAX_NAME_BYTES};

use crate::occlusion::{Occlusion, seen_at};
use crate::pin_state::CONTACT;
use crate::pins::node_named;
use crate::request::{Drag, Feature, LightCopy, NumberedPin, PinTarget};

/// Light as two that illuminate the scene as the one does.
pub(crate) struct SplitLight {
    /// Part to drag.
    pub dragged: CheckedLight,
    /// Pins that hold on what `dragged` illuminates.
    pub pins: Vec<NumberedPin>,
    /// Part that stays as it was.
    pub copy: LightCopy,
}

/// Splits a light for a drag. The copy illuminates the caster of a dragged shadow alone, or all but the surface on which
/// another feature is dragged. `None` if there is no such node, or if the light illuminates it alone.
pub(crate) fn split_light(
    occlusion: &Occlusion,
    light: &CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
) -> Option<SplitLight> {
    let node = split_node(occlusion, light, drag)?;
    let posed = &occlusion.bvh.posed;
    let path = posed.node_tree().path(node);
    let name = posed.scene.nodes[node].name.clone();
    let (alone, without) = parts(light.light(), &path, &name)?;
    let (dragged, copy) = if drag.feature == Feature::Shadow { (without, alone) } else { (alone, without) };
    let dragged = CheckedLight::new(dragged).ok()?;
    let of_dragged = Occlusion::new(occlusion.bvh, &dragged, occlusion.work);
    let (pins, others): (Vec<_>, Vec<_>) = pins
        .iter()
        .cloned()
        .partition(|pin| node_of_pin(occlusion, &pin.pin.at).is_none_or(|node| of_dragged.is_node_lit(node)));
    let copy = LightCopy { light: copy, pins: others.iter().map(|pin| pin.number).collect() };
    Some(SplitLight { dragged, pins, copy })
}

/// Returns the node that one part illuminates alone.
fn split_node(occlusion: &Occlusion, light: &CheckedLight, drag: &Drag) -> Option<usize> {
    let from = seen_at(occlusion.bvh, &drag.view, drag.from, occlusion.work)?;
    if drag.feature != Feature::Shadow {
        return Some(from.node);
    }
    let caster = occlusion.caster_of(light, &from)?;
    (caster != from.node && occlusion.is_node_lit(caster)).then_some(caster)
}

/// Makes the parts of a light that illuminate a node alone, and all else. `None` if all else is nothing.
fn parts(light: &Light, path: &str, node_name: &str) -> Option<(Light, Light)> {
    let links = light.get(LIGHT_LINK);
    let (include, exclude) =
        links.map_or_else(Default::default, |links| (links.include().to_vec(), links.exclude().to_vec()));
    let is_below =
        |other: &String| other.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    let (below, other_include): (Vec<_>, Vec<_>) = include.into_iter().partition(is_below);
    if other_include.is_empty() && !below.is_empty() {
        return None;
    }
    let alone = Links::new(vec![path.to_owned()], exclude.clone());
    let without = Links::new(other_include, [exclude, vec![path.to_owned()]].concat());
    let name = copy_name(&light.get(NAME), node_name);
    Some((light.clone().with(LIGHT_LINK, alone).with(NAME, name), light.clone().with(LIGHT_LINK, without)))
}

/// Names a copy after the light and its node, within the longest name.
fn copy_name(light: &str, node: &str) -> String {
    let mut name = format!("{light} on {node}").trim().to_owned();
    while name.len() > MAX_NAME_BYTES {
        name.pop();
    }
    name
}

/// Returns the node on which a pin holds.
fn node_of_pin(occlusion: &Occlusion, at: &PinTarget) -> Option<usize> {
    let (bvh, posed) = (occlusion.bvh, &occlusion.bvh.posed);
    match at {
        PinTarget::Point(at) => {
            let point: DVec3 = at - posed.origin_in_world;
            let within = CONTACT * posed.half_extent.length();
            let spend = |boxes| occlusion.work.spend_on_rays(boxes);
            bvh.nearest_budgeted(point, within, spend, |_| true).map(|near| bvh.triangle(near.triangle).node)
        }
        PinTarget::Node(name) => node_named(posed, name),
    }
}
