//! Lights as an artist sets them: a shape and the values of its parameters.

use std::fmt;

use glam::{DMat3, DQuat, DVec3};

use crate::parameter::choices;
use crate::parameters::{NAME, ROTATION, SCALE, TRANSLATION, parameters_of};
use crate::{Parameter, ParameterKey, ParameterOwner, Setting, Value, ValueType};

/// Placement of a light in the world: `world = translation + rotation * (scale * local)`.
///
/// `rotation` is normalised before use. `scale` is positive and the same in all directions, so that circles stay
/// circles.
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
    /// Returns the rotation from light-local to world axes as a matrix.
    pub fn world_from_local_axes(&self) -> DMat3 {
        DMat3::from_quat(self.rotation.normalize())
    }

    /// Converts a light-local position to world space.
    pub fn world_from_local(&self, local: DVec3) -> DVec3 {
        self.translation + self.rotation.normalize() * (local * self.scale)
    }
}

/// Orientation of the cross-section along the curve (light model, section 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameMode {
    /// No rotation about the tangent from one point of the curve to the next.
    #[default]
    RotationMinimizing,
    /// `w_hat` leans towards `up` at every point, as in the paper. It flips where the tangent meets `up`.
    Up,
}

/// Direction from which light arrives (light model, section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectionMode {
    /// Tangent of the centre plus the spread. It is continuous everywhere.
    #[default]
    Tube,
    /// Exact tangent of the curve of constant (v, w). It jumps at joints of a tapering tube.
    Path,
}

/// Behaviour of a light past its last control point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EndMode {
    /// Light ends.
    #[default]
    Cut,
    /// Light continues straight on. Position, radius, colour and intensity continue linearly with their end
    /// derivatives. Radius, colour and intensity stop at zero.
    Extend,
}

/// Decrease of irradiance with the length `s` of the light path, in world units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Decay {
    /// No decrease: the cinematic default.
    #[default]
    None,
    /// `1 / s`.
    Linear,
    /// `1 / s^2`, as a physical point source. Intensity is then in candela.
    InverseSquare,
}

/// Curve of the falloff across a light. [`crate::CrossFalloff`] has the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProfileCurve {
    /// S-curve without a visible edge at either end.
    #[default]
    Smooth,
    /// Linear in the distance from the axis.
    Linear,
    /// Power of the cosine's progress from the outer angle to the inner angle.
    Power,
    /// Power of the cosine, from the axis on, cut at the cone's angle.
    Cosine,
}

/// Outline of a cross-section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CrossSection {
    /// Circle of radius 1.
    #[default]
    Circle,
    /// Shape between a rectangle and an ellipse.
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

/// Control point of a BendyLight with its values, light-local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Control point of the centre curve.
    pub position: DVec3,
    /// Radius of the tube, 0 or more.
    pub radius: f64,
    pub color: DVec3,
    /// In candela with inverse-square decay.
    pub intensity: f64,
}

impl ControlPoint {
    /// Makes a white control point of intensity 1.
    pub fn new(position: DVec3, radius: f64) -> Self {
        Self { position, radius, color: DVec3::ONE, intensity: 1.0 }
    }
}

/// Shape of a light.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// Straight rays in a cone along local -Z from the origin, as in glTF and USD.
    Spot,
    /// Parallel rays from infinitely far away, along local -Z: the sun.
    Directional,
    /// Straight rays from the origin to all sides: a bulb.
    Omni,
    /// Rays along a quadratic B-spline (light model, section 1) with three control points or more. The first is the
    /// source and lies at the origin.
    Bendy(Vec<ControlPoint>),
}

/// Light as it is written down: its shape, and a value for each parameter of the shape.
///
/// The values may be invalid. [`crate::CheckedLight`] is a light that can be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    shape: LightShape,
    /// Values of the shape's parameters, in the order of the parameter table.
    values: Vec<Value>,
}

impl Light {
    /// Makes a light of a shape with all parameters at their defaults.
    pub fn new(shape: LightShape) -> Self {
        let owner = shape.owner();
        let default = |row: &&Parameter| row.default(owner).unwrap_or(Value::Absent);
        let values = parameters_of(owner).iter().map(default).collect();
        Self { shape, values }
    }

    pub fn spot() -> Self {
        Self::new(LightShape::Spot)
    }

    pub fn directional() -> Self {
        Self::new(LightShape::Directional)
    }

    pub fn omni() -> Self {
        Self::new(LightShape::Omni)
    }

    /// Makes a white BendyLight of intensity 1 from `points` and `radii`. The longer list is cut to the length of the
    /// shorter.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::Light;
    ///
    /// let light = Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z, DVec3::NEG_Z * 2.0], vec![0.1, 0.2, 0.3]);
    /// assert_eq!(light.points().len(), 3);
    /// assert_eq!((light.points()[2].radius, light.points()[2].intensity), (0.3, 1.0));
    /// ```
    pub fn bendy(points: Vec<DVec3>, radii: Vec<f64>) -> Self {
        let points = points.into_iter().zip(radii).map(|(position, radius)| ControlPoint::new(position, radius));
        Self::new(LightShape::Bendy(points.collect()))
    }

    pub fn shape(&self) -> &LightShape {
        &self.shape
    }

    /// Returns the kind of object in the parameter table that this light is.
    pub fn owner(&self) -> ParameterOwner {
        self.shape.owner()
    }

    /// Returns the control points; empty unless this is a BendyLight.
    pub fn points(&self) -> &[ControlPoint] {
        if let LightShape::Bendy(points) = &self.shape { points } else { &[] }
    }

    /// Returns the control points for changes; `None` unless this is a BendyLight.
    pub fn points_mut(&mut self) -> Option<&mut Vec<ControlPoint>> {
        if let LightShape::Bendy(points) = &mut self.shape { Some(points) } else { None }
    }

    /// Returns the shape's parameters with their values, in the order of the parameter table.
    pub fn values(&self) -> impl Iterator<Item = (&'static Parameter, &Value)> {
        parameters_of(self.owner()).iter().copied().zip(&self.values)
    }

    /// Returns the value of a parameter; `None` if the shape does not have it.
    pub fn value(&self, parameter: &Parameter) -> Option<&Value> {
        self.values().find(|(row, _)| *row == parameter).map(|(_, value)| value)
    }

    /// Returns the value of a parameter. If the shape does not have it, the default of the shapes that do.
    ///
    /// ```
    /// use light::parameters::{CONE_ANGLE, RANGE};
    /// use light::Light;
    ///
    /// let light = Light::spot().with(RANGE, Some(8.0));
    /// assert_eq!((light.get(RANGE), light.get(CONE_ANGLE)), (Some(8.0), 25.0));
    /// ```
    pub fn get<T: ValueType>(&self, key: ParameterKey<T>) -> T {
        let elsewhere = || key.owners.iter().find_map(|of| key.default(of.owner));
        let value = self.value(&key).and_then(T::from_value);
        value.or_else(|| T::from_value(&elsewhere()?)).expect("a key has the type of its row's values")
    }

    /// Sets a parameter and does not check the value; [`crate::CheckedLight::new`] checks the whole light. A parameter
    /// that the shape does not have is ignored.
    pub fn set(&mut self, Setting { parameter, value }: Setting) {
        let rows = parameters_of(self.owner());
        if let Some(index) = rows.iter().position(|row| *row == parameter) {
            self.values[index] = value;
        }
    }

    /// Returns the light with a parameter set.
    #[must_use]
    pub fn with<T: ValueType>(mut self, key: ParameterKey<T>, value: T) -> Self {
        self.set(key.to(value));
        self
    }

    /// Returns the light with the values of another light for the parameters that both shapes have.
    #[must_use]
    pub(crate) fn with_values_of(mut self, other: &Self) -> Self {
        for (parameter, value) in other.values() {
            self.set(Setting { parameter, value: value.clone() });
        }
        self
    }

    /// Returns the light in another placement.
    #[must_use]
    pub fn with_transform(self, transform: Transform) -> Self {
        let Transform { translation, rotation, scale } = transform;
        self.with(TRANSLATION, translation).with(ROTATION, rotation).with(SCALE, scale)
    }

    /// Returns the light with each control point changed. `change` gets its index.
    #[must_use]
    pub fn map_points(mut self, mut change: impl FnMut(usize, &mut ControlPoint)) -> Self {
        for (index, point) in self.points_mut().into_iter().flatten().enumerate() {
            change(index, point);
        }
        self
    }

    /// Returns the light with one control point changed, by its index.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::{Light, bend};
    ///
    /// let bent = bend(&Light::spot(), 3)?.map_point(4, |point| point.position.x += 1.0);
    /// assert_eq!(bent.points()[4].position, DVec3::new(1.0, 0.0, -1.0));
    /// # Ok::<(), light::LightError>(())
    /// ```
    #[must_use]
    pub fn map_point(mut self, index: usize, change: impl FnOnce(&mut ControlPoint)) -> Self {
        self.points_mut().and_then(|points| points.get_mut(index)).map(change);
        self
    }

    /// Returns the placement in the world.
    pub fn transform(&self) -> Transform {
        let (translation, rotation, scale) = (self.get(TRANSLATION), self.get(ROTATION), self.get(SCALE));
        Transform { translation, rotation, scale }
    }

    pub fn name(&self) -> &str {
        if let Some(Value::Text(name)) = self.value(&NAME) { name } else { "" }
    }
}

impl LightShape {
    /// Returns the kind of object in the parameter table that lights of this shape are.
    pub fn owner(&self) -> ParameterOwner {
        match self {
            Self::Spot => ParameterOwner::Spot,
            Self::Bendy(_) => ParameterOwner::Bendy,
            Self::Directional => ParameterOwner::Directional,
            Self::Omni => ParameterOwner::Omni,
        }
    }
}

/// Identifies a light for the life of its session. It is never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u64);

impl fmt::Display for LightId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
