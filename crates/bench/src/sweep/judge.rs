//! Pixels whose shadow the reference is sure of: nothing that it says of them changes nearby.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use reference::{LightSample, Reference, ReferenceLight, ShadedPoint};
use scene::View;

/// Texels within which the reference has to say the same. A filter of two by two texels reaches half of one to each side, and
/// what is drawn of an edge may be another half off.
const STABLE_TEXELS: f64 = 1.5;
/// In how many directions that is asked, and at what share of that distance: a shadow that ends in a tip is seen between them
/// where it opens by 15 degrees.
const RINGS: [(u32, f64); 2] = [(24, 1.0), (12, 0.5)];
/// The same of a pixel that is wrong: a tip is seen that opens by a degree.
const CLOSE_RINGS: [(u32, f64); 5] = [(360, 1.0), (180, 0.8), (180, 0.6), (90, 0.4), (90, 0.2)];
/// A rasteriser snaps corners to 1/256 pixel: within so much of a pixel it may see another surface.
const RASTER_SNAP_PX: f64 = 0.02;
/// Normals are packed to 2 x 16 bits: where light is as nearly square to one, the picture may have it on the other side.
const NORMAL_QUANTUM: f64 = 1.0 / 16384.0;

/// A pixel that is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct StablePixel {
    pub pixel: usize,
    /// `None` outside of the light.
    pub is_lit: Option<bool>,
    pub surface: ShadedPoint,
}

/// Pixels of a view that see a surface, and those of them that are calm.
#[derive(Clone, Debug)]
pub(super) struct JudgedView {
    pub surfaces: usize,
    pub stable: Vec<StablePixel>,
}

/// The share of pixels with a surface that are calm; 1 where there is none.
pub(super) fn stable_share(calm: usize, surfaces: usize) -> f64 {
    if surfaces == 0 { 1.0 } else { calm as f64 / surfaces as f64 }
}

/// Judges all pixels of a view under a light whose shadow map has texels of `texel` world units across the light at a
/// surface, at most.
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
        let is_calm = is_one_surface(reference, view, centre, &surface)
            && has_no_coincident_surface(reference, &surface)
            && is_stable(reference, source, &surface, texel(&surface), &RINGS);
        Some(is_calm.then(|| StablePixel { pixel, is_lit: is_lit(reference, source, &surface), surface }))
    });
    let pixels: Vec<Option<StablePixel>> = pixels.collect();
    JudgedView { surfaces: pixels.len(), stable: pixels.into_iter().flatten().collect() }
}

/// Whether a pixel stays calm where it is asked of far more places: to be asked of those that are wrong.
pub(super) fn is_surely_stable(
    reference: &Reference,
    source: &ReferenceLight,
    calm: &StablePixel,
    texel: f64,
) -> bool {
    is_stable(reference, source, &calm.surface, texel, &CLOSE_RINGS)
}

/// Whether light arrives; `None` outside of it.
fn is_lit(reference: &Reference, source: &ReferenceLight, surface: &ShadedPoint) -> Option<bool> {
    reference.sample(source, surface).map(|sample| sample.is_visible)
}

/// Whether a rasteriser sees the same triangle there, whatever it rounds.
fn is_one_surface(reference: &Reference, view: &View, centre: DVec2, surface: &ShadedPoint) -> bool {
    [(RASTER_SNAP_PX, 0.0), (-RASTER_SNAP_PX, 0.0), (0.0, RASTER_SNAP_PX), (0.0, -RASTER_SNAP_PX)]
        .into_iter()
        .all(|(x, y)| {
            reference
                .surface(view, centre + DVec2::new(x, y))
                .is_some_and(|beside| beside.triangle == surface.triangle)
        })
}

/// Whether no other surface lies in the same place, nearer than f32 can tell: a few ulps of positions of the scene's size and
/// of the way to the viewer, over the cosine between that and the surface.
fn has_no_coincident_surface(reference: &Reference, surface: &ShadedPoint) -> bool {
    let cosine = surface.geometric_normal.dot(surface.to_eye).abs().max(1e-3);
    let size = reference.bvh.posed.half_extent.length() + surface.depth;
    let rounding = 2_f64.powi(-20) * size / cosine;
    let is_other = |triangle: usize| triangle != surface.triangle;
    let around = [-rounding, rounding];
    reference.bvh.first_hit(surface.position, -surface.to_eye, around, |hit| is_other(hit.triangle)).is_none()
}

/// Whether the reference says the same of the surface's plane all around, as far as a map's texels reach on it: a step
/// across the light is longer on the plane where light grazes.
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
    // What faces the path that light arrives along, but not where it shades from, is dark with a shadow and without.
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
