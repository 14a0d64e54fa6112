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

/// Change of a pixel's light that counts, as a share of a bright pixel's.
const VISIBLE_CHANGE: f64 = 0.02;

/// Pixels, evenly spread over a picture, with their light from one light.
pub(crate) struct PictureSample<'a> {
    bvh: &'a Bvh,
    work: &'a WorkBudget<'a>,
    /// Surfaces that the pixels show.
    seen: Vec<SeenPoint>,
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
        let mut sample = Self { bvh, work, seen, before: Vec::new(), bright: 1.0 };
        sample.before = sample.irradiances(std::slice::from_ref(light));
        let mut lit: Vec<f64> = sample.before.iter().copied().filter(|irradiance| *irradiance > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        sample.bright = lit.get(lit.len() * 9 / 10).copied().unwrap_or(1.0);
        sample
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
        let changed = after.iter().zip(&self.before).filter(|(after, before)| self.differ(**after, **before));
        (!self.work.is_exhausted()).then(|| changed.count() as f64 / f64::from(PIXELS))
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
