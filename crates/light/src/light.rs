//! What an artist sets: the two lights of this crate, their placement and their options.
//!
//! These are plain data. [`crate::Tube::new`] checks a [`BendyLight`] and turns it into something that can
//! be evaluated; [`crate::spot`] evaluates a [`SpotLight`].

use std::fmt;

use glam::{DQuat, DVec3};

/// Where a light stands: `world = translation + rotation * (scale * local)`.
///
/// `rotation` need not be of exactly unit length; it is normalised before use. `scale` is positive and the
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
pub enum Frame {
    /// No rotation about the tangent from one point of the curve to the next.
    #[default]
    RotationMinimizing,
    /// `w_hat` leans towards `up` at every point, as the paper has it; flips where the tangent meets `up`.
    Up,
}

/// Which direction light arrives from (light model, section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
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

/// A spotlight whose light travels along a quadratic B-spline (light model, section 1).
///
/// `points`, `radii`, `colors` and `intensities` have one entry a control point, three or more, in
/// light-local space; `points[0]` is the source and lies at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct BendyLight {
    /// Placement in the world.
    pub transform: Transform,
    /// Control points of the centre curve.
    pub points: Vec<DVec3>,
    /// Control values of the tube's radius, zero or more.
    pub radii: Vec<f64>,
    /// Control values of the colour, linear RGB.
    pub colors: Vec<DVec3>,
    /// Control values of the intensity.
    pub intensities: Vec<f64>,
    /// Light-local direction that orients the cross-section at the source.
    pub up: DVec3,
    /// Nominal half angle in degrees, `0 < coneAngle < 90`: the angle the tube's edge stands for in the
    /// profile.
    pub cone_angle: f64,
    /// Share of the cone angle over which the profile falls from full to zero, 0 to 1.
    pub cone_softness: f64,
    /// Orientation of the cross-section along the curve.
    pub frame: Frame,
    /// Direction of arrival.
    pub direction: Direction,
    /// Past the last control point.
    pub end_mode: EndMode,
    /// Fall-off with distance.
    pub decay: Decay,
}

impl BendyLight {
    /// A white light of intensity 1 through `points` with `radii`, everything else at its default.
    pub fn new(points: Vec<DVec3>, radii: Vec<f64>) -> Self {
        let n = points.len();
        Self {
            transform: Transform::default(),
            points,
            radii,
            colors: vec![DVec3::ONE; n],
            intensities: vec![1.0; n],
            up: DVec3::Y,
            cone_angle: DEFAULT_CONE_ANGLE,
            cone_softness: DEFAULT_CONE_SOFTNESS,
            frame: Frame::default(),
            direction: Direction::default(),
            end_mode: EndMode::default(),
            decay: Decay::default(),
        }
    }
}

/// Half angle, in degrees, of a light that does not say.
pub const DEFAULT_CONE_ANGLE: f64 = 25.0;
/// Softness of a light that does not say.
pub const DEFAULT_CONE_SOFTNESS: f64 = 0.2;

/// A straight spotlight: shines along its local -Z from its origin, as in glTF and USD.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotLight {
    /// Placement in the world. The scale only matters to a light bent from this one.
    pub transform: Transform,
    /// Linear RGB.
    pub color: DVec3,
    /// Intensity; candela with inverse-square decay.
    pub intensity: f64,
    /// Half angle in degrees, `0 < coneAngle < 90`.
    pub cone_angle: f64,
    /// Share of the cone angle over which the profile falls from full to zero, 0 to 1.
    pub cone_softness: f64,
    /// World distance along the axis at which the light ends; endless where `None`.
    pub range: Option<f64>,
    /// Fall-off with distance.
    pub decay: Decay,
}

impl Default for SpotLight {
    fn default() -> Self {
        Self {
            transform: Transform::default(),
            color: DVec3::ONE,
            intensity: 1.0,
            cone_angle: DEFAULT_CONE_ANGLE,
            cone_softness: DEFAULT_CONE_SOFTNESS,
            range: None,
            decay: Decay::InverseSquare,
        }
    }
}

/// A light with the name people know it by.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name for people and for `--light`.
    pub name: String,
    /// Which light it is.
    pub kind: LightKind,
}

/// The closed set of lights.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Light along a spline.
    Bendy(BendyLight),
    /// Light along straight lines.
    Spot(SpotLight),
}

/// Identifies a light for as long as a session lives. Never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u64);

impl fmt::Display for LightId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
