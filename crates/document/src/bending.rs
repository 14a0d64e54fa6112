//! Lights that are bent and made straight again.

use std::sync::Arc;

use glam::DVec3;
use light::{CheckedLight, Light, LightError, LightId, Owner};
use raycast::Bvh;

use crate::{Change, Command, Document, EditError, Layout, PlacedLight};

/// Segments of a light that is bent, unless it is said: five control points.
pub const BENT_SEGMENTS: usize = 3;

/// Half angle, in degrees, of the cone in which an omni or directional light is bent, unless it is said.
const BENT_CONE_ANGLE: f64 = 45.0;

/// What a light's own housing is: nothing nearer to the source than this share of the scene's size is where it shines.
const HOUSING: f64 = 0.01;

/// How far along its axis the control points of a straight light are to reach, in world units: to where the axis meets the
/// scene, so that handles lie where its shadow is; past the scene's bounds where it does not.
///
/// What lies nearer than a hundredth of the scene's size counts as the light's own housing.
pub fn axis_reach(light: &Light, bvh: &Bvh) -> f64 {
    let transform = light.transform();
    let axis = transform.rotation.normalize() * DVec3::NEG_Z;
    let (size, source) = (bvh.posed.half_extent.length(), transform.translation - bvh.posed.origin_in_world);
    if let Some(hit) = bvh.first_hit(source, axis, [HOUSING * size, f64::INFINITY], |_| true) {
        return hit.distance;
    }
    let past_bounds = bvh.posed.half_extent.dot(axis.abs()) - source.dot(axis);
    // Looking away from the scene, as far as the scene is large; without one, a unit.
    [past_bounds * 1.01, size].into_iter().find(|reach| *reach > 0.0).unwrap_or(1.0)
}

/// How a straight light is to be bent: what a [`Command::BendLight`] says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bending {
    /// As of the command.
    pub segments: usize,
    /// As of the command.
    pub range: Option<f64>,
    /// As of the command.
    pub cone_angle: Option<f64>,
    /// As of the command.
    pub toward: Option<DVec3>,
}

impl Bending {
    /// The same of `light` in this scene, with what only the scene knows filled in: how far the light reaches, and where one
    /// without a cone shines, the scene's middle.
    #[must_use]
    pub fn in_scene(self, light: &Light, bvh: &Bvh) -> Self {
        let toward = match light.owner() {
            Owner::Omni | Owner::Directional => Some(self.toward.unwrap_or(bvh.posed.origin_in_world)),
            _ => self.toward,
        };
        let cone_degrees = self.cone_angle.unwrap_or(BENT_CONE_ANGLE);
        let reach = || match light.owner() {
            // So far off that the cone holds the whole scene.
            Owner::Directional => {
                (bvh.posed.half_extent.length() / libm::sin(cone_degrees.to_radians())).max(1.0)
            }
            // A light that is refused reaches nowhere.
            _ => {
                light::with_cone(light, cone_degrees, toward, 1.0).map_or(1.0, |spot| axis_reach(&spot, bvh))
            }
        };
        Self { range: Some(self.range.unwrap_or_else(reach)), toward, ..self }
    }

    /// The BendyLight that `light` becomes.
    pub fn bent(self, light: &Light) -> Result<Light, LightError> {
        if light.owner() == Owner::Omni && self.toward == Some(light.transform().translation) {
            return Err(LightError::NowhereToShine);
        }
        let reach = self.range.unwrap_or_else(|| light.transform().scale);
        let cone_angle = self.cone_angle.unwrap_or(BENT_CONE_ANGLE);
        light::bend_to(&light::with_cone(light, cone_angle, self.toward, reach)?, self.segments, reach)
    }
}

/// `command` with what only the scene knows filled in, so that a log of it needs no scene.
pub fn resolved(command: Command, document: &Document, bvh: &Bvh) -> Command {
    let Command::BendLight { light: id, segments, range, cone_angle, toward } = command else {
        return command;
    };
    let Some(placed) = document.lights.get(&id) else { return command };
    let asked = Bending { segments, range, cone_angle, toward };
    let Bending { segments, range, cone_angle, toward } = asked.in_scene(placed.light.light(), bvh);
    Command::BendLight { light: id, segments, range, cone_angle, toward }
}

/// A light that becomes one of another shape under its id, with a new numbering of its control points.
pub(crate) fn reshaped(
    document: &Document,
    (id, placed): (LightId, &PlacedLight),
    reshape: impl FnOnce(&Light) -> Result<Light, LightError>,
) -> Result<Change, EditError> {
    let invalid = |reason| EditError::InvalidLight { light: document.light_name(id), reason };
    let light = reshape(placed.light.light()).and_then(CheckedLight::new).map_err(invalid)?;
    let new = PlacedLight { layout: Layout(document.next_number()), light: Arc::new(light) };
    Ok(Change::Light { light: id, old: Some(placed.clone()), new: Some(new) })
}
