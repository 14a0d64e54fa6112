//! Finds close-up views of edges between two surfaces: errors from a shadow map's tolerances are as narrow as its
//! texels.

use fastrand::Rng;
use glam::{DVec2, DVec3};
use reference::{Reference, ReferenceLight, ShadedPoint};
use scene::{Camera, Projection, View};

use super::stage::look;

/// Number of pixels tried to find an edge between surfaces near a shadow.
const TRIES: usize = 400;
/// Distance in pixels between two points of the picture that may show different surfaces.
const APART: f64 = 3.0;
/// Number of times that this distance is halved to find the edge between the surfaces.
const HALVINGS: u32 = 24;
/// Cosine of the angle by which normals of different surfaces differ at least: 30 degrees.
const SAME_COSINE: f64 = 0.866;
/// Width of a pixel in texels, minimum and maximum.
const TEXELS_A_PIXEL: [f64; 2] = [0.3, 1.2];
/// Distance in texels from the edge within which light must arrive. The next constant is the number of directions in
/// which that is tested.
const LIT_WITHIN: f64 = 10.0;
const DIRECTIONS: u32 = 8;

/// A point on an edge between surfaces, near a shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowCorner {
    target: DVec3,
    /// Unit vector from the target to the camera that saw it. No surface lies between the two.
    to_eye: DVec3,
    /// Distances in world units: the one from which a pixel is about as wide as a texel, and the one from which the
    /// target was seen.
    distance: f64,
    farthest: f64,
    /// Vertical field of view in radians.
    yfov: f64,
}

impl ShadowCorner {
    /// Returns the camera that looks at the target from `times` the distance, but at most from as far as the line is
    /// known to be free.
    pub fn camera(&self, times: f64) -> Camera {
        let distance = (self.distance * times).min(self.farthest);
        look(self.target + self.to_eye * distance, self.target, self.yfov)
    }
}

/// Finds a random point that `view` sees on an edge between surfaces, near a shadow whose texels are `texel` world
/// units wide. `None` if none is found.
pub(super) fn find(
    reference: &Reference,
    source: &ReferenceLight,
    view: &View,
    texel: impl Fn(&ShadedPoint) -> f64,
    rng: &mut Rng,
) -> Option<ShadowCorner> {
    let Projection::Perspective { yfov, .. } = view.camera.projection else { return None };
    let size = DVec2::new(f64::from(view.width), f64::from(view.height));
    let corner = (0..TRIES).find_map(|_| {
        let pixel = size * DVec2::new(rng.f64(), rng.f64());
        let beside = pixel + APART * DVec2::from_angle(rng.f64() * std::f64::consts::TAU);
        let [here, there] = inner_corner(reference, view, [pixel, beside])?;
        let touches = here.position.distance(there.position) < texel(&here);
        (touches && is_near_a_shadow(reference, source, &here, texel(&here))).then_some(here)
    })?;
    let [least, most] = TEXELS_A_PIXEL;
    let pixel = texel(&corner) * (least + (most - least) * rng.f64());
    let distance = pixel * size.y / (2.0 * (yfov / 2.0).tan());
    let target = reference.bvh.posed.origin_in_world + corner.position;
    Some(ShadowCorner { target, to_eye: corner.to_eye, distance, farthest: corner.depth, yfov })
}

/// True if light arrives at some points of the surface's plane around `surface`, but not at all.
fn is_near_a_shadow(reference: &Reference, source: &ReferenceLight, surface: &ShadedPoint, texel: f64) -> bool {
    let (x, y) = surface.geometric_normal.any_orthonormal_pair();
    let is_lit = |k: u32| {
        let step = DVec2::from_angle(f64::from(k) / f64::from(DIRECTIONS) * std::f64::consts::TAU);
        let mut beside = *surface;
        beside.seen.position += (x * step.x + y * step.y) * (LIT_WITHIN * texel);
        reference.sample(source, &beside).is_some_and(|sample| sample.is_visible)
    };
    let lit = (0..DIRECTIONS).filter(|k| is_lit(*k)).count();
    0 < lit && lit < DIRECTIONS as usize
}

/// Finds two surfaces that meet between two pixels and face each other: each lies in front of the other's plane.
fn inner_corner(reference: &Reference, view: &View, [mut a, mut b]: [DVec2; 2]) -> Option<[ShadedPoint; 2]> {
    let (mut here, mut there) = (reference.surface(view, a)?, reference.surface(view, b)?);
    let is_same =
        |one: &ShadedPoint, other: &ShadedPoint| one.geometric_normal.dot(other.geometric_normal) > SAME_COSINE;
    let offset = there.position - here.position;
    let faces = here.geometric_normal.dot(offset) > 0.0 && there.geometric_normal.dot(offset) < 0.0;
    if is_same(&here, &there) || !faces {
        return None;
    }
    for _ in 0..HALVINGS {
        let between = (a + b) / 2.0;
        let surface = reference.surface(view, between)?;
        if is_same(&here, &surface) {
            (a, here) = (between, surface);
        } else {
            (b, there) = (between, surface);
        }
    }
    Some([here, there])
}
