//! Valid lights with extreme shapes.

use glam::{DQuat, DVec3};
use light::parameters::{DECAY, DIRECTION, END_MODE, FRAME, UP};
use light::{Decay, DirectionMode, EndMode, FrameMode, Light, LightError, Transform, Tube};
use proptest::prelude::*;
use serde::{Serialize, Serializer};

/// Serializes a light in the form of a light file.
pub fn as_file<S: Serializer>(light: &Light, serializer: S) -> Result<S::Ok, S::Error> {
    protocol::Light::from(light).serialize(serializer)
}

/// Generates vectors with each component in `[-1, 1]`.
pub fn unit_cube() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Generates rotations. They shrink to the identity.
pub fn rotation() -> impl Strategy<Value = DQuat> {
    (unit_cube(), 0.0..std::f64::consts::PI)
        .prop_map(|(axis, angle)| DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::Y), angle))
}

/// Generates numbers between `10^low` and `10^high`.
pub fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| 10_f64.powf(exponent))
}

/// Arrangement of control points.
#[derive(Clone, Copy, Debug)]
enum CurveFamily {
    /// Along -Z, displaced by up to this much.
    Wandering(f64),
    /// Back and forth, this far apart.
    Hairpin(f64),
    /// Around a circle, this many radians per step.
    Ring(f64),
    /// Wandering, with some adjacent points only this far apart.
    Clustered(f64),
    /// Wandering, with lengths of steps that differ by up to this many decades.
    Uneven(f64),
}

fn family() -> impl Strategy<Value = CurveFamily> {
    prop_oneof![
        (0.0..1.5).prop_map(CurveFamily::Wandering),
        Just(CurveFamily::Wandering(0.0)),
        decades(-9.0, -2.0).prop_map(CurveFamily::Wandering),
        decades(-4.0, 0.0).prop_map(CurveFamily::Hairpin),
        (0.2..2.5).prop_map(CurveFamily::Ring),
        decades(-9.0, -1.0).prop_map(CurveFamily::Clustered),
        Just(CurveFamily::Clustered(0.0)),
        (0.5..3.0).prop_map(CurveFamily::Uneven),
    ]
}

/// Returns the control points of a family. A knot is the random displacement of its point.
fn points(family: CurveFamily, knots: &[DVec3]) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::with_capacity(knots.len());
    for (i, &knot) in knots.iter().enumerate() {
        let along = i as f64;
        let before = points.last().copied().unwrap_or_default();
        points.push(match family {
            CurveFamily::Wandering(bend) => knot * bend - DVec3::Z * along,
            CurveFamily::Hairpin(width) => {
                DVec3::new(width * along, 0.0, if i.is_multiple_of(2) { 0.0 } else { -1.0 }) + knot * (0.3 * width)
            }
            CurveFamily::Ring(turn) => {
                let (sin, cos) = (turn * along).sin_cos();
                DVec3::new(sin, 0.3 * knot.y, cos)
            }
            CurveFamily::Clustered(gap) if i > 0 && knot.x > 0.0 => before + knot * gap,
            CurveFamily::Clustered(_) => before + knot * 0.6 - DVec3::Z,
            CurveFamily::Uneven(decades) => before + (knot * 0.6 - DVec3::Z) * 10_f64.powf(decades * knot.z),
        });
    }
    let source = points[0];
    // About one unit per step in every family. The factor is a power of two, so that coincident points still coincide.
    let length: f64 = points.windows(2).map(|leg| leg[1].distance(leg[0])).sum();
    let size = if length > 0.0 { ((points.len() - 1) as f64 / length).log2().round().exp2() } else { 1.0 };
    points.iter().map(|&point| (point - source) * size).collect()
}

/// True if no tangent comes near `up`: each tangent lies between two legs of the control polygon.
fn is_away_from_up(family: CurveFamily, knots: &[(DVec3, f64)], up: DVec3) -> bool {
    let strays: Vec<DVec3> = knots.iter().map(|knot| knot.0).collect();
    let legs = points(family, &strays);
    legs.windows(2).all(|leg| (leg[1] - leg[0]).normalize_or_zero().dot(up.normalize_or_zero()).abs() < 0.8)
}

/// Width of tubes that cannot fold, whatever their curve.
const THIN: f64 = 1e-12;

/// Makes a light through `points`. Its radii are shares of `width`, or of less where `R kappa` would exceed `fold`. An error
/// if its curve is invalid.
fn light_through(
    points: &[DVec3],
    shares: &[f64],
    width: f64,
    fold: f64,
    with_modes: impl Fn(Light) -> Light,
) -> Result<Light, LightError> {
    let with =
        |width: f64| with_modes(Light::bendy(points.to_vec(), shares.iter().map(|share| share * width).collect()));
    // `R kappa` is proportional to the radii, so that of a thin tube gives the largest radius.
    let thin = Tube::new(&with(THIN))?.r_kappa_max().into_iter().fold(0.0, f64::max);
    let widest = if thin > 0.0 { fold * THIN / thin } else { f64::INFINITY };
    Ok(with(width.min(widest)))
}

/// Limits of random lights.
#[derive(Clone, Copy, Debug)]
pub struct LightLimits {
    /// Maximum number of segments.
    pub segments: usize,
    /// Maximum of `R kappa`.
    pub fold: f64,
    /// True if the radius may be zero past the source.
    pub pinched: bool,
    /// True if the direction `up` of the "up" frame may come near the tangent, where the frame flips.
    pub flipping: bool,
}

/// Generates valid lights at the origin, with about one unit from control point to control point.
pub fn lights(wanted: LightLimits) -> impl Strategy<Value = Light> {
    let share = prop_oneof![4 => (0.1..1.0).boxed(), u32::from(wanted.pinched) => Just(0.0).boxed()];
    let width = prop_oneof![4 => (0.05..0.6).boxed(), 1 => decades(-4.0, 1.5).boxed()];
    let fold = prop_oneof![(0.3..0.9), Just(0.9), Just(0.99), Just(0.999_99)];
    let frame = prop_oneof![3 => Just(FrameMode::RotationMinimizing), 1 => Just(FrameMode::Up)];
    let direction = prop_oneof![Just(DirectionMode::Tube), Just(DirectionMode::Path)];
    let end_mode = prop_oneof![2 => Just(EndMode::Cut), 1 => Just(EndMode::Extend)];
    let decay = prop_oneof![Just(Decay::None), Just(Decay::Linear), Just(Decay::InverseSquare)];
    let up = prop_oneof![Just(DVec3::Y), Just(DVec3::NEG_Z), unit_cube()];
    let knots = prop::collection::vec((unit_cube(), share), 3..=wanted.segments + 2);
    let apex = prop_oneof![3 => Just(false), 1 => Just(true)];
    ((family(), knots, apex), (width, fold, up), (frame, direction, end_mode, decay)).prop_filter_map(
        "the curve has no direction",
        move |((family, mut knots, apex), (width, fold, up), (frame, direction, end_mode, decay))| {
            if apex {
                knots[0].1 = 0.0;
            }
            let fold = f64::min(fold, wanted.fold);
            let frame =
                if wanted.flipping || is_away_from_up(family, &knots, up) { frame } else { FrameMode::default() };
            let (displacements, shares): (Vec<DVec3>, Vec<f64>) = knots.into_iter().unzip();
            let with_modes = |light: Light| {
                let light = light.with(UP, up).with(FRAME, frame).with(DIRECTION, direction);
                light.with(END_MODE, end_mode).with(DECAY, decay)
            };
            let light = light_through(&points(family, &displacements), &shares, width, fold, with_modes);
            light.ok().filter(|light| Tube::new(light).is_ok())
        },
    )
}

/// Generates placements up to a million units from the world's origin, with scales from a ten-thousandth to ten
/// thousand.
pub fn placement() -> impl Strategy<Value = Transform> {
    let far = prop_oneof![Just(0.0), (0.0..10.0), Just(1e3), Just(1e6)];
    let scale = prop_oneof![Just(1.0).boxed(), decades(-4.0, 4.0).boxed()];
    (unit_cube(), far, rotation(), scale).prop_map(|(towards, far, rotation, scale)| Transform {
        translation: towards * far,
        rotation,
        scale,
    })
}
