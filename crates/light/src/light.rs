//! What an artist sets: a light's shape and the values of its parameters.

use std::fmt;

use glam::{DQuat, DVec3};

use crate::parameter::choices;
use crate::parameters::{NAME, ROTATION, SCALE, TRANSLATION, parameters_of};
use crate::{Parameter, ParameterKey, ParameterOwner, Setting, Value, ValueType};

/// Where a light stands: `world = translation + rotation * (scale * local)`.
///
/// `turn` need not be of exactly unit length; it is normalised before use. `scale` is positive and the
/// same in all directions, so that circles stay circles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// World position of the light's origin, its source.
    pub translation: DVec3,
    /// Rotation from light-local to world axes.
    pub rotation: DQuat,
    /// World units per light-local unit.
    pub scale: f64,
}

impl Default for Transform {
    fn default() -> Self {
        Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: 1.0 }
    }
}

impl Transform {
    /// World position of a light-local one.
    pub fn world_from_local(&self, local: DVec3) -> DVec3 {
        self.translation + self.rotation.normalize() * (local * self.scale)
    }
}

/// How the cross-section is oriented along the curve (light model, section 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameMode {
    /// No rotation about the tangent from one point of the curve to the next.
    #[default]
    RotationMinimizing,
    /// `w_hat` leans towards `up` at every point, as the paper has it; flips where the tangent meets `up`.
    Up,
}

/// Which direction light arrives from (light model, section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectionMode {
    /// The centre's tangent plus the spread: continuous everywhere.
    #[default]
    Tube,
    /// The exact tangent of the curve of constant (v, w): jumps at joints of a tapering tube.
    Path,
}

/// What happens past the last control point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EndMode {
    /// The light ends there.
    #[default]
    Cut,
    /// It goes straight on: position, radius, colour and intensity go on linearly with their end
    /// derivatives; radius, colour and intensity stop at zero.
    Extend,
}

/// How irradiance falls with the distance `s` travelled, in world units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Decay {
    /// It does not: the cinematic default.
    #[default]
    None,
    /// `1 / s`.
    Linear,
    /// `1 / s^2`, as a physical point source; intensity is then in candela.
    InverseSquare,
}

/// By which curve a light falls off across; [`crate::CrossFalloff`] has the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProfileCurve {
    /// An S-curve: no edge is seen at either end.
    #[default]
    Smooth,
    /// Evenly with the distance from the axis.
    Linear,
    /// A power of how far the cosine has come from the inner angle's to the outer's.
    Power,
    /// A power of the cosine from the axis on, cut at the cone's angle.
    Cosine,
}

/// What the outline of a cross-section is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CrossSection {
    /// Of radius 1.
    #[default]
    Circle,
    /// Between a rectangle and an ellipse.
    Superellipse,
}

choices!(ProfileCurve {
    Smooth: "smooth", "Smooth";
    Linear: "linear", "Linear";
    Power: "power", "Power";
    Cosine: "cosine", "Cosine";
});
choices!(CrossSection { Circle: "circle", "Circle"; Superellipse: "superellipse", "Superellipse"; });
choices!(FrameMode { RotationMinimizing: "rotationMinimizing", "Rotation minimizing"; Up: "up", "Up"; });
choices!(DirectionMode { Tube: "tube", "Tube (continuous)"; Path: "path", "Path (exact)"; });
choices!(EndMode { Cut: "cut", "Cut at the last point"; Extend: "extend", "Extend straight on"; });
choices!(Decay {
    None: "none", "None";
    Linear: "linear", "Linear";
    InverseSquare: "inverseSquare", "Inverse square";
});

/// A control point of a BendyLight with all that it carries, light-local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Of the centre curve.
    pub position: DVec3,
    /// Of the tube, 0 or more.
    pub radius: f64,
    /// Linear RGB.
    pub color: DVec3,
    /// Candela with inverse-square decay.
    pub intensity: f64,
}

impl ControlPoint {
    /// White, of intensity 1.
    pub fn new(position: DVec3, radius: f64) -> Self {
        Self { position, radius, color: DVec3::ONE, intensity: 1.0 }
    }
}

/// What a light is, besides its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// Light along straight lines in a cone: along local -Z from the origin, as in glTF and USD.
    Spot,
    /// Light along parallel lines from infinitely far away, along local -Z: the sun.
    Directional,
    /// Light along straight lines from the origin to all sides: a bulb.
    Omni,
    /// Light along a quadratic B-spline (light model, section 1) through three control points or more; the first is the
    /// source and lies at the origin.
    Bendy(Vec<ControlPoint>),
}

/// A light as it is written down: its shape, and a value for each parameter that the shape has.
///
/// [`crate::CheckedLight`] is one that can be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    shape: LightShape,
    /// In the order of the rows of its shape.
    values: Vec<Value>,
}

impl Light {
    /// A light of that shape, every parameter at its default.
    pub fn new(shape: LightShape) -> Self {
        let owner = shape.owner();
        let default = |row: &&Parameter| row.default(owner).unwrap_or(Value::Absent);
        let values = parameters_of(owner).iter().map(default).collect();
        Self { shape, values }
    }

    /// A spotlight.
    pub fn spot() -> Self {
        Self::new(LightShape::Spot)
    }

    /// A directional light.
    pub fn directional() -> Self {
        Self::new(LightShape::Directional)
    }

    /// An omni light.
    pub fn omni() -> Self {
        Self::new(LightShape::Omni)
    }

    /// A white BendyLight of intensity 1 through `points` with `radii`, as many as there are of both.
    pub fn bendy(points: Vec<DVec3>, radii: Vec<f64>) -> Self {
        let points =
            points.into_iter().zip(radii).map(|(position, radius)| ControlPoint::new(position, radius));
        Self::new(LightShape::Bendy(points.collect()))
    }

    /// What it is.
    pub fn shape(&self) -> &LightShape {
        &self.shape
    }

    /// What has parameters here.
    pub fn owner(&self) -> ParameterOwner {
        self.shape.owner()
    }

    /// Its control points; only a BendyLight has some.
    pub fn points(&self) -> &[ControlPoint] {
        if let LightShape::Bendy(points) = &self.shape { points } else { &[] }
    }

    /// Its control points, to change; `None` for what is no BendyLight.
    pub fn points_mut(&mut self) -> Option<&mut Vec<ControlPoint>> {
        if let LightShape::Bendy(points) = &mut self.shape { Some(points) } else { None }
    }

    /// Its parameters and their values, in the order of the table.
    pub fn values(&self) -> impl Iterator<Item = (&'static Parameter, &Value)> {
        parameters_of(self.owner()).iter().copied().zip(&self.values)
    }

    /// The value of a parameter; `None` where its shape has no such one.
    pub fn value(&self, parameter: &Parameter) -> Option<&Value> {
        self.values().find(|(row, _)| *row == parameter).map(|(_, value)| value)
    }

    /// The value of a parameter. Where its shape has no such one, the default of those that have it.
    pub fn get<T: ValueType>(&self, key: ParameterKey<T>) -> T {
        let elsewhere = || key.owners.iter().find_map(|of| key.default(of.owner));
        let value = self.value(&key).and_then(T::from_value);
        value.or_else(|| T::from_value(&elsewhere()?)).expect("a key has the type of its row's values")
    }

    /// Sets a parameter to a value of any size; [`crate::CheckedLight::new`] sees whether it makes a light. What its shape
    /// does not have changes nothing.
    pub fn set(&mut self, Setting { parameter, value }: Setting) {
        let rows = parameters_of(self.owner());
        if let Some(index) = rows.iter().position(|row| *row == parameter) {
            self.values[index] = value;
        }
    }

    /// The same light with a parameter set.
    #[must_use]
    pub fn with<T: ValueType>(mut self, key: ParameterKey<T>, value: T) -> Self {
        self.set(key.to(value));
        self
    }

    /// The same light in another place.
    #[must_use]
    pub fn with_transform(self, transform: Transform) -> Self {
        let Transform { translation, rotation, scale } = transform;
        self.with(TRANSLATION, translation).with(ROTATION, rotation).with(SCALE, scale)
    }

    /// The same light with each control point changed; `change` is given its index.
    #[must_use]
    pub fn map_points(mut self, mut change: impl FnMut(usize, &mut ControlPoint)) -> Self {
        for (index, point) in self.points_mut().into_iter().flatten().enumerate() {
            change(index, point);
        }
        self
    }

    /// Where it stands.
    pub fn transform(&self) -> Transform {
        let (translation, rotation, scale) = (self.get(TRANSLATION), self.get(ROTATION), self.get(SCALE));
        Transform { translation, rotation, scale }
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        if let Some(Value::Text(name)) = self.value(&NAME) { name } else { "" }
    }
}

impl LightShape {
    /// What has parameters here.
    pub fn owner(&self) -> ParameterOwner {
        match self {
            Self::Spot => ParameterOwner::Spot,
            Self::Bendy(_) => ParameterOwner::Bendy,
            Self::Directional => ParameterOwner::Directional,
            Self::Omni => ParameterOwner::Omni,
        }
    }
}

/// Identifies a light for as long as a session lives. Never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u64);

impl fmt::Display for LightId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
