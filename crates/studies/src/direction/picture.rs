//! The laws in a picture: what each shades, and where its terminator is not the path's.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use light::{Root, Tube};
use rayon::prelude::*;
use reference::{Reference, Source, Surface, reflected};
use scene::{Camera, Scene, View};
use serde::Serialize;

use super::grid::{degrees_between, worst_jump};
use super::law::{LAWS, Law};

/// What a law does to a picture.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct InPicture {
    /// How the direction was found.
    pub law: Law,
    /// Pixels within the light.
    pub pixels: usize,
    /// Share of them that the law shades as facing the light while light on its path meets the surface from behind, or the
    /// other way round.
    pub share_disagreeing: f64,
    /// How far past the path's terminator those are that the law shades as facing the light, degrees: median.
    pub past_terminator_p50_deg: f64,
    /// The largest.
    pub past_terminator_max_deg: f64,
    /// Largest jump of the direction at the light's joints, degrees.
    pub joint_jump_max_deg: f64,
}

/// A pixel's surface and its place in the light.
struct Lit {
    surface: Surface,
    root: Root<f64>,
    visible: bool,
}

/// Scene, light and camera, and every pixel's surface and place in the light.
pub struct Stage {
    tube: Tube<f64>,
    width: u32,
    height: u32,
    /// `None` where there is background or no light.
    pixels: Vec<Option<Lit>>,
    /// The fill everywhere.
    ambient: Vec<DVec3>,
}

impl Stage {
    /// Follows each pixel's ray and its light's path; `row_done` is called once a row.
    pub fn new(
        (scene, camera): (&Scene, Option<&Camera>),
        tube: &Tube<f64>,
        [width, height]: [u32; 2],
        row_done: impl Fn() + Sync,
    ) -> Self {
        let source = Source::Bendy(tube.clone());
        let posed = scene::pose(scene.clone());
        let reference = Reference::new(Arc::clone(&posed));
        let camera = camera
            .cloned()
            .unwrap_or_else(|| scene::framing_camera(&posed.reach(), f64::from(width) / f64::from(height)));
        let view = View::beauty(camera, [width, height]);
        let origin = posed.origin_in_world;
        let rows: Vec<Vec<(Option<Lit>, DVec3)>> = (0..height)
            .into_par_iter()
            .map(|y| {
                let pixel = |x| {
                    let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let Some(surface) = reference.surface(&view, at) else { return (None, DVec3::ZERO) };
                    let in_tube = tube.placement.tube_from_world(surface.position + origin);
                    let lit = tube.nearest_root(in_tube).map(|root| {
                        let sample = reference.sample(&source, &surface);
                        Lit { surface, root, visible: sample.is_some_and(|sample| sample.visible) }
                    });
                    (lit, reference.radiance(&[], 1.0, &surface))
                };
                let row = (0..width).map(pixel).collect();
                row_done();
                row
            })
            .collect();
        let (pixels, ambient) = rows.into_iter().flatten().unzip();
        Self { tube: tube.clone(), width, height, pixels, ambient }
    }

    fn to_light(&self, law: Law, root: &Root<f64>) -> DVec3 {
        self.tube.placement.rotation * law.direction(&self.tube, root)
    }

    /// What each law does.
    pub fn measure(&self) -> Vec<InPicture> {
        LAWS.map(|law| self.measure_law(law)).to_vec()
    }

    fn measure_law(&self, law: Law) -> InPicture {
        let mut disagreeing = 0;
        let mut past: Vec<f64> = Vec::new();
        for lit in self.pixels.iter().flatten() {
            let n = lit.surface.normal;
            let (by_law, by_path) =
                (n.dot(self.to_light(law, &lit.root)), n.dot(self.to_light(Law::Path, &lit.root)));
            disagreeing += usize::from((by_law > 0.0) != (by_path > 0.0));
            if by_law > 0.0 && by_path <= 0.0 {
                past.push(libm::asin(by_law.min(1.0)).to_degrees());
            }
        }
        past.sort_by(f64::total_cmp);
        let pixels = self.pixels.iter().flatten().count();
        let jumps = (1..self.tube.n).map(|joint| {
            let [before, after] = worst_jump(&self.tube, law, joint);
            degrees_between(before, after)
        });
        InPicture {
            law,
            pixels,
            share_disagreeing: disagreeing as f64 / pixels.max(1) as f64,
            past_terminator_p50_deg: past.get(past.len() / 2).copied().unwrap_or(0.0),
            past_terminator_max_deg: past.last().copied().unwrap_or(0.0),
            joint_jump_max_deg: jumps.fold(0.0, f64::max),
        }
    }

    /// The picture by one law, in sRGB.
    pub fn picture(&self, law: Law) -> RgbImage {
        let bytes = |index: usize| {
            let lit = self.pixels[index].as_ref().filter(|lit| lit.visible).map_or(DVec3::ZERO, |lit| {
                reflected(&lit.surface, self.to_light(law, &lit.root), [1.0; 2])
                    * self.tube.irradiance(&lit.root)
            });
            srgb(self.ambient[index] + lit)
        };
        RgbImage::from_fn(self.width, self.height, |x, y| Rgb(bytes((y * self.width + x) as usize)))
    }

    /// All laws, two beside each other and two below, in the order of [`LAWS`].
    pub fn panels(&self) -> RgbImage {
        const GAP: u32 = 4;
        let (width, height) = (2 * self.width + GAP, 2 * self.height + GAP);
        let mut panels = RgbImage::from_pixel(width, height, Rgb([255; 3]));
        for (k, law) in (0..).zip(LAWS) {
            let (x, y) = (k % 2 * (self.width + GAP), k / 2 * (self.height + GAP));
            image::imageops::replace(&mut panels, &self.picture(law), i64::from(x), i64::from(y));
        }
        panels
    }
}

/// Linear radiance as a screen shows it, cut off at white.
fn srgb(linear: DVec3) -> [u8; 3] {
    linear.clamp(DVec3::ZERO, DVec3::ONE).to_array().map(|x| {
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}
