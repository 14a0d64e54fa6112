//! Pins of a drag, of points and of nodes.

use std::ops::Range;

use glam::{DVec2, DVec3};
use scene::{PosedScene, pixel_of};

use crate::occlusion::{Occlusion, seen_at};
use crate::picture_metric::low_discrepancy;
use crate::pin_state::PinState;
use crate::point_in_light::SceneLight;
use crate::request::{DragRefusal, NumberedPin, PinTarget, Viewport};

/// Softness of soft pins: an error of 0.1 (radii or radians) weighs as much as a change of three lengths of the light.
/// The second number is that of a hard pin of a node, whose points can hardly all hold exactly.
const SOFT_PIN_COMPLIANCE: f64 = 1e-3;
const NODE_PIN_COMPLIANCE: f64 = 3e-4;

/// Number of pixels that are tried for points of a pinned node, and most points.
const NODE_CANDIDATES: u32 = 256;
const POINTS_OF_NODE: usize = 48;

/// Number of points of a node's surface that are tried without a picture. Most of a large node may lie outside the light.
const SURFACE_CANDIDATES: u32 = 2048;

/// Pins of a drag, as states of points. A pin of a node has one for each of its points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pins {
    pub states: Vec<PinState>,
    /// Pins of nodes that the drag must preserve.
    pub nodes: Vec<NodePin>,
}

/// Hard pin of a node.
#[derive(Clone, Debug)]
pub(crate) struct NodePin {
    pub number: u64,
    /// Indices of its states.
    pub states: Range<usize>,
}

impl Pins {
    /// Makes the states of the pins that hold at the start of the drag. Returns an error for a hard one that does not.
    pub fn new(
        occlusion: &Occlusion,
        view: &Viewport,
        placed: &SceneLight,
        pins: &[NumberedPin],
    ) -> Result<Self, DragRefusal> {
        let mut made = Self::default();
        for pin in pins {
            let is_held = made.add(occlusion, placed, pin, |node| points_of_node(occlusion, view, node));
            if !is_held && pin.pin.is_hard {
                return Err(DragRefusal::PinDoesNotHold(pin.number));
            }
        }
        Ok(made)
    }

    /// Makes the states of the pins that hold, without a picture.
    pub fn without_picture<'p>(
        occlusion: &Occlusion,
        placed: &SceneLight,
        pins: impl IntoIterator<Item = &'p NumberedPin>,
    ) -> Self {
        let mut made = Self::default();
        for pin in pins {
            made.add(occlusion, placed, pin, |node| points_on_node(occlusion, placed, node));
        }
        made
    }

    /// Adds the states of a pin, on the `points` of a node if it is pinned. Returns false if the pin does not hold.
    fn add(
        &mut self,
        occlusion: &Occlusion,
        placed: &SceneLight,
        pin: &NumberedPin,
        points: impl FnOnce(usize) -> Vec<DVec3>,
    ) -> bool {
        let begin = self.states.len();
        match &pin.pin.at {
            PinTarget::Point(at) => {
                let compliance = if pin.pin.is_hard { 0.0 } else { SOFT_PIN_COMPLIANCE };
                let point = at - placed.origin_in_world;
                self.states.extend(PinState::if_held(occlusion, placed, pin, point, compliance));
            }
            PinTarget::Node(node) => {
                let points = node_named(&occlusion.bvh.posed, node).map_or_else(Vec::new, points);
                let compliance = if pin.pin.is_hard { NODE_PIN_COMPLIANCE } else { SOFT_PIN_COMPLIANCE };
                let compliance = compliance * points.len() as f64;
                let held =
                    points.iter().filter_map(|point| PinState::if_held(occlusion, placed, pin, *point, compliance));
                self.states.extend(held);
            }
        }
        let states = begin..self.states.len();
        if states.is_empty() {
            return false;
        }
        if pin.pin.is_hard && matches!(pin.pin.at, PinTarget::Node(_)) {
            self.nodes.push(NodePin { number: pin.number, states });
        }
        true
    }

    /// Copies the hard pins.
    pub fn hard(&self) -> Self {
        let mut hard = Self::default();
        for (index, state) in self.states.iter().enumerate() {
            let node = self.nodes.iter().find(|node| node.states.contains(&index));
            if !state.is_hard() && node.is_none() {
                continue;
            }
            if let Some(node) = node {
                match hard.nodes.last_mut().filter(|last| last.number == node.number) {
                    Some(last) => last.states.end += 1,
                    None => hard
                        .nodes
                        .push(NodePin { number: node.number, states: hard.states.len()..hard.states.len() + 1 }),
                }
            }
            hard.states.push(state.clone());
        }
        hard
    }
}

/// Finds points of a node and of those below it that the picture shows, evenly spread over the picture. If it shows none,
/// finds points anywhere on their surfaces.
pub(crate) fn points_of_node(occlusion: &Occlusion, view: &Viewport, node: usize) -> Vec<DVec3> {
    let (bvh, posed) = (occlusion.bvh, &occlusion.bvh.posed);
    let Some(is_of_node) = nodes_under(occlusion, node) else { return Vec::new() };
    let origin = posed.origin_in_world;
    let triangles: Vec<_> = bvh.triangles().filter(|triangle| is_of_node[triangle.node]).collect();
    let corners = triangles.iter().flat_map(|triangle| triangle.corners);
    let size = DVec2::from(view.size.map(f64::from));
    let (mut least, mut most) = (size, DVec2::ZERO);
    for pixel in corners.filter_map(|corner| pixel_of(&view.camera, view.size, corner, origin)) {
        least = least.min(pixel.max(DVec2::ZERO));
        most = most.max(pixel.min(size));
    }
    let pixels = (0..NODE_CANDIDATES).map(|number| least + low_discrepancy(number) * (most - least));
    let seen = pixels.filter_map(|pixel| seen_at(bvh, view, pixel, occlusion.work));
    let in_picture = seen.filter(|seen| is_of_node[seen.node]).map(|seen| seen.position);
    let points: Vec<DVec3> = in_picture.take(POINTS_OF_NODE).collect();
    if !points.is_empty() {
        return points;
    }
    let apart = triangles.len().div_ceil(POINTS_OF_NODE).max(1);
    triangles.iter().step_by(apart).map(|triangle| triangle.corners.iter().sum::<DVec3>() / 3.0).collect()
}

/// Finds points on the surfaces of a node and of those below it that lie in the light, in proportion to area.
fn points_on_node(occlusion: &Occlusion, light: &SceneLight, node: usize) -> Vec<DVec3> {
    let Some(is_of_node) = nodes_under(occlusion, node) else { return Vec::new() };
    let triangles: Vec<_> = occlusion.bvh.triangles().filter(|triangle| is_of_node[triangle.node]).collect();
    let mut area = 0.0;
    // Area of the triangles up to and including each.
    let areas: Vec<f64> = triangles
        .iter()
        .map(|triangle| {
            area += 0.5 * triangle.normal().length();
            area
        })
        .collect();
    // A point, and true if its side faces the light.
    let point_at = |number: u32| {
        let at = low_discrepancy(number);
        let index = areas.partition_point(|up_to| *up_to <= at.x * area);
        let triangle = triangles.get(index)?;
        let before = index.checked_sub(1).map_or(0.0, |before| areas[before]);
        // Uniform in the triangle, from two numbers that are uniform in 0 to 1.
        let root = ((at.x * area - before) / (areas[index] - before)).clamp(0.0, 1.0).sqrt();
        let point = triangle.position_at(DVec3::new(1.0 - root, root * (1.0 - at.y), root * at.y));
        let coords = light.locate(point, None).filter(|coords| light.contains(coords))?;
        Some((point, triangle.normal().dot(coords.to_light) > 0.0))
    };
    let (towards, away): (Vec<_>, Vec<_>) =
        (0..SURFACE_CANDIDATES).filter_map(point_at).partition(|(_, faces_light)| *faces_light);
    // The side that is turned away stays dark whatever happens, and would hide that the other changes.
    let chosen = if towards.is_empty() { away } else { towards };
    chosen.into_iter().map(|(point, _)| point).take(POINTS_OF_NODE).collect()
}

/// Returns for each node if it is `node` or below it. `None` if the budget is spent.
pub(crate) fn nodes_under(occlusion: &Occlusion, node: usize) -> Option<Vec<bool>> {
    let nodes = &occlusion.bvh.posed.scene.nodes;
    let parents = |index: usize| std::iter::successors(Some(index), |index| nodes[*index].parent);
    let is_under = |index: usize| parents(index).any(|parent| parent == node);
    occlusion.work.spend(occlusion.bvh.triangle_count() as u64).then(|| (0..nodes.len()).map(is_under).collect())
}

/// Returns the first node with a name or path.
pub(crate) fn node_named(posed: &PosedScene, node: &str) -> Option<usize> {
    let (tree, nodes) = (posed.node_tree(), &posed.scene.nodes);
    (0..nodes.len()).find(|index| nodes[*index].name == *node || tree.path(*index) == *node)
}
