//! Pins as equations and limits.

use glam::{DVec2, DVec3};

use crate::bound::{Bound, bounds_at, cross_error, direction_error, distance_behind};
use crate::occlusion::{Contact, Occlusion, ShadowCaster};
use crate::point_in_light::{PointInLight, SceneLight};
use crate::quadratic::Hold;
use crate::request::{DragLimit, DragRefusal, NumberedPin, PinKind};

/// Softness of soft pins: an error of 0.1 (radii or radians) weighs as much as a change of three lengths of the light.
const SOFT_PIN_COMPLIANCE: f64 = 1e-3;

/// Softness of the relative error of the irradiance at a point with a direction pin. The pin is of the direction, but a
/// surface keeps its look only if it also receives as much light as before.
const IRRADIANCE_COMPLIANCE: f64 = 1e-5;

/// Distance within which a hit is the pinned surface itself, as a share of the scene's size. The positions of pins come
/// from clients and are rounded.
const CONTACT: f64 = 1e-5;

/// Least distance of a pinned point from the edge of a shadow, in radii of the light.
const SHADOW_EDGE_MARGIN: f64 = 2e-3;

/// Pin, with its state at the start of the drag.
#[derive(Clone, Debug)]
pub(crate) struct PinState {
    /// Number of the pin in the outcome.
    pub number: u64,
    pub kind: PinKind,
    pub is_hard: bool,
    /// Pinned point, in scene space.
    pub point: DVec3,
    /// Light coordinates of the point at the start of the drag.
    pub start_coords: PointInLight,
    /// Irradiance at the start of the drag.
    pub irradiance: f64,
    /// Unit normals of the surface on its lit side: the interpolated one, and the triangle's if that faces the light.
    /// Light from behind does not arrive.
    pub normals: [DVec3; 2],
    /// Point whose shadow is tested, in scene space. Pictures test the same point.
    pub shadow_point: DVec3,
    /// Caster point of a pinned shadow in scene space, and its `t` at the start of the drag.
    pub pivot: Option<(DVec3, f64)>,
    pub contact: Contact,
}

impl PinState {
    /// Makes the state of a pin that is fulfilled at the start of the drag. Returns `Ok(None)` for a soft pin that is
    /// not fulfilled, and an error for a hard one.
    pub fn new(occlusion: &Occlusion, placed: &SceneLight, pin: &NumberedPin) -> Result<Option<Self>, DragRefusal> {
        let found = Self::if_held(occlusion, placed, pin);
        if found.is_none() && pin.pin.is_hard { Err(DragRefusal::PinDoesNotHold(pin.number)) } else { Ok(found) }
    }

    fn if_held(occlusion: &Occlusion, placed: &SceneLight, pin: &NumberedPin) -> Option<Self> {
        let NumberedPin { number, pin } = pin;
        let (bvh, posed) = (occlusion.bvh, &occlusion.bvh.posed);
        let point = pin.at - posed.origin_in_world;
        let coords = placed.locate(point, None).filter(|coords| placed.contains(coords))?;
        let contact = Contact { within: CONTACT * posed.half_extent.length(), triangle: None };
        let spend = |boxes| occlusion.work.spend_on_rays(boxes);
        let surface = bvh.nearest_budgeted(point, contact.within, spend, |_| true);
        let towards = |normal: DVec3| if normal.dot(coords.along_path) < 0.0 { -normal } else { normal };
        let (normals, offset) = surface.map_or(([coords.along_path; 2], 0.0), |surface| {
            let (smooth, offset) = bvh.smooth_surface_at(surface.triangle, surface.barycentrics, surface.position);
            let flat = bvh.triangles[surface.triangle].normal().normalize();
            let [smooth, flat] = [smooth, flat].map(towards);
            ([smooth, if flat.dot(smooth) > 0.0 { flat } else { smooth }], offset)
        });
        let pinned = Self {
            number: *number,
            kind: pin.kind,
            is_hard: pin.is_hard,
            point,
            start_coords: coords,
            irradiance: placed.locate_with_irradiance(point, coords.t)?.1,
            normals,
            shadow_point: point + normals[0] * offset,
            pivot: None,
            contact,
        };
        let is_caster = |node: usize| match &pin.caster {
            Some(caster) => posed.scene.nodes[node].name == *caster || posed.node_tree().path(node) == *caster,
            None => true,
        };
        match pin.kind {
            PinKind::Direction => Some(pinned),
            PinKind::Lit => pinned.is_lit(occlusion, placed, &coords).then_some(pinned),
            PinKind::Shadowed => pinned.is_shadowed(occlusion, placed, &coords).then_some(pinned),
            PinKind::Shadow => {
                let caster =
                    occlusion.first_caster_on_path(placed, &coords, coords.cross_coords, point, contact, is_caster)?;
                Some(Self { pivot: Some((caster.position, caster.t)), ..pinned })
            }
        }
    }

    /// True if light arrives at the front of the surface, if no caster blocks it.
    pub fn is_lit(&self, occlusion: &Occlusion, placed: &SceneLight, coords: &PointInLight) -> bool {
        self.normals.iter().all(|normal| normal.dot(coords.along_path) > 0.0)
            && self.first_caster(occlusion, placed, coords).is_none()
    }

    /// True if a caster shadows the point.
    pub fn is_shadowed(&self, occlusion: &Occlusion, placed: &SceneLight, coords: &PointInLight) -> bool {
        self.first_caster(occlusion, placed, coords).is_some()
    }

    fn first_caster(&self, occlusion: &Occlusion, placed: &SceneLight, coords: &PointInLight) -> Option<ShadowCaster> {
        let coords = self.shadow_coords(placed, coords)?;
        occlusion.first_caster_on_path(placed, &coords, coords.cross_coords, self.shadow_point, self.contact, |_| true)
    }

    /// Returns the light coordinates of the shadow point, in a light that has the pinned point at `coords`.
    pub fn shadow_coords(&self, placed: &SceneLight, coords: &PointInLight) -> Option<PointInLight> {
        placed.locate(self.shadow_point, Some(coords.t))
    }

    /// Returns the values of `t` to track for the pin and its pivot, at the start of the drag.
    pub fn start_t(&self) -> [f64; 2] {
        [self.start_coords.t, self.pivot.map_or(0.0, |(_, t)| t)]
    }

    /// Returns the softness of the pin; 0 for a hard pin.
    pub fn compliance(&self) -> f64 {
        if self.is_hard { 0.0 } else { SOFT_PIN_COMPLIANCE }
    }

    /// Returns the priorities of the pin's equations.
    pub fn row_holds(&self) -> impl Iterator<Item = Hold> {
        let hold = if self.is_hard { Hold::Fixed } else { Hold::Soft(SOFT_PIN_COMPLIANCE) };
        let count = if matches!(self.kind, PinKind::Direction | PinKind::Shadow) { 2 } else { 0 };
        let arriving = self.holds_irradiance().then_some(Hold::Soft(IRRADIANCE_COMPLIANCE));
        std::iter::repeat_n(hold, count).chain(arriving)
    }

    fn holds_irradiance(&self) -> bool {
        self.kind == PinKind::Direction && self.irradiance > 0.0
    }

    /// Adds the pin's residuals and limits. Returns the tracked values of `t` and the light coordinates of the pin.
    /// `None` if the point or its pivot cannot be tracked.
    pub fn add_residual(
        &self,
        placed: &SceneLight,
        near: [f64; 2],
        residual: &mut Vec<f64>,
        bounds: &mut Vec<Bound>,
    ) -> Option<([f64; 2], PointInLight)> {
        let (coords, irradiance) = if self.holds_irradiance() {
            placed.locate_with_irradiance(self.point, near[0])?
        } else {
            (placed.locate(self.point, Some(near[0]))?, 0.0)
        };
        let bound = |value| Bound { value, limit: DragLimit::Pin(self.number), compliance: self.compliance() };
        bounds_at(placed, &coords, [DragLimit::Pin(self.number); 2], self.compliance(), 0.0, bounds);
        if self.kind == PinKind::Lit {
            bounds.extend(self.normals.map(|normal| {
                let least = SHADOW_EDGE_MARGIN.min(0.5 * self.start_coords.along_path.dot(normal));
                bound(coords.along_path.dot(normal) - least)
            }));
        }
        let mut pivot_t = near[1];
        match (self.kind, self.pivot) {
            (PinKind::Direction, _) => {
                residual.extend(direction_error(coords.to_light, self.start_coords.to_light)?.to_array());
            }
            (PinKind::Shadow, Some((pivot, _))) => {
                let pivot = placed.locate(pivot, Some(near[1]))?;
                pivot_t = pivot.t;
                bounds.push(bound(distance_behind(&coords, &pivot, &self.start_coords)));
                residual.extend(cross_error(pivot.cross_coords, &coords, &self.start_coords).to_array());
            }
            _ => {}
        }
        if self.holds_irradiance() {
            residual.push(irradiance / self.irradiance - 1.0);
        }
        Some(([coords.t, pivot_t], coords))
    }
}

/// Tangent of a shadow edge or of a surface that a light has crossed and may not cross. It is taken where the light
/// crossed, and limits the next solve.
#[derive(Clone, Copy, Debug)]
pub(crate) enum OcclusionTangent {
    /// Tangent of the edge of a shadow.
    ShadowEdge {
        /// Number of the pin whose point crossed the shadow edge.
        pin: u64,
        /// Caster point that casts the shadow edge, in scene space.
        caster: DVec3,
        /// Distance of that caster point along the light.
        t: f64,
        /// Unit vector across the light, from the edge to the allowed side.
        allowed: DVec2,
    },
    /// Tangent of a surface in front of the source.
    Surface {
        /// Point of the surface that the source crossed, in scene space.
        at: DVec3,
        /// Unit normal of the surface, towards the side on which the source has to stay.
        normal: DVec3,
        /// Least distance of the source from the surface, in world units.
        clearance: f64,
        /// Size of the scene, in world units.
        size: f64,
    },
}

impl OcclusionTangent {
    /// Returns the number of the pin whose point crossed the shadow edge; `None` for a surface.
    pub fn pin(&self) -> Option<u64> {
        if let Self::ShadowEdge { pin, .. } = self { Some(*pin) } else { None }
    }

    /// Computes the distance of a pin at `coords` from the shadow edge, as a limit.
    pub fn pin_bound(&self, placed: &SceneLight, coords: &PointInLight, pin: &PinState) -> Option<Bound> {
        let Self::ShadowEdge { caster, t, allowed, .. } = self else { return None };
        let edge = placed.locate(*caster, Some(*t))?;
        let coords = &pin.shadow_coords(placed, coords)?;
        let value = -cross_error(edge.cross_coords, coords, &pin.start_coords).dot(*allowed) - SHADOW_EDGE_MARGIN;
        Some(Bound { value, limit: DragLimit::Pin(pin.number), compliance: pin.compliance() })
    }

    /// Computes the distance of the source from the surface, as a limit. `None` for a shadow edge.
    pub fn source_bound(&self, placed: &SceneLight) -> Option<Bound> {
        let Self::Surface { at, normal, clearance, size } = self else { return None };
        let value = ((placed.source() - *at).dot(*normal) - clearance) / size;
        Some(Bound { value, limit: DragLimit::SourceInside, compliance: 0.0 })
    }
}
