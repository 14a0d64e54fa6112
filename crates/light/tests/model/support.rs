//! Helpers that several tests share.

use glam::DVec3;
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS};
use light::{CrossFalloff, Light, Tube, TubeRoot, bend, bend_with_length};

/// Returns the profile of a spotlight with a cone angle in degrees and a softness.
pub fn profile(cone_angle: f64, cone_softness: f64) -> CrossFalloff {
    CrossFalloff::of(&Light::spot().with(CONE_ANGLE, cone_angle).with(CONE_SOFTNESS, cone_softness))
}

/// Returns the tube of a valid BendyLight.
pub fn tube_of(light: &Light) -> Tube<f64> {
    Tube::new(light).expect("valid")
}

/// Returns the tube of a spotlight that is bent into segments.
pub fn bent_tube(spot: &Light, segments: usize) -> Tube<f64> {
    tube_of(&bend(spot, segments).expect("valid"))
}

/// Returns the tube of a spotlight that is bent into three segments of a length together.
pub fn long_tube(spot: &Light, length: f64) -> Tube<f64> {
    tube_of(&bend_with_length(spot, 3, length).expect("valid"))
}

/// Returns the root of a world position that counts; `None` outside the tube.
pub fn root_at(tube: &Tube<f64>, position: DVec3) -> Option<TubeRoot<f64>> {
    tube.nearest_root(tube.placement.tube_from_world(position))
}

/// Returns the irradiance at a world position; 0 outside the tube.
pub fn irradiance_at(tube: &Tube<f64>, position: DVec3) -> DVec3 {
    root_at(tube, position).map_or(DVec3::ZERO, |root| tube.irradiance(&root))
}
