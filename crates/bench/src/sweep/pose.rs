//! Random lights of each shape over a stage, with random orientation.

use fastrand::Rng;
use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, END_MODE, FRAME, HEIGHT, INTENSITY, RANGE, ROTATION, TRANSLATION, UP, WIDTH};
use light::{CheckedLight, EndMode, FrameMode, Light, ParameterOwner, Tube};

use super::stage::{SweepStage, direction};

/// Minimum and maximum elevation of directional lights in degrees.
const ELEVATION: [f64; 2] = [15.0, 89.0];
/// Largest `R kappa` of bent lights. Half of the lights have one of these, unless that would make them wider than long.
const TIGHT: [f64; 4] = [0.9, 0.97, 0.99, 0.999];
/// Minimum distance of sources from all surfaces, as a share of the scene's half diagonal. A map begins at a thousandth
/// of the distance from the source to the far end of the scene, which is at most twice the half diagonal; nearer
/// casters cast no shadow.
const CLEARANCE: f64 = 2e-3;
/// Radii of a tube that cannot fold, for any curve.
const THIN: f64 = 1e-9;

/// Makes a random light of a shape.
pub(super) fn random(shape: ParameterOwner, stage: &SweepStage, rng: &mut Rng) -> Light {
    match shape {
        ParameterOwner::Directional => sun(stage, rng),
        ParameterOwner::Omni => Light::omni()
            .with(TRANSLATION, clear_position(stage, rng))
            .with(ROTATION, turned(direction(rng), rng))
            .with(RANGE, (rng.u8(..4) == 0).then(|| stage.things_radius * (1.0 + 3.0 * rng.f64())))
            .with(INTENSITY, 4.0),
        ParameterOwner::Spot => {
            let source = clear_position(stage, rng);
            Light::spot()
                .with(TRANSLATION, source)
                .with(ROTATION, turned(aim(stage, rng) - source, rng))
                .with(CONE_ANGLE, 5.0 + 80.0 * rng.f64())
                .with(RANGE, (rng.u8(..4) == 0).then(|| stage.things_radius * (1.0 + 4.0 * rng.f64())))
                .with(INTENSITY, 4.0)
        }
        // Points and cameras are no lights.
        ParameterOwner::Bendy | ParameterOwner::Point | ParameterOwner::Camera => loop {
            let light = bent(stage, rng);
            if CheckedLight::new(light.clone()).is_ok() {
                return light;
            }
        },
    }
}

/// Returns the rotation that maps -Z to `towards`, with a random angle about it.
fn turned(towards: DVec3, rng: &mut Rng) -> DQuat {
    let about = DQuat::from_rotation_z(rng.f64() * std::f64::consts::TAU);
    DQuat::from_rotation_arc(DVec3::NEG_Z, towards.normalize_or(DVec3::NEG_Y)) * about
}

fn sun(stage: &SweepStage, rng: &mut Rng) -> Light {
    let [low, high] = ELEVATION;
    let (up, across) = (low + (high - low) * rng.f64()).to_radians().sin_cos();
    let (sin, cos) = (rng.f64() * std::f64::consts::TAU).sin_cos();
    let to_light = DVec3::new(across * cos, up, across * sin);
    let window = |rng: &mut Rng| (rng.u8(..4) == 0).then(|| stage.things_radius * (0.6 + 2.0 * rng.f64()));
    Light::directional()
        .with(TRANSLATION, stage.ground_in_world)
        .with(ROTATION, turned(-to_light, rng))
        .with(WIDTH, window(rng))
        .with(HEIGHT, window(rng))
}

/// Returns a random position of a source: log-uniform in its height over the floor, from a hundredth of the maximum,
/// and clear of surfaces.
fn clear_position(stage: &SweepStage, rng: &mut Rng) -> DVec3 {
    let aside = |rng: &mut Rng| stage.lights_half * (2.0 * rng.f64() - 1.0);
    loop {
        let height = stage.lights_height * 0.01_f64.powf(rng.f64());
        let position = stage.ground_in_world + DVec3::new(aside(rng), height, aside(rng));
        if stage.is_clear(position, CLEARANCE) {
            return position;
        }
    }
}

/// Returns a random position among the objects.
fn aim(stage: &SweepStage, rng: &mut Rng) -> DVec3 {
    let aside = |rng: &mut Rng| 0.8 * stage.things_radius * (2.0 * rng.f64() - 1.0);
    stage.ground_in_world + DVec3::new(aside(rng), 0.5 * stage.things_radius * rng.f64(), aside(rng))
}

/// Makes a light from a random position to the objects, bent in two directions, in a tube of random width that does not
/// fold.
fn bent(stage: &SweepStage, rng: &mut Rng) -> Light {
    let source = loop {
        let source = clear_position(stage, rng);
        if (source - stage.ground_in_world).y > 0.3 * stage.things_radius {
            break source;
        }
    };
    let axis = (aim(stage, rng) - source) * (1.1 + 0.6 * rng.f64());
    let length = axis.length();
    let (aside, over) = (direction(rng) * length, direction(rng) * length);
    let (bow, sway) = (0.5 * rng.f64(), 0.25 * rng.f64());
    let segments = rng.usize(1..=6);
    let at = |share: f64| {
        let angle = std::f64::consts::PI * share;
        axis * share + aside * (bow * angle.sin()) + over * (sway * (2.0 * angle).sin())
    };
    let points: Vec<DVec3> = (0..segments + 2).map(|k| at(k as f64 / (segments + 1) as f64)).collect();
    let (first, last) = (0.3 * rng.f64() * f64::from(rng.u8(..2)), 0.3 + 0.7 * rng.f64());
    let shares: Vec<f64> = (0..points.len())
        .map(|k| {
            let share = k as f64 / (points.len() - 1) as f64;
            (first + (last - first) * share) * (0.8 + 0.4 * rng.f64())
        })
        .collect();
    let (frame, end_mode) = (
        if rng.u8(..4) == 0 { FrameMode::Up } else { FrameMode::RotationMinimizing },
        if rng.bool() { EndMode::Cut } else { EndMode::Extend },
    );
    let up = direction(rng);
    let with = |width: f64| {
        Light::bendy(points.clone(), shares.iter().map(|share| share * width).collect())
            .with(TRANSLATION, source)
            .with(UP, up)
            .with(FRAME, frame)
            .with(END_MODE, end_mode)
    };
    // `R kappa` is proportional to the radii.
    let thin = Tube::new(&with(THIN)).map_or(0.0, |tube| tube.r_kappa_max().into_iter().fold(0.0, f64::max));
    let most = if rng.bool() { TIGHT[rng.usize(..TIGHT.len())] } else { 0.2 + 0.7 * rng.f64() };
    let widest = if thin > 0.0 { most * THIN / thin } else { f64::INFINITY };
    // Not wider than long: a light that opens wider is an omni light.
    with(widest.min(length))
}
