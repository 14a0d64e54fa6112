//! Pin of a point as equations and limits.

use glam::{DVec2, DVec3};
use light::TubeOverlap;

use crate::bound::{Bound, EDGE_MARGIN, MIN_PATH_SPACING, cross_error, direction_error, distance_behind, hard_bound};
use crate::occlusion::{Contact, Occlusion, ShadowCaster};
use crate::overlap::overlap_bound;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{DragLimit, NumberedPin, PinKind, PinTarget};

/// Softness of the relative error of the irradiance at a point with a direction pin. The pin is of the direction, but a
/// surface keeps its look only if it also receives as much light as before.
const IRRADIANCE_COMPLIANCE: f64 = 1e-3;

/// Least share of the light that arrived at a point pinned as lit, and the share below which it counts as none.
const LEAST_LIT_SHARE: f64 = 0.5;
const UNLIT: f64 = 1e-6;

/// Distance within which a hit is the pinned surface itself, as a share of the scene's size. The positions of pins come
/// from clients and are rounded.
pub(crate) const CONTACT: f64 = 1e-5;

/// Least distance of a pinned point from the edge of a shadow, in radii of the light.
const SHADOW_EDGE_MARGIN: f64 = 2e-3;

/// Pin, with its state at the start of the drag.
#[derive(Clone, Debug)]
pub(crate) struct PinState {
    /// Number of the pin in the outcome.
    pub number: u64,
    pub kind: PinKind,
    /// Softness of the pin; 0 for a hard pin of a point.
    pub compliance: f64,
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
    /// Node of the surface at the point; `None` if there is no surface.
    pub node: Option<usize>,
    /// True for one of many points of a pinned node.
    pub is_of_node: bool,
    /// True if the point has to stay lit, false if it has to stay in a shadow; `None` if neither.
    pub stays_lit: Option<bool>,
}

impl PinState {
    /// Makes the state of a pin at a point in scene space. `None` if the pin does not hold at the start of the drag.
    pub fn if_held(
        occlusion: &Occlusion,
        placed: &SceneLight,
        pin: &NumberedPin,
        point: DVec3,
        compliance: f64,
    ) -> Option<Self> {
        let NumberedPin { number, pin } = pin;
        let is_of_node = matches!(pin.at, PinTarget::Node(_));
        let (bvh, posed) = (occlusion.bvh, &occlusion.bvh.posed);
        let coords = placed.locate(point, None).filter(|coords| placed.contains(coords))?;
        let contact = Contact { within: CONTACT * posed.half_extent.length(), triangle: None };
        let spend = |boxes| occlusion.work.spend_on_rays(boxes);
        let surface = bvh.nearest_budgeted(point, contact.within, spend, |_| true);
        let towards = |normal: DVec3| if normal.dot(coords.along_path) < 0.0 { -normal } else { normal };
        let (normals, offset) = surface.map_or(([coords.along_path; 2], 0.0), |surface| {
            let (smooth, offset) = bvh.smooth_surface_at(surface.triangle, surface.barycentrics, surface.position);
            let flat = bvh.triangle(surface.triangle).normal().normalize();
            let [smooth, flat] = [smooth, flat].map(towards);
            ([smooth, if flat.dot(smooth) > 0.0 { flat } else { smooth }], offset)
        });
        let pinned = Self {
            number: *number,
            kind: pin.kind,
            compliance,
            point,
            start_coords: coords,
            irradiance: placed.locate_with_edge_irradiance(point, coords.t)?.1,
            normals,
            shadow_point: point + normals[0] * offset,
            pivot: None,
            contact,
            node: surface.map(|surface| bvh.triangle(surface.triangle).node),
            is_of_node,
            stays_lit: None,
        };
        let is_caster = |node: usize| match &pin.caster {
            Some(caster) => posed.scene.nodes[node].name == *caster || posed.node_tree().path(node) == *caster,
            None => true,
        };
        match pin.kind {
            PinKind::Direction | PinKind::Coordinates => Some(pinned),
            PinKind::Look => {
                let stays_lit = Some(pinned.is_lit(occlusion, placed, &coords));
                Some(Self { stays_lit, ..pinned })
            }
            PinKind::Lit => {
                let is_lit = pinned.is_lit(occlusion, placed, &coords);
                is_lit.then_some(Self { stays_lit: Some(true), ..pinned })
            }
            PinKind::Shadowed => {
                let is_shadowed = pinned.is_shadowed(occlusion, placed, &coords);
                is_shadowed.then_some(Self { stays_lit: Some(false), ..pinned })
            }
            PinKind::Shadow => {
                let caster =
                    occlusion.first_caster_on_path(placed, &coords, coords.cross_coords, point, contact, is_caster)?;
                Some(Self { pivot: Some((caster.position, caster.t)), ..pinned })
            }
        }
    }

    /// Returns the unshadowed irradiance on the surface at `coords`. `None` if the budget is spent.
    pub fn brightness(&self, placed: &SceneLight, coords: &PointInLight) -> Option<f64> {
        let (coords, irradiance) = placed.locate_with_edge_irradiance(self.point, coords.t)?;
        Some(irradiance * coords.to_light.dot(self.normals[0]).max(0.0))
    }

    /// Returns the unshadowed irradiance on the surface at the start of the drag.
    pub fn start_brightness(&self) -> f64 {
        self.irradiance * self.start_coords.to_light.dot(self.normals[0]).max(0.0)
    }

    /// True if at least half of the light of the start of the drag arrives at `coords`, if no caster blocks it. `None` if
    /// the budget is spent.
    pub fn keeps_light(&self, placed: &SceneLight, coords: &PointInLight) -> Option<bool> {
        // The bound that the solver keeps is exact to its tolerance.
        Some(self.brightness(placed, coords)? >= (1.0 - 1e-5) * LEAST_LIT_SHARE * self.start_brightness())
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

    /// True if the drag must preserve the property exactly.
    pub fn is_hard(&self) -> bool {
        self.compliance == 0.0
    }

    /// Adds the pin's bounds, and gives its errors to `add`. Returns the tracked values of `t` and the light coordinates
    /// of the pin. `None` if the point or its pivot cannot be tracked.
    pub fn add_rows(
        &self,
        placed: &SceneLight,
        near: [f64; 2],
        bounds: &mut Vec<Bound>,
        mut add: impl FnMut(PinRow),
    ) -> Option<([f64; 2], PointInLight)> {
        let (coords, irradiance) = placed.locate_with_edge_irradiance(self.point, near[0])?;
        let compliance = self.compliance;
        let bound = |value| Bound { value, limit: DragLimit::Pin(self.number), compliance };
        bounds.extend([
            bound(coords.path_spacing - MIN_PATH_SPACING),
            bound(1.0 - EDGE_MARGIN - placed.rho2(&coords)),
            bound(coords.distance_to_ends.min(1.0)),
        ]);
        let mut add_errors = |errors: &[f64]| {
            for error in errors {
                add(if self.is_hard() { PinRow::Equation(*error) } else { PinRow::Soft(error / compliance.sqrt()) });
            }
        };
        let turned = || direction_error(coords.to_light, self.start_coords.to_light);
        let mut pivot_t = near[1];
        match (self.kind, self.pivot) {
            (PinKind::Direction, _) => {
                add_errors(&turned()?.to_array());
                if self.irradiance > 0.0 {
                    let compliance = IRRADIANCE_COMPLIANCE.max(compliance);
                    add(PinRow::Soft((irradiance / self.irradiance - 1.0) / compliance.sqrt()));
                }
            }
            (PinKind::Look, _) => {
                add_errors(&turned()?.to_array());
                if self.irradiance > 0.0 {
                    add_errors(&[irradiance / self.irradiance - 1.0]);
                }
            }
            (PinKind::Coordinates, _) => {
                let was = self.start_coords.cross_coords;
                add_errors(&cross_error(was, &coords, &self.start_coords).to_array());
            }
            (PinKind::Shadow, Some((pivot, _))) => {
                let pivot = placed.locate(pivot, Some(near[1]))?;
                pivot_t = pivot.t;
                bounds.push(bound(distance_behind(&coords, &pivot, &self.start_coords)));
                add_errors(&cross_error(pivot.cross_coords, &coords, &self.start_coords).to_array());
            }
            (PinKind::Lit, _) => {
                bounds.extend(self.normals.map(|normal| {
                    let least = SHADOW_EDGE_MARGIN.min(0.5 * self.start_coords.along_path.dot(normal));
                    bound(coords.along_path.dot(normal) - least)
                }));
                let now = irradiance * coords.to_light.dot(self.normals[0]).max(0.0);
                let was = self.start_brightness();
                if was > 0.0 {
                    bounds.push(bound(libm::log((now / was).max(UNLIT) / LEAST_LIT_SHARE)));
                }
            }
            (PinKind::Shadowed | PinKind::Shadow, _) => {}
        }
        Some(([coords.t, pivot_t], coords))
    }
}

/// Error of a pin, weighted if it is soft.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PinRow {
    /// Must be 0.
    Equation(f64),
    /// Is kept small.
    Soft(f64),
}

/// Tangent of a limit that a light has crossed and may not cross. It is taken where the light crossed, and limits the next
/// solve.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LimitTangent {
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
    /// Distance of two parts of the tube that met.
    Overlap(TubeOverlap),
}

impl LimitTangent {
    /// Returns the number of the pin whose point crossed the shadow edge; `None` for other limits.
    pub fn pin(&self) -> Option<u64> {
        if let Self::ShadowEdge { pin, .. } = self { Some(*pin) } else { None }
    }

    /// Computes the distance of a pin at `coords` from the shadow edge, as a limit.
    pub fn pin_bound(&self, placed: &SceneLight, coords: &PointInLight, pin: &PinState) -> Option<Bound> {
        let Self::ShadowEdge { caster, t, allowed, .. } = self else { return None };
        let edge = placed.locate(*caster, Some(*t))?;
        let coords = &pin.shadow_coords(placed, coords)?;
        let value = -cross_error(edge.cross_coords, coords, &pin.start_coords).dot(*allowed) - SHADOW_EDGE_MARGIN;
        Some(Bound { value, limit: DragLimit::Pin(pin.number), compliance: pin.compliance })
    }

    /// Computes the distance of the source from the surface, or of two parts of the tube, as a limit. `None` for a shadow
    /// edge.
    pub fn light_bound(&self, placed: &SceneLight) -> Option<Bound> {
        match self {
            Self::ShadowEdge { .. } => None,
            Self::Surface { at, normal, clearance, size } => {
                let value = ((placed.source() - *at).dot(*normal) - clearance) / size;
                Some(hard_bound(value, DragLimit::SourceInside))
            }
            Self::Overlap(met) => overlap_bound(met, placed.rays),
        }
    }
}
