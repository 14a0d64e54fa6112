//! Start of a drag: the picked surfaces, the light coordinates of the feature, and the unknowns.

use light::{CheckedLight, LightRays};
use raycast::SeenPoint;

use crate::moves::Unknowns;
use crate::occlusion::{Occlusion, ShadowCaster};
use crate::overlap::OverlapRule;
use crate::pins::Pins;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{Drag, DragRefusal, Feature, NumberedPin};
use crate::taken_feature::TakenFeature;

/// Start of a drag, the same for all its ends.
pub(crate) struct DragStart<'a> {
    pub placed: SceneLight<'a>,
    pub from: SeenPoint,
    /// Light coordinates of `from`.
    pub coords: PointInLight,
    /// First caster before `from`, for a dragged shadow.
    pub caster: Option<ShadowCaster>,
    pub pins: Pins,
    pub unknowns: Unknowns,
    pub overlap: OverlapRule,
}

impl<'a> DragStart<'a> {
    /// Finds the start of a drag between the surfaces of `picked`, or returns the reason to refuse the drag.
    pub fn new(
        occlusion: &Occlusion<'a>,
        light: &'a CheckedLight,
        drag: &Drag,
        pins: &[NumberedPin],
        picked: &[Option<SeenPoint>; 2],
    ) -> Result<Self, DragRefusal> {
        if drag.points.is_some() && light.tube().is_none() {
            return Err(DragRefusal::NotBendy);
        }
        let [from, to] = *picked;
        let from = from.ok_or(DragRefusal::NothingAtStart)?;
        let to = to.ok_or(DragRefusal::NothingAtEnd)?;
        let placed = SceneLight::new(light.rays(), occlusion.bvh.posed.origin_in_world, from.position, occlusion.work);
        let coords = placed.locate(from.position, None).ok_or(DragRefusal::OutsideTheLight)?;
        if !placed.contains(&coords) || !occlusion.is_node_lit(from.node) {
            return Err(DragRefusal::OutsideTheLight);
        }
        if !occlusion.is_node_lit(to.node) {
            return Err(DragRefusal::NothingAtEnd);
        }
        let caster = match drag.feature {
            Feature::Shadow => Some(occlusion.first_caster(&placed, &coords, &from).ok_or(DragRefusal::NoShadow)?),
            _ => None,
        };
        let pins = Pins::new(occlusion, &drag.view, &placed, pins)?;
        let unknowns = choose_unknowns(light, drag, from.position.distance(placed.source()))?;
        // A light that moves as a whole overlaps as it did.
        let overlap = match unknowns {
            Unknowns::Points { .. } => OverlapRule::new(light, occlusion.work),
            _ => OverlapRule::default(),
        };
        Ok(Self { placed, from, coords, caster, pins, unknowns, overlap })
    }

    /// Returns the feature with its way to the surface `to`.
    pub fn taken(&self, feature: Feature, to: SeenPoint) -> TakenFeature {
        TakenFeature {
            feature,
            from: self.from,
            to,
            pivot: self.caster.map(|caster| caster.position),
            start_coords: self.coords,
            directions: [self.coords.to_light, feature.target_direction(&to)],
        }
    }

    /// Returns the values of `t` of the feature and its caster.
    pub fn feature_t(&self) -> [f64; 2] {
        [self.coords.t, self.caster.map_or(0.0, |caster| caster.t)]
    }
}

/// Selects the unknowns of the drag. `unit` is the unit of length of a rigid motion, in world units.
fn choose_unknowns(light: &CheckedLight, drag: &Drag, unit: f64) -> Result<Unknowns, DragRefusal> {
    let Some(points) = &drag.points else {
        let is_directional = matches!(light.rays(), LightRays::Parallel(_));
        return Ok(if is_directional { Unknowns::Turn } else { Unknowns::Rigid { unit } });
    };
    let all = light.light().points();
    if all.is_empty() {
        return Err(DragRefusal::NotBendy);
    }
    let mut points = points.clone();
    points.sort_unstable();
    points.dedup();
    if points.iter().any(|point| !(1..all.len()).contains(point)) {
        return Err(DragRefusal::NoSuchPoint);
    }
    let unit = all.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    Ok(Unknowns::Points { points, radii: drag.radii, unit })
}
