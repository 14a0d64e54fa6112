//! Lights that are bent and made straight again.

use std::sync::Arc;

use glam::DVec3;
use light::{CheckedLight, Light, LightError, LightId, ParameterOwner};
use raycast::Bvh;

use crate::{Change, Command, Document, EditError, NumberedLight, PointNumbering};

/// Segments of a light that is bent, unless it is said: five control points.
pub const DEFAULT_BEND_SEGMENTS: usize = 3;

/// Half angle, in degrees, of the cone in which an omni or directional light is bent, unless it is said.
const DEFAULT_CONE_DEGREES: f64 = 45.0;

/// What a light's own housing is: nothing nearer to the source than this share of the scene's size is where it shines.
const HOUSING_SIZE_SHARE: f64 = 0.01;

/// How far along its axis the control points of a straight light are to reach, in world units: to where the axis meets the
/// scene, so that handles lie where its shadow is; past the scene's bounds where it does not.
///
/// What lies nearer than a hundredth of the scene's size counts as the light's own housing.
pub fn axis_length(light: &Light, bvh: &Bvh) -> f64 {
    let transform = light.transform();
    let axis = transform.rotation.normalize() * DVec3::NEG_Z;
    let (size, source) = (bvh.posed.half_extent.length(), transform.translation - bvh.posed.origin_in_world);
    if let Some(hit) = bvh.first_hit(source, axis, [HOUSING_SIZE_SHARE * size, f64::INFINITY], |_| true) {
        return hit.distance;
    }
    let past_bounds = bvh.posed.half_extent.dot(axis.abs()) - source.dot(axis);
    // Looking away from the scene, as far as the scene is large; without one, a unit.
    [past_bounds * 1.01, size].into_iter().find(|reach| *reach > 0.0).unwrap_or(1.0)
}

/// How a straight light is to be bent: what a [`Command::BendLight`] says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BendRequest {
    /// As of the command.
    pub segments: usize,
    /// As of the command.
    pub range: Option<f64>,
    /// As of the command.
    pub cone_angle: Option<f64>,
    /// As of the command.
    pub toward: Option<DVec3>,
}

impl BendRequest {
    /// The same of `light` in this scene, with what only the scene knows filled in: how far the light reaches, and where one
    /// without a cone shines, the scene's middle.
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
            // So far off that the cone holds the whole scene.
            ParameterOwner::Directional => {
                (bvh.posed.half_extent.length() / libm::sin(cone_degrees.to_radians())).max(1.0)
            }
            // A light that is refused reaches nowhere.
            _ => light::as_spotlight(light, cone_degrees, toward, 1.0)
                .map_or(1.0, |spot| axis_length(&spot, bvh)),
        };
        Self { range: Some(self.range.unwrap_or_else(reach)), toward, ..self }
    }

    /// The BendyLight that `light` becomes.
    pub fn bend(self, light: &Light) -> Result<Light, LightError> {
        if light.owner() == ParameterOwner::Omni && self.toward == Some(light.transform().translation) {
            return Err(LightError::TowardAtSource);
        }
        let reach = self.range.unwrap_or_else(|| light.transform().scale);
        let cone_angle = self.cone_angle.unwrap_or(DEFAULT_CONE_DEGREES);
        light::bend_with_length(
            &light::as_spotlight(light, cone_angle, self.toward, reach)?,
            self.segments,
            reach,
        )
    }
}

/// `command` with what only the scene knows filled in, so that a log of it needs no scene.
pub fn fill_in_from_scene(command: Command, document: &Document, bvh: &Bvh) -> Command {
    let Command::BendLight { light: id, segments, range, cone_angle, toward } = command else {
        return command;
    };
    let Some(placed) = document.lights.get(&id) else { return command };
    let asked = BendRequest { segments, range, cone_angle, toward };
    let BendRequest { segments, range, cone_angle, toward } =
        asked.filled_in_from_scene(placed.light.light(), bvh);
    Command::BendLight { light: id, segments, range, cone_angle, toward }
}

/// A light that becomes one of another shape under its id, with a new numbering of its control points.
pub(crate) fn reshape_change(
    document: &Document,
    (id, placed): (LightId, &NumberedLight),
    reshape: impl FnOnce(&Light) -> Result<Light, LightError>,
) -> Result<Change, EditError> {
    let invalid = |reason| EditError::InvalidLight { light: document.light_name(id), reason };
    let light = reshape(placed.light.light()).and_then(CheckedLight::new).map_err(invalid)?;
    let new = NumberedLight { layout: PointNumbering(document.next_number()), light: Arc::new(light) };
    Ok(Change::Light { light: id, old: Some(placed.clone()), new: Some(new) })
}
