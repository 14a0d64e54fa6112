//! Selects stable pixels: those near which nothing changes in the reference, so that their shadow is certain.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use reference::{LightSample, Reference, ReferenceLight, ShadedPoint};
use scene::View;

/// Radius in texels around a pixel within which the reference must be constant for the pixel to be judged. A filter of
/// 2 x 2 texels reaches half a texel to each side, and a drawn edge may be displaced by another half.
const STABLE_TEXELS: f64 = 1.5;
/// Number of tested directions, and the share of that radius at which they are tested. The tip of a shadow is detected
/// between them if it opens by 15 degrees.
const RINGS: [(u32, f64); 2] = [(24, 1.0), (12, 0.5)];
/// Number of directions and share of the radius for a second test of a pixel that seems to be wrong. It detects tips of
/// shadows that open by one degree.
const CLOSE_RINGS: [(u32, f64); 5] = [(360, 1.0), (180, 0.8), (180, 0.6), (90, 0.4), (90, 0.2)];
/// Distance in pixels within which a rasterizer may see another surface than the reference, because it snaps corners to
/// 1/256 pixel.
const RASTER_SNAP_PX: f64 = 0.02;
/// Normals are packed to 2 x 16 bits: if light is this close to perpendicular to a normal, the picture may have it on
/// the other side.
const NORMAL_QUANTUM: f64 = 1.0 / 16384.0;

/// A pixel that is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct StablePixel {
    pub pixel: usize,
    /// `None` outside of the light.
    pub is_lit: Option<bool>,
    pub surface: ShadedPoint,
}

/// Number of pixels of a view that see a surface, and the stable ones of them.
#[derive(Clone, Debug)]
pub(super) struct JudgedView {
    pub surfaces: usize,
    pub stable: Vec<StablePixel>,
}

/// Returns the share of stable pixels among pixels with a surface; 1 if there are none.
pub(super) fn stable_share(stable: usize, surfaces: usize) -> f64 {
    if surfaces == 0 { 1.0 } else { stable as f64 / surfaces as f64 }
}

/// Finds the stable pixels of a view under a light whose shadow map has texels of at most `texel` world units across
/// the light at a surface.
pub(super) fn judge(
    reference: &Reference,
    source: &ReferenceLight,
    view: &View,
    texel: impl Fn(&ShadedPoint) -> f64 + Sync,
) -> JudgedView {
    let (width, height) = (view.width as usize, view.height as usize);
    let pixels = (0..width * height).into_par_iter().filter_map(|pixel| {
        let centre = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
        let surface = reference.surface(view, centre)?;
        let is_stable = is_one_surface(reference, view, centre, &surface)
            && has_no_coincident_surface(reference, &surface)
            && is_stable(reference, source, &surface, texel(&surface), &RINGS);
        Some(is_stable.then(|| StablePixel { pixel, is_lit: is_lit(reference, source, &surface), surface }))
    });
    let pixels: Vec<Option<StablePixel>> = pixels.collect();
    JudgedView { surfaces: pixels.len(), stable: pixels.into_iter().flatten().collect() }
}

/// True if a pixel that seems to be wrong is still stable when it is tested at far more points.
pub(super) fn is_surely_stable(
    reference: &Reference,
    source: &ReferenceLight,
    stable: &StablePixel,
    texel: f64,
) -> bool {
    is_stable(reference, source, &stable.surface, texel, &CLOSE_RINGS)
}

/// True if light arrives; `None` outside of the light.
fn is_lit(reference: &Reference, source: &ReferenceLight, surface: &ShadedPoint) -> Option<bool> {
    reference.sample(source, surface).map(|sample| sample.is_visible)
}

/// True if a rasterizer sees the same triangle at the pixel, with any rounding.
fn is_one_surface(reference: &Reference, view: &View, centre: DVec2, surface: &ShadedPoint) -> bool {
    [(RASTER_SNAP_PX, 0.0), (-RASTER_SNAP_PX, 0.0), (0.0, RASTER_SNAP_PX), (0.0, -RASTER_SNAP_PX)].into_iter().all(
        |(x, y)| {
            reference.surface(view, centre + DVec2::new(x, y)).is_some_and(|beside| beside.triangle == surface.triangle)
        },
    )
}

/// True if no other surface coincides within the precision of f32: a few ulps of positions of the scene's size and of
/// the distance to the camera, divided by the cosine between view ray and surface.
fn has_no_coincident_surface(reference: &Reference, surface: &ShadedPoint) -> bool {
    let cosine = surface.geometric_normal.dot(surface.to_eye).abs().max(1e-3);
    let size = reference.bvh.posed.half_extent.length() + surface.depth;
    let rounding = 2_f64.powi(-20) * size / cosine;
    let is_other = |triangle: usize| triangle != surface.triangle;
    let around = [-rounding, rounding];
    reference.bvh.first_hit(surface.position, -surface.to_eye, around, |hit| is_other(hit.triangle)).is_none()
}

/// True if the reference has the same visibility on the surface's plane around the point, as far as texels reach on it:
/// a step across the light is longer on the plane if the light grazes it.
fn is_stable(
    reference: &Reference,
    source: &ReferenceLight,
    surface: &ShadedPoint,
    texel: f64,
    rings: &[(u32, f64)],
) -> bool {
    let here = reference.sample(source, surface);
    let towards = here.map_or(surface.geometric_normal, |sample| sample.along_path);
    if surface.normal.dot(towards).abs() < NORMAL_QUANTUM
        || surface.geometric_normal.dot(towards).abs() < NORMAL_QUANTUM
    {
        return false;
    }
    // A surface that faces the light path but not the shading direction is dark with a shadow and without.
    let is_dark = |sample: LightSample| surface.normal.dot(sample.coords.direction) <= 0.0;
    if surface.normal.dot(towards) > 0.0 && here.is_some_and(is_dark) {
        return false;
    }
    let is_lit_here = here.is_some_and(|sample| sample.is_visible);
    let (x, y) = towards.any_orthonormal_pair();
    let cosine = surface.geometric_normal.dot(towards);
    let places = rings.iter().flat_map(|&(count, far)| (0..count).map(move |k| (k, count, far)));
    let mut steps = places.map(|(k, count, far)| {
        let (sin, cos) = (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        let across = (x * cos + y * sin) * (far * STABLE_TEXELS * texel);
        across - towards * (surface.geometric_normal.dot(across) / cosine)
    });
    let is_same = |step: DVec3| {
        let mut beside = *surface;
        beside.seen.position += step;
        is_lit(reference, source, &beside).unwrap_or(false) == is_lit_here
    };
    steps.all(is_same)
}
