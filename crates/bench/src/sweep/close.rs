//! Close looks at where two surfaces meet: what a shadow map's tolerances hide is as narrow as its texels.

use fastrand::Rng;
use glam::{DVec2, DVec3};
use reference::{Reference, ReferenceLight, ShadedPoint};
use scene::{Camera, Projection, View};

use super::stage::camera;

/// Pixels tried for a place where surfaces meet.
const TRIES: usize = 400;
/// Pixels between two looks of which one may be on either surface.
const APART: f64 = 3.0;
/// Halvings of that.
const HALVINGS: u32 = 24;
/// Normals of surfaces that meet differ by so much: 30 degrees.
const SAME_COSINE: f64 = 0.866;
/// Texels that a pixel is wide, at least and at most.
const TEXELS_A_PIXEL: [f64; 2] = [0.3, 1.2];
/// Light arrives within so many texels of the place, in one of so many directions.
const LIT_WITHIN: f64 = 10.0;
const DIRECTIONS: u32 = 8;

/// A place where surfaces meet at a shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowCorner {
    /// World position.
    target: DVec3,
    /// Unit vector from there to where it was seen from: nothing is in the way.
    to_eye: DVec3,
    /// World units from which a pixel is about as wide as a texel, and from which it was seen.
    distance: f64,
    farthest: f64,
    /// Vertical field of view in radians.
    yfov: f64,
}

impl ShadowCorner {
    /// One that looks at it from so many times the distance, but from nowhere that something may be in the way.
    pub fn camera(&self, times: f64) -> Camera {
        let distance = (self.distance * times).min(self.farthest);
        camera(self.target + self.to_eye * distance, self.target, self.yfov)
    }
}

/// A random place that `view` sees, where surfaces meet at a shadow whose texels are `texel` world units wide. `None` where none
/// is found.
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

/// Whether light arrives on a surface's plane around a place, and somewhere there it does not.
fn is_near_a_shadow(
    reference: &Reference,
    source: &ReferenceLight,
    surface: &ShadedPoint,
    texel: f64,
) -> bool {
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

/// Two surfaces that meet between two pixels and face each other there: each lies before the other's plane.
fn inner_corner(reference: &Reference, view: &View, [mut a, mut b]: [DVec2; 2]) -> Option<[ShadedPoint; 2]> {
    let (mut here, mut there) = (reference.surface(view, a)?, reference.surface(view, b)?);
    let is_same = |one: &ShadedPoint, other: &ShadedPoint| {
        one.geometric_normal.dot(other.geometric_normal) > SAME_COSINE
    };
    let way = there.position - here.position;
    let faces = here.geometric_normal.dot(way) > 0.0 && there.geometric_normal.dot(way) < 0.0;
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
