//! Pixels of a picture by which drags measure how much of it they change.

use glam::DVec2;
use light::CheckedLight;
use raycast::{Bvh, SeenPoint};

use crate::occlusion::{Occlusion, seen_at};
use crate::picture_metric::low_discrepancy;
use crate::point_in_light::SceneLight;
use crate::request::Viewport;
use crate::work::WorkBudget;

/// Number of pixels. The measured share of changed pixels has a standard error of at most 0.03.
const PIXELS: u32 = 256;

/// Number of lit pixels, and of pixels among which they are. A light may illuminate little of a picture.
const LIT_PIXELS: usize = 128;
const CANDIDATES: u32 = 512;

/// Irradiance of a lit pixel, as a share of a bright pixel's.
const LIT: f64 = 0.1;

/// Change of a pixel's light that counts, as a share of a bright pixel's.
const VISIBLE_CHANGE: f64 = 0.02;

/// Pixels, evenly spread over a picture, with their light from one light.
pub(crate) struct PictureSample<'a> {
    bvh: &'a Bvh,
    work: &'a WorkBudget<'a>,
    /// Surfaces that the pixels show: those of [`PIXELS`], then further lit ones.
    seen: Vec<SeenPoint>,
    /// Number of the first.
    even: usize,
    /// Irradiance of each surface at the start of the drag.
    before: Vec<f64>,
    /// Irradiance of a bright surface.
    bright: f64,
}

impl<'a> PictureSample<'a> {
    /// Measures `light` in a picture.
    pub fn new(bvh: &'a Bvh, view: &Viewport, light: &CheckedLight, work: &'a WorkBudget<'a>) -> Self {
        let size = DVec2::from(view.size.map(f64::from));
        let pixels = (0..PIXELS).map(|number| low_discrepancy(number) * size);
        let seen: Vec<SeenPoint> = pixels.filter_map(|pixel| seen_at(bvh, view, pixel, work)).collect();
        let mut sample = Self { bvh, work, even: seen.len(), seen, before: Vec::new(), bright: 1.0 };
        sample.before = sample.irradiances(std::slice::from_ref(light));
        let mut lit: Vec<f64> = sample.before.iter().copied().filter(|irradiance| *irradiance > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        sample.bright = lit.get(lit.len() * 9 / 10).copied().unwrap_or(1.0);
        sample
    }

    /// Adds pixels that `light`, that at the start of the drag, illuminates.
    pub fn add_lit_pixels(&mut self, view: &Viewport, light: &CheckedLight) {
        let size = DVec2::from(view.size.map(f64::from));
        let occlusion = Occlusion::new(self.bvh, light, self.work);
        let mut count = self.lit().count();
        for number in PIXELS..CANDIDATES {
            if count == LIT_PIXELS {
                return;
            }
            let pixel = low_discrepancy(number) * size;
            let Some(seen) = seen_at(self.bvh, view, pixel, self.work) else { continue };
            let origin = self.bvh.posed.origin_in_world;
            let placed = SceneLight::new(light.rays(), origin, seen.position, self.work);
            let irradiance =
                irradiance(&occlusion, &placed, &seen).filter(|irradiance| *irradiance > LIT * self.bright);
            if let Some(irradiance) = irradiance {
                self.seen.push(seen);
                self.before.push(irradiance);
                count += 1;
            }
        }
    }

    /// Returns the indices of lit pixels.
    fn lit(&self) -> impl Iterator<Item = usize> {
        (0..self.seen.len()).filter(|index| self.before[*index] > LIT * self.bright)
    }

    /// Computes the irradiance of each pixel's surface from `lights` together.
    pub fn irradiances(&self, lights: &[CheckedLight]) -> Vec<f64> {
        let mut all = vec![0.0; self.seen.len()];
        for light in lights {
            let occlusion = Occlusion::new(self.bvh, light, self.work);
            let origin = self.bvh.posed.origin_in_world;
            for (sum, seen) in all.iter_mut().zip(&self.seen) {
                let placed = SceneLight::new(light.rays(), origin, seen.position, self.work);
                *sum += irradiance(&occlusion, &placed, seen).unwrap_or(0.0);
            }
        }
        all
    }

    /// Returns the share of the picture's pixels whose light differs visibly from that at the start of the drag. `None`
    /// if the budget is spent, since rays that it cut short meet nothing.
    pub fn changed_share(&self, after: &[f64]) -> Option<f64> {
        let even = after.iter().zip(&self.before).take(self.even);
        let changed = even.filter(|(after, before)| self.differ(**after, **before));
        (!self.work.is_exhausted()).then(|| changed.count() as f64 / f64::from(PIXELS))
    }

    /// Returns the mean relative change of the lit pixels, from 0 to 1 where no light arrives any more. Pixels in the
    /// shadow of `moved_caster` do not count. `light` is the light after the drag and `after` the result of
    /// [`Self::irradiances`].
    pub fn change_of_lit(&self, light: &CheckedLight, after: &[f64], moved_caster: Option<usize>) -> f64 {
        let occlusion = Occlusion::new(self.bvh, light, self.work);
        let (mut sum, mut count) = (0.0, 0);
        for index in self.lit() {
            let (was, is) = (self.before[index], after[index]);
            let seen = &self.seen[index];
            let at = SeenPoint { position: seen.shadow_position(), ..*seen };
            if is == 0.0 && moved_caster.is_some() && occlusion.caster_of(light, &at) == moved_caster {
                continue;
            }
            sum += 1.0 - was.min(is) / was.max(is);
            count += 1;
        }
        if count == 0 { 0.0 } else { sum / f64::from(count) }
    }

    /// True if two pictures cannot be told apart.
    pub fn are_alike(&self, a: &[f64], b: &[f64]) -> bool {
        !a.iter().zip(b).any(|(a, b)| self.differ(*a, *b))
    }

    fn differ(&self, a: f64, b: f64) -> bool {
        (a - b).abs() > VISIBLE_CHANGE * self.bright
    }
}

/// Computes the irradiance of a surface. `None` if no light arrives.
fn irradiance(occlusion: &Occlusion, placed: &SceneLight, seen: &SeenPoint) -> Option<f64> {
    if !occlusion.is_node_lit(seen.node) {
        return None;
    }
    let coords = placed.locate(seen.position, None).filter(|coords| placed.contains(coords))?;
    let cosine = seen.normal.dot(coords.to_light);
    if cosine <= 0.0 || occlusion.is_unlit(placed, &coords, seen) {
        return None;
    }
    Some(placed.locate_with_edge_irradiance(seen.position, coords.t)?.1 * cosine)
}
