//! Comparison of the picture before and after a drag, by the rays of the reference alone.

use drag::Feature;
use glam::DVec2;
use light::CheckedLight;
use reference::{LinkedNodes, ReferenceLight, ShadedPoint};
use scene::View;

use super::stage::TrialScene;
use super::trial::Trial;

/// Number of compared points across and down the picture.
const GRID: [u32; 2] = [40, 22];

/// Brightness at which a point counts as lit, as a share of the brightest one's.
const LIT_SHARE: f64 = 0.1;

/// Share of its brightness that a point keeps, and that a feature has where it was dragged.
const KEPT_SHARE: f64 = 0.5;

/// Change of a point's brightness that can be seen, as a share of a bright point's: nine in ten lit points are darker.
const VISIBLE_CHANGE: f64 = 0.02;

/// Least number of lit points from which a share is taken.
const MIN_POINTS: usize = 10;

/// Change of the picture by a drag.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureChange {
    /// True if the feature can be seen at the cursor: at least half as bright there as where it was taken, and lit or in
    /// shadow as before. `None` if it could not be seen where it was taken.
    pub is_seen: Option<bool>,
    /// Share of the lit points that keep half of their brightness, without those in the shadow of the moved caster.
    /// `None` if the light reaches too few points.
    pub kept: Option<f64>,
    /// Share of all points whose light changes visibly.
    pub changed: f64,
}

/// Surface points in a grid over the picture.
pub(super) struct PictureGrid<'a> {
    stage: &'a TrialScene,
    points: Vec<ShadedPoint>,
}

/// Light at a surface point.
#[derive(Clone, Copy)]
struct Arrival {
    /// Irradiance of the surface without shadows.
    brightness: f64,
    is_visible: bool,
}

/// Returns the brightness of a bright point.
fn bright_point(arrivals: &[Option<Arrival>]) -> f64 {
    let brightness = arrivals.iter().flatten().map(|at| at.visible_brightness());
    let mut lit: Vec<f64> = brightness.filter(|brightness| *brightness > 0.0).collect();
    lit.sort_by(f64::total_cmp);
    lit.get(lit.len() * 9 / 10).copied().unwrap_or(1.0)
}

impl Arrival {
    fn visible_brightness(self) -> f64 {
        if self.is_visible { self.brightness } else { 0.0 }
    }
}

impl<'a> PictureGrid<'a> {
    pub fn new(stage: &'a TrialScene) -> Self {
        let cell = stage.size() / DVec2::new(f64::from(GRID[0]), f64::from(GRID[1]));
        let pixels = (0..GRID[0] * GRID[1]).map(|k| {
            let [column, row] = [k % GRID[0], k / GRID[0]].map(f64::from);
            DVec2::new(column + 0.5, row + 0.5) * cell
        });
        let view = View::beauty(stage.view.camera.clone(), stage.view.size);
        let points = pixels.filter_map(|pixel| stage.reference.surface(&view, pixel)).collect();
        Self { stage, points }
    }

    /// Compares the picture after a drag to that before it.
    pub fn change(&self, trial: &Trial, moved: &CheckedLight) -> PictureChange {
        let [before, after] = [&trial.light, moved].map(|light| self.arrivals(light));
        let brightest = before.iter().flatten().map(|at| at.visible_brightness()).fold(0.0, f64::max);
        let bright = bright_point(&before);
        let (mut lit, mut kept, mut changed) = (0, 0, 0);
        for ((was, is), surface) in before.iter().zip(&after).zip(&self.points) {
            let was = was.map_or(0.0, Arrival::visible_brightness);
            let brightness = is.map_or(0.0, Arrival::visible_brightness);
            changed += usize::from((brightness - was).abs() > VISIBLE_CHANGE * bright);
            if was <= LIT_SHARE * brightest
                || is.is_some_and(|is| !is.is_visible) && self.is_moved_shadow(trial, moved, surface)
            {
                continue;
            }
            lit += 1;
            kept += usize::from(brightness >= KEPT_SHARE * was);
        }
        PictureChange {
            is_seen: self.is_seen(trial, moved, brightest),
            kept: (lit >= MIN_POINTS).then(|| kept as f64 / lit as f64),
            changed: changed as f64 / f64::from(GRID[0] * GRID[1]),
        }
    }

    fn is_seen(&self, trial: &Trial, moved: &CheckedLight, brightest: f64) -> Option<bool> {
        let at = |light: &CheckedLight, pixel| self.arrival(&ReferenceLight::new(light), &self.stage.surface(pixel)?);
        let was = at(&trial.light, trial.drag.from)?;
        let is_shadow = trial.kind.feature == Feature::Shadow;
        if was.is_visible == is_shadow || was.brightness < 0.5 * LIT_SHARE * brightest {
            return None;
        }
        let is = at(moved, trial.drag.to);
        Some(is.is_some_and(|is| is.is_visible != is_shadow && is.brightness >= KEPT_SHARE * was.brightness))
    }

    fn arrivals(&self, light: &CheckedLight) -> Vec<Option<Arrival>> {
        let light = ReferenceLight::new(light);
        self.points.iter().map(|surface| self.arrival(&light, surface)).collect()
    }

    fn arrival(&self, light: &ReferenceLight, surface: &ShadedPoint) -> Option<Arrival> {
        let sample = self.stage.reference.sample(light, surface)?;
        let cosine = surface.normal.dot(sample.coords.direction).max(0.0);
        Some(Arrival { brightness: sample.irradiance.max_element() * cosine, is_visible: sample.is_visible })
    }

    /// True if the node that casts the dragged shadow shadows the surface.
    fn is_moved_shadow(&self, trial: &Trial, moved: &CheckedLight, surface: &ShadedPoint) -> bool {
        let (reference, origin) = (&self.stage.reference, self.stage.origin());
        let caster = |light: &CheckedLight, position| {
            let tube = light.tube()?;
            let coords = tube.locate(position).point?;
            reference.occluding_node(tube, &LinkedNodes::default(), &coords, position)
        };
        let Some(from) = self.stage.surface(trial.drag.from).filter(|_| trial.pivot_in_scene.is_some()) else {
            return false;
        };
        let dragged = caster(&trial.light, from.position + origin);
        dragged.is_some() && caster(moved, surface.position + origin) == dragged
    }
}
