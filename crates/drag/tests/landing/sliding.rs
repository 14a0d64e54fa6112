//! Control points that slide as far as the tube allows.

use std::fmt::Write as _;
use std::time::Instant;

use drag::{RadiusMode, Slide, slide_point};
use glam::DVec3;
use light::CheckedLight;

pub fn demo_light() -> CheckedLight {
    let demo = assets::demo("vases").expect("it is one of the demos");
    CheckedLight::new(demo.contents.lights[0].light().clone()).expect("valid")
}

/// Slides a control point of the light, and returns its new position too.
fn slid(light: &CheckedLight, point: usize, to: DVec3, radii: RadiusMode) -> (Slide, DVec3) {
    let slide = slide_point(light, point, to, radii).expect("a control point");
    let position = slide.light.light().points()[point].position;
    (slide, position)
}

fn at(light: &CheckedLight, point: usize, position: DVec3) -> Result<CheckedLight, light::LightError> {
    CheckedLight::new(light.light().clone().map_point(point, |point| point.position = position))
}

/// Returns 24 directions, spread over the sphere by the golden angle.
pub fn directions() -> impl Iterator<Item = DVec3> {
    (0..24).map(|k| {
        let (y, angle) = (1.0 - 2.0 * (f64::from(k) + 0.5) / 24.0, 2.399_963_229_728_653 * f64::from(k));
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * libm::cos(angle), y, r * libm::sin(angle))
    })
}

/// Computes the share of the distance to `to` that a control point covered.
pub fn covered_share(from: DVec3, now: DVec3, to: DVec3) -> f64 {
    1.0 - now.distance(to) / from.distance(to)
}

/// In 24 directions, each over a length of the light, a slide comes at least as near as a straight line to the limit,
/// and in most directions much nearer. With radii that follow it reaches the target.
#[test]
fn control_points_slide_along_the_fold() {
    let light = demo_light();
    let points = light.light().points();
    let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let mut sums = [0.0; 3];
    let mut table = String::new();
    for (point, control) in points.iter().enumerate().skip(1) {
        let from = control.position;
        for direction in directions() {
            let to = from + direction * length;
            // Baseline: the last valid point of the straight line.
            let (mut valid, mut folded) = (0.0, 1.0);
            for _ in 0..30 {
                let middle = f64::midpoint(valid, folded);
                let is_valid = at(&light, point, from.lerp(to, middle)).is_ok();
                if is_valid { valid = middle } else { folded = middle }
            }
            let (slide, kept) = slid(&light, point, to, RadiusMode::Keep);
            let (_, followed) = slid(&light, point, to, RadiusMode::Follow);
            let reaches = [valid, covered_share(from, kept, to), covered_share(from, followed, to)];
            writeln!(table, "{point} {direction:.2} {reaches:.3?} {:?}", slide.limit).expect("into text");
            assert_eq!(slide.limit.is_none(), slide.distance_left == 0.0);
            // The limit of a drag is 0.97 of the fold's.
            assert!(reaches[1] > 0.9 * reaches[0] - 0.02, "{table}");
            sums.iter_mut().zip(reaches).for_each(|(sum, reach)| *sum += reach);
        }
    }
    println!("{table}");
    let all = (24 * (points.len() - 1)) as f64;
    let means = sums.map(|sum| sum / all);
    println!("straight to the wall {:.3}, gliding {:.3}, radii follow {:.3}", means[0], means[1], means[2]);
    assert!(means[1] > means[0] && means[2] > 0.99, "{means:?}");
}

/// Within the limits the control point reaches its target to the last bit, and a light that comes back is the original.
#[test]
fn a_control_point_comes_back_from_a_limit() {
    let light = demo_light();
    let points = light.light().points();
    let near = points[2].position + DVec3::new(0.01, -0.02, 0.015);
    assert_eq!(slid(&light, 2, near, RadiusMode::Keep).0.light, at(&light, 2, near).expect("valid"));
    for radii in [RadiusMode::Keep, RadiusMode::Follow] {
        assert_eq!(slid(&light, 2, points[2].position, radii).0.light, light);
    }
    assert_eq!(slide_point(&light, 0, near, RadiusMode::Keep), None);
    assert_eq!(slide_point(&light, 99, near, RadiusMode::Keep), None);
    assert_eq!(slide_point(&light, 2, DVec3::NAN, RadiusMode::Keep), None);
}

/// On a circle of the cursor through the limit, in 500 steps, no step of the control point exceeds 20 of its median
/// steps, and all together are at most 8 times as long as the cursor's path.
#[test]
fn sliding_on_and_off_a_limit_is_smooth() {
    let light = demo_light();
    let from = light.light().points()[3].position;
    for radii in [RadiusMode::Keep, RadiusMode::Follow] {
        let positions: Vec<(DVec3, DVec3, bool)> = (0..=500)
            .map(|step| {
                let angle = std::f64::consts::TAU * f64::from(step) / 500.0;
                let to = from + DVec3::new(libm::sin(angle), 0.0, 1.0 - libm::cos(angle)) * 1.5;
                let (slide, position) = slid(&light, 3, to, radii);
                (to, position, slide.limit.is_some())
            })
            .collect();
        let mut steps: Vec<f64> = positions.windows(2).map(|pair| pair[0].1.distance(pair[1].1)).collect();
        let cursors: f64 = positions.windows(2).map(|pair| pair[0].0.distance(pair[1].0)).sum();
        let sum: f64 = steps.iter().sum();
        steps.sort_by(f64::total_cmp);
        let limited = positions.iter().filter(|position| position.2).count();
        println!("{radii:?}: {limited} limited, median {} largest {}, {sum} of {cursors}", steps[250], steps[499]);
        assert!(radii == RadiusMode::Follow || limited > 50);
        assert!(steps[499] < 20.0 * steps[250].max(1e-3 * cursors), "{:?}", &steps[480..]);
        assert!(sum < 8.0 * cursors);
    }
}

/// A slide at the limit takes less than 600 times as long as preparing the light, so a dragged control point does not
/// slow down a picture at 60 frames a second. It took 960 times as long with a whole tube built at each evaluation.
#[test]
fn sliding_is_fast() {
    let light = demo_light();
    let from = light.light().points()[3].position;
    let fastest = |what: &dyn Fn()| {
        let times = (0..5).map(|_| {
            let began = Instant::now();
            what();
            began.elapsed().as_secs_f64()
        });
        times.fold(f64::INFINITY, f64::min)
    };
    let prepared = fastest(&|| {
        for _ in 0..100 {
            CheckedLight::new(light.light().clone()).expect("valid");
        }
    }) / 100.0;
    let mut worst = 0.0_f64;
    for direction in directions() {
        let to = from + direction * 1.5;
        let slid = fastest(&|| {
            slide_point(&light, 3, to, RadiusMode::Keep).expect("a control point");
        });
        worst = worst.max(slid);
    }
    println!("{:.0} of {prepared:e} s", worst / prepared);
    assert!(worst < 600.0 * prepared, "{:.0} of {prepared:e} s", worst / prepared);
}
