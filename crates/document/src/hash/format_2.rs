//! Light hashes of formats 1 and 2: the fields that lights had then, in their order. This code never changes, whatever
//! parameters lights get later. Logs of the current format do not use it.
//!
//! Later parameters have their defaults in a log of that time. A log with other values gets a hash that no real log of
//! that time has.

use glam::DVec3;
use light::parameters::{COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, RANGE, UP};
use light::{Decay, DirectionMode, EndMode, FrameMode, Light, LightShape, ParameterOwner, Transform, Value};

use super::HashWriter;

/// Returns true if `owner` had a parameter of this name in formats 1 and 2, which had no omni or directional lights.
pub fn was_in_format_2(owner: ParameterOwner, name: &str) -> bool {
    use ParameterOwner::{Bendy, Camera, Point, Spot};
    let owners: &[ParameterOwner] = match name {
        "name" | "translation" | "rotation" => &[Spot, Bendy, Camera],
        "scale" | "coneAngle" | "coneSoftness" | "decay" => &[Spot, Bendy],
        "color" | "intensity" => &[Spot, Point],
        "range" => &[Spot],
        "up" | "frame" | "direction" | "endMode" => &[Bendy],
        "position" | "radius" => &[Point],
        "projection" => &[Camera],
        _ => &[],
    };
    owners.contains(&owner)
}

/// Returns true if the hash of formats 1 and 2 covers all values of a light, because parameters that came later have
/// their defaults.
pub(super) fn covers(light: &Light) -> bool {
    let is_covered = |owner, row: &light::Parameter, value: Option<&Value>| {
        was_in_format_2(owner, row.name) || row.default(owner).as_ref() == value
    };
    let owner = light.owner();
    let mut values = light.values();
    let mut of_points = light::parameters_of(ParameterOwner::Point).iter();
    values.all(|(row, value)| is_covered(owner, row, Some(value)))
        && of_points.all(|row| {
            light.points().iter().all(|point| is_covered(ParameterOwner::Point, row, point.value(row).as_ref()))
        })
}

impl HashWriter {
    pub(super) fn light(&mut self, light: &Light) {
        self.text(light.name());
        self.tag(match light.shape() {
            LightShape::Bendy(_) => 0,
            LightShape::Spot => 1,
            // Logs of these formats cannot contain such lights. Their hashes only have to differ.
            LightShape::Directional => 2,
            LightShape::Omni => 3,
        });
        if light.owner() == ParameterOwner::Bendy { self.bendy(light) } else { self.spot(light) }
    }

    fn bendy(&mut self, light: &Light) {
        let points = light.points();
        self.transform(&light.transform());
        self.vectors(points.iter().map(|point| point.position));
        self.reals(points.iter().map(|point| point.radius));
        self.vectors(points.iter().map(|point| point.color));
        self.reals(points.iter().map(|point| point.intensity));
        self.vector(light.get(UP));
        self.real(light.get(CONE_ANGLE));
        self.real(light.get(CONE_SOFTNESS));
        self.tag(match light.get(FRAME) {
            FrameMode::RotationMinimizing => 0,
            FrameMode::Up => 1,
        });
        self.tag(match light.get(DIRECTION) {
            DirectionMode::Tube => 0,
            DirectionMode::Path => 1,
        });
        self.tag(match light.get(END_MODE) {
            EndMode::Cut => 0,
            EndMode::Extend => 1,
        });
        self.decay(light.get(DECAY));
    }

    fn spot(&mut self, light: &Light) {
        self.transform(&light.transform());
        self.vector(light.get(COLOR));
        self.real(light.get(INTENSITY));
        self.real(light.get(CONE_ANGLE));
        self.real(light.get(CONE_SOFTNESS));
        self.option(light.get(RANGE));
        self.decay(light.get(DECAY));
    }

    fn transform(&mut self, transform: &Transform) {
        let Transform { translation, rotation, scale } = transform;
        self.vector(*translation);
        self.rotation(*rotation);
        self.real(*scale);
    }

    fn decay(&mut self, decay: Decay) {
        self.tag(match decay {
            Decay::None => 0,
            Decay::Linear => 1,
            Decay::InverseSquare => 2,
        });
    }

    fn reals(&mut self, reals: impl ExactSizeIterator<Item = f64>) {
        self.number(reals.len() as u64);
        self.each(reals);
    }

    fn vectors(&mut self, vectors: impl ExactSizeIterator<Item = DVec3>) {
        self.number(vectors.len() as u64);
        self.each(vectors.flat_map(|vector| vector.to_array()));
    }
}
