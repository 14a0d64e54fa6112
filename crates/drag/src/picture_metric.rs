//! Points of the picture by which a drag measures how much it changes the picture.

use glam::{DVec2, DVec3};
use raycast::SeenPoint;

use crate::occlusion::{Occlusion, seen_at};
use crate::point_in_light::SceneLight;
use crate::request::Viewport;

/// Number of pixels that are tried, and the number of points kept in the light and beside it.
const CANDIDATES: u32 = 1024;
const POINTS_IN_LIGHT: usize = 64;
const POINTS_BESIDE: usize = 16;

/// Largest distances from the light's axis, in radii, of points in the light and beside it.
const IN_LIGHT_RHO: f64 = 1.1;
const BESIDE_RHO: f64 = 4.0;

/// Brightness that counts as dark, as a share of the brightest point's. The logarithm of a brightness changes little
/// below it.
const DARK: f64 = 0.1;

/// Weights of a lit point, of a point that is dark or in a shadow, and of one in the dragged shadow itself.
const LIT_WEIGHT: f64 = 1.0;
const DARK_WEIGHT: f64 = 0.3;
const OWN_SHADOW_WEIGHT: f64 = 0.09;

/// Weight of a change of direction of one radian, relative to that of a change of brightness by a factor of e.
const DIRECTION_WEIGHT: f64 = 0.5;

/// Decrease of the logarithm of a lit point's brightness per radius beyond the light's edge, up to one radius, so that
/// the loss has a slope.
pub(crate) const EDGE_SLOPE: f64 = 3.0;

/// Share of their distance from the light's ends that points keep, and the most that they keep, in widths.
const ROOM_SHARE: f64 = 0.5;
const MAX_ROOM: f64 = 0.25;

/// Half of the range of rho, in radii, in which the edge fades out, and of the distance from an end, in widths.
const EDGE_FADE: f64 = 0.1;

/// Cosine below which shading is smoothed.
const COSINE_FADE: f64 = 0.05;

/// Visible surface points with their light at the start of a drag. By default there are none.
#[derive(Clone, Debug, Default)]
pub(crate) struct PictureMetric {
    points: Vec<MetricPoint>,
    /// Irradiance of a bright point.
    brightest: f64,
    /// Least distance of a point in the light from its ends at the start of the drag, in widths. `None` if the picture
    /// shows an end: a point across the light lies beyond it.
    start_distance_to_ends: Option<f64>,
}

/// Values of the metric in a light.
pub(crate) struct MetricValues {
    /// Values of `t` of the points.
    pub t: Vec<f64>,
    /// Room of the points that were in the light before its ends, in widths. At 0 the picture begins to show an end. `None`
    /// if it did at the start of the drag.
    pub room_before_ends: Option<f64>,
}

#[derive(Clone, Debug)]
struct MetricPoint {
    /// In scene space.
    position: DVec3,
    /// Unit normal towards the camera.
    normal: DVec3,
    /// `t` at the start of the drag.
    start_t: f64,
    was_in_light: bool,
    was_lit: bool,
    /// Square roots of the weights of the brightness and of the direction.
    brightness_weight: f64,
    direction_weight: f64,
    log_before: f64,
    to_light_before: DVec3,
}

impl PictureMetric {
    /// Selects the points. `moved_caster` is the node whose shadow is dragged.
    pub fn new(occlusion: &Occlusion, view: &Viewport, light: &SceneLight, moved_caster: Option<usize>) -> Self {
        let (bvh, work) = (occlusion.bvh, occlusion.work);
        let size = DVec2::from(view.size.map(f64::from));
        let mut metric = Self { points: Vec::new(), brightest: 1.0, start_distance_to_ends: Some(f64::INFINITY) };
        let (mut in_light, mut beside) = (0, 0);
        let mut brightness = Vec::new();
        for number in 0..CANDIDATES {
            if in_light == POINTS_IN_LIGHT && beside == POINTS_BESIDE {
                break;
            }
            let Some(seen) = seen_at(bvh, view, low_discrepancy(number) * size, work) else { continue };
            let Some(near) = light.nearest_t(seen.position) else { continue };
            let Some((coords, irradiance)) = light.locate_with_edge_irradiance(seen.position, near) else { continue };
            let rho = light.rho2(&coords).sqrt();
            let counted = if rho <= IN_LIGHT_RHO { &mut in_light } else { &mut beside };
            let most = if rho <= IN_LIGHT_RHO { POINTS_IN_LIGHT } else { POINTS_BESIDE };
            if rho > BESIDE_RHO || *counted == most || !occlusion.is_node_lit(seen.node) {
                continue;
            }
            *counted += 1;
            if rho <= 1.0 {
                let least = metric.start_distance_to_ends.map(|least| least.min(coords.distance_to_ends));
                metric.start_distance_to_ends = least.filter(|least| *least >= 0.0);
            }
            let reaches = light.contains(&coords) && seen.normal.dot(coords.to_light) > 0.0;
            let caster = if light.contains(&coords) { shadowing_node(occlusion, light, &seen, coords.t) } else { None };
            let (weight, direction_weight) = match caster {
                Some(node) if Some(node) == moved_caster => (OWN_SHADOW_WEIGHT, 0.0),
                None if reaches => (LIT_WEIGHT, DIRECTION_WEIGHT * LIT_WEIGHT),
                _ => (DARK_WEIGHT, DIRECTION_WEIGHT * DARK_WEIGHT),
            };
            let was_lit = reaches && caster.is_none();
            if was_lit {
                brightness.push(irradiance * seen.normal.dot(coords.to_light));
            }
            metric.points.push(MetricPoint {
                position: seen.position,
                normal: seen.normal,
                start_t: coords.t,
                was_in_light: light.contains(&coords),
                was_lit,
                brightness_weight: weight.sqrt(),
                direction_weight: direction_weight.sqrt(),
                log_before: 0.0,
                to_light_before: coords.to_light,
            });
        }
        brightness.sort_by(f64::total_cmp);
        metric.brightest = brightness.get(brightness.len() * 9 / 10).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        // A picture with few lit points counts as much as one with many.
        let factor = ((POINTS_IN_LIGHT + POINTS_BESIDE) as f64 / metric.points.len().max(1) as f64).sqrt();
        for point in &mut metric.points {
            point.brightness_weight *= factor;
            point.direction_weight *= factor;
            let before = point.log_brightness(light, metric.brightest, point.start_t);
            (point.log_before, point.to_light_before) =
                before.map_or((0.0, point.to_light_before), |before| (before.log, before.to_light));
        }
        metric
    }

    /// True if nothing is measured.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Returns the values of `t` of the points at the start of the drag.
    pub fn start_t(&self) -> Vec<f64> {
        self.points.iter().map(|point| point.start_t).collect()
    }

    /// Adds the change of each point's brightness and direction to `rows`: four numbers a point, with `weight` as a factor
    /// of all weights. `near` are the values of `t` to track.
    pub fn add_rows(&self, light: &SceneLight, near: &[f64], weight: f64, rows: &mut Vec<f64>) -> MetricValues {
        let factor = weight.sqrt();
        let mut distance_to_ends = f64::INFINITY;
        let changes = self.points.iter().zip(near).map(|(point, near)| {
            let brightness_weight = point.brightness_weight * factor;
            let Some(now) = point.log_brightness(light, self.brightest, *near) else {
                // A point behind the source receives no light.
                let log = libm::log(DARK) - EDGE_SLOPE;
                rows.extend([brightness_weight * (log - point.log_before), 0.0, 0.0, 0.0]);
                return *near;
            };
            rows.push(brightness_weight * (now.log - point.log_before));
            let turned = now.to_light - point.to_light_before;
            rows.extend((turned * point.direction_weight * factor).to_array());
            if point.was_in_light {
                distance_to_ends = distance_to_ends.min(now.distance_to_ends);
            }
            now.t
        });
        let t = changes.collect();
        // The picture reaches nearer to the ends than its points do.
        let least = self.start_distance_to_ends.map(|least| (ROOM_SHARE * least).min(MAX_ROOM));
        MetricValues { t, room_before_ends: least.map(|least| distance_to_ends.min(1.0) - least) }
    }
}

/// Brightness of a point, and where it lies in the light.
struct Brightness {
    log: f64,
    to_light: DVec3,
    t: f64,
    distance_to_ends: f64,
}

impl MetricPoint {
    /// Computes the logarithm of the point's brightness without shadows. It has slopes everywhere. `None` behind the
    /// source of a light without a tube.
    fn log_brightness(&self, light: &SceneLight, brightest: f64, near: f64) -> Option<Brightness> {
        let (coords, irradiance) = light.locate_with_edge_irradiance(self.position, near)?;
        let rho = light.rho2(&coords).sqrt();
        let cosine = self.normal.dot(coords.to_light);
        let facing = 0.5 * (cosine + (cosine * cosine + COSINE_FADE * COSINE_FADE).sqrt());
        let brightness =
            irradiance / brightest * facing * within_edge(rho - 1.0) * within_edge(-coords.distance_to_ends);
        let beyond = (rho - 1.0).clamp(0.0, 1.0) + (-coords.distance_to_ends).clamp(0.0, 1.0);
        let log = libm::log(brightness + DARK) - if self.was_lit { EDGE_SLOPE * beyond } else { 0.0 };
        Some(Brightness { log, to_light: coords.to_light, t: coords.t, distance_to_ends: coords.distance_to_ends })
    }
}

/// Returns 1 inside of an edge and 0 outside, with a smooth step between. `beyond` is the distance beyond the edge.
pub(crate) fn within_edge(beyond: f64) -> f64 {
    let s = ((EDGE_FADE - beyond) / (2.0 * EDGE_FADE)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Returns the node that shadows a surface point.
fn shadowing_node(occlusion: &Occlusion, light: &SceneLight, seen: &SeenPoint, t: f64) -> Option<usize> {
    let at = SeenPoint { position: seen.shadow_position(), ..*seen };
    let coords = light.locate(at.position, Some(t))?;
    occlusion.first_caster(light, &coords, &at).map(|caster| caster.node)
}

/// Returns a point of a sequence that fills the unit square evenly (the plastic number's R2 sequence, M. Roberts).
pub(crate) fn low_discrepancy(number: u32) -> DVec2 {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    (DVec2::splat(0.5) + STEP * f64::from(number)).fract()
}
