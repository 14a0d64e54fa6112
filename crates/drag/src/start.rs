//! Start of a drag, the same for all its alternatives: the picked surfaces, the light coordinates of the feature, the pins
//! and the points that measure the picture.

use std::cell::OnceCell;

use light::{CheckedLight, LightRays};
use raycast::{Bvh, SeenPoint};

use crate::moves::Unknowns;
use crate::occlusion::{Occlusion, ShadowCaster};
use crate::overlap::OverlapRule;
use crate::picture_metric::PictureMetric;
use crate::pins::Pins;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{Drag, DragRefusal, Feature, NumberedPin};
use crate::taken_feature::TakenFeature;
use crate::work::WorkBudget;

/// Drag with all that it depends on.
#[derive(Clone, Copy)]
pub(crate) struct DragTask<'a> {
    pub bvh: &'a Bvh,
    pub light: &'a CheckedLight,
    pub drag: &'a Drag,
    /// Pins to keep.
    pub pins: &'a [NumberedPin],
    pub work: &'a WorkBudget<'a>,
}

/// Start of a drag of a light, the same for all its ends and for all parts of the light that may follow.
pub(crate) struct DragStart<'a> {
    pub occlusion: Occlusion<'a>,
    pub light: &'a CheckedLight,
    pub placed: SceneLight<'a>,
    pub from: SeenPoint,
    /// Surface under the cursor.
    pub to: SeenPoint,
    /// Light coordinates of `from`.
    pub coords: PointInLight,
    /// First caster before `from`, for a dragged shadow.
    pub caster: Option<ShadowCaster>,
    pub pins: Pins,
    /// Points of the picture that are to change little.
    pub metric: PictureMetric,
    /// Rule that keeps the tube out of itself, made once if control points move.
    overlap: OnceCell<OverlapRule>,
}

impl<'a> DragStart<'a> {
    /// Finds the start of a drag between the surfaces of `picked`, or returns the reason to refuse the drag. If it
    /// `keeps_picture`, the rest of the picture changes as little as it can, else the light.
    pub fn new(task: DragTask<'a>, picked: &[Option<SeenPoint>; 2], keeps_picture: bool) -> Result<Self, DragRefusal> {
        let DragTask { bvh, light, drag, pins, work, .. } = task;
        let occlusion = Occlusion::new(bvh, light, work);
        let [from, to] = *picked;
        let from = from.ok_or(DragRefusal::NothingAtStart)?;
        let to = to.ok_or(DragRefusal::NothingAtEnd)?;
        let placed = SceneLight::new(light.rays(), bvh.posed.origin_in_world, from.position, work);
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
        let pins = Pins::new(&occlusion, &drag.view, &placed, pins)?;
        // The wish of a dragged hotspot is that the picture changes.
        let metric = if keeps_picture && drag.feature != Feature::Hotspot {
            PictureMetric::new(&occlusion, &drag.view, &placed, caster.map(|caster| caster.node))
        } else {
            PictureMetric::default()
        };
        Ok(Self { occlusion, light, placed, from, to, coords, caster, pins, metric, overlap: OnceCell::new() })
    }

    /// Returns the rule by which a light with these unknowns overlaps. A light that moves as a whole overlaps as it did.
    pub fn overlap_of(&self, unknowns: &Unknowns) -> OverlapRule {
        match unknowns {
            Unknowns::Points { .. } => *self.overlap.get_or_init(|| OverlapRule::new(self.light, self.occlusion.work)),
            _ => OverlapRule::default(),
        }
    }

    /// Selects the unknowns of the drag.
    pub fn unknowns(&self, drag: &Drag) -> Result<Unknowns, DragRefusal> {
        let light = self.light;
        let Some(points) = &drag.points else {
            let is_directional = matches!(light.rays(), LightRays::Parallel(_));
            // A rigid motion is measured by the way that the light goes.
            let unit = self.from.position.distance(self.placed.source());
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
