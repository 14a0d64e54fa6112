//! Bending and straightening of lights.

use std::sync::Arc;

use glam::DVec3;
use light::{CheckedLight, Light, LightError, LightId, ParameterOwner};
use raycast::Bvh;

use crate::{Change, Command, Document, EditError, NumberedLight, PointNumbering};

/// Default number of segments of a bent light, for five control points.
pub const DEFAULT_BEND_SEGMENTS: usize = 3;

/// Default half angle, in degrees, of the cone in which an omni or directional light is bent.
const DEFAULT_CONE_DEGREES: f64 = 45.0;

/// Distance from the source within which a surface counts as the light's own housing and is ignored, as a share of the
/// scene's size.
const HOUSING_SIZE_SHARE: f64 = 0.01;

/// Returns the length along its axis that the control points of a straight light span, in world units. They reach to
/// the first surface on the axis, so that handles lie at the light's shadow, or else past the scene's bounds.
///
/// Surfaces nearer than a hundredth of the scene's size count as the light's own housing.
pub fn axis_length(light: &Light, bvh: &Bvh) -> f64 {
    let transform = light.transform();
    let axis = transform.rotation.normalize() * DVec3::NEG_Z;
    let (size, source) = (bvh.posed.half_extent.length(), transform.translation - bvh.posed.origin_in_world);
    if let Some(hit) = bvh.first_hit(source, axis, [HOUSING_SIZE_SHARE * size, f64::INFINITY], |_| true) {
        return hit.distance;
    }
    let past_bounds = bvh.posed.half_extent.dot(axis.abs()) - source.dot(axis);
    // A light that points away from the scene reaches as far as the scene is large; without a scene, one unit.
    [past_bounds * 1.01, size].into_iter().find(|reach| *reach > 0.0).unwrap_or(1.0)
}

/// Parameters of a [`Command::BendLight`], with the same meanings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BendRequest {
    pub segments: usize,
    pub range: Option<f64>,
    pub cone_angle: Option<f64>,
    pub toward: Option<DVec3>,
}

impl BendRequest {
    /// Fills in the values that depend on the scene: the reach of the light and, for a light without a cone, the
    /// target, which is the scene's centre.
    #[must_use]
    pub fn filled_in_from_scene(self, light: &Light, bvh: &Bvh) -> Self {
        let toward = match light.owner() {
            ParameterOwner::Omni | ParameterOwner::Directional => {
                Some(self.toward.unwrap_or(bvh.posed.origin_in_world))
            }
            _ => self.toward,
        };
        let cone_degrees = self.cone_angle.unwrap_or(DEFAULT_CONE_DEGREES);
        let reach = || match light.owner() {
            // Far enough that the cone contains the whole scene.
            ParameterOwner::Directional => {
                (bvh.posed.half_extent.length() / libm::sin(cone_degrees.to_radians())).max(1.0)
            }
            // Bending refuses this light later, so any reach will do.
            _ => light::as_spotlight(light, cone_degrees, toward, 1.0).map_or(1.0, |spot| axis_length(&spot, bvh)),
        };
        Self { range: Some(self.range.unwrap_or_else(reach)), toward, ..self }
    }

    /// Makes a BendyLight from `light`.
    pub fn bend(self, light: &Light) -> Result<Light, LightError> {
        if light.owner() == ParameterOwner::Omni && self.toward == Some(light.transform().translation) {
            return Err(LightError::TowardAtSource);
        }
        let reach = self.range.unwrap_or_else(|| light.transform().scale);
        let cone_angle = self.cone_angle.unwrap_or(DEFAULT_CONE_DEGREES);
        light::bend_with_length(&light::as_spotlight(light, cone_angle, self.toward, reach)?, self.segments, reach)
    }
}

/// Fills in the values of `command` that depend on the scene, so that a log of it needs no scene.
pub fn fill_in_from_scene(command: Command, document: &Document, bvh: &Bvh) -> Command {
    let Command::BendLight { light: id, segments, range, cone_angle, toward, ignore_pins } = command else {
        return command;
    };
    let Some(placed) = document.lights.get(&id) else { return command };
    let request = BendRequest { segments, range, cone_angle, toward };
    let BendRequest { segments, range, cone_angle, toward } = request.filled_in_from_scene(placed.light.light(), bvh);
    Command::BendLight { light: id, segments, range, cone_angle, toward, ignore_pins }
}

/// Changes the shape of a light under its id. Its control points get a new numbering.
pub(crate) fn reshape_change(
    document: &Document,
    id: LightId,
    placed: &NumberedLight,
    reshape: impl FnOnce(&Light) -> Result<Light, LightError>,
) -> Result<Change, EditError> {
    let invalid = |reason| EditError::InvalidLight { light: document.light_name(id), reason };
    let light = reshape(placed.light.light()).and_then(CheckedLight::new).map_err(invalid)?;
    let new = NumberedLight { layout: PointNumbering(document.next_number()), light: Arc::new(light) };
    Ok(Change::Light { light: id, old: Some(placed.clone()), new: Some(new) })
}
