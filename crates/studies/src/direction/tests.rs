use glam::DVec3;
use light::{Light, Root, Tube};

use super::grid::{at_edge, degrees_between, grid};
use super::law::{LAWS, Law, WINDOW};
use super::{chart, run};

/// Three segments that bend in space and widen.
fn bent() -> Tube<f64> {
    let points = [(0.0, 0.0, 0.0), (0.6, 0.1, 0.0), (1.5, 0.7, 0.2), (1.9, 1.6, 0.5), (1.8, 2.2, 1.0)]
        .map(DVec3::from);
    Tube::new(&Light::bendy(points.to_vec(), vec![0.1, 0.2, 0.3, 0.45, 0.5])).expect("no fold")
}

/// The tangent, against the light, of the curve of constant (v, w) through a root, by differences of its points.
fn by_differences(tube: &Tube<f64>, root: &Root<f64>) -> DVec3 {
    const STEP: f64 = 1e-5;
    let s = &tube.segments[root.segment].curve;
    let at = |u: f64| {
        let (v_hat, w_hat) = tube.cross_section(s, s.u_hat(u));
        s.position(u) + (v_hat * root.v_len + w_hat * root.w_len) * (s.radius(u) / root.radius)
    };
    -(at(root.u + STEP) - at(root.u - STEP)).normalize()
}

/// Differences are good to STEP^2 times third derivatives over lengths of order 1, in degrees some 1e-8. All other laws
/// are further off: what would not be caught if it were taken for the path.
#[test]
fn path_is_the_tangent() {
    let tube = bent();
    let mut largest = [0.0_f64; LAWS.len()];
    for segment in 0..tube.n {
        for k in 1..20 {
            let root = at_edge(&tube, segment, f64::from(k) / 20.0, f64::from(k));
            let exact = by_differences(&tube, &root);
            for (law, largest) in LAWS.into_iter().zip(&mut largest) {
                *largest = largest.max(degrees_between(law.direction(&tube, &root), exact));
            }
        }
    }
    let [along_tube, path, printed, blended] = largest;
    assert!(path < 1e-6, "{path}");
    assert!(along_tube > 0.5 && printed > 10.0 && blended > 0.1, "{largest:?}");
}

/// The model's own two are the ones measured here.
#[test]
fn laws_are_the_products() {
    for (direction, law) in [(light::Direction::Tube, Law::Tube), (light::Direction::Path, Law::Path)] {
        let mut tube = bent();
        tube.direction = direction;
        for k in 0..60 {
            let root = at_edge(&tube, k % 3, f64::from(k as u32) / 60.0, k as f64);
            let apart = degrees_between(tube.direction_at(&root), law.direction(&tube, &root));
            assert!(apart < 1e-12, "{law:?}: {apart}");
        }
    }
}

#[test]
fn blended_is_continuous_and_exact_between() {
    let tube = bent();
    for angle in (0..12).map(f64::from) {
        for joint in 1..tube.n {
            let (before, after) = (at_edge(&tube, joint - 1, 1.0, angle), at_edge(&tube, joint, 0.0, angle));
            let jump =
                |law: Law| degrees_between(law.direction(&tube, &before), law.direction(&tube, &after));
            assert!(jump(Law::Blended) < 1e-12 && jump(Law::Tube) < 1e-12);
        }
        let middle = at_edge(&tube, 1, f64::midpoint(WINDOW, 1.0 - WINDOW), angle);
        let both = [Law::Blended, Law::Path].map(|law| law.direction(&tube, &middle));
        assert_eq!(both[0], both[1]);
    }
}

/// `|atan(s / (1 - k)) - atan s|`, `s = |R'| / |P'|`, `k = R kappa` (light model, section 3). 64 places around the edge
/// come within 0.13 % of the greatest k, which k / (1 - k) makes 1.2 % at 0.9.
#[test]
fn grid_meets_the_closed_form() {
    for cell in grid() {
        let (s, k) = (cell.taper, cell.r_kappa);
        let expected = (libm::atan(s / (1.0 - k)) - libm::atan(s)).to_degrees();
        let [along_tube, path, _, blended] = [0, 1, 2, 3].map(|law| cell.laws[law]);
        let near = |x: f64| (x - expected).abs() <= 0.02 * expected + 1e-6;
        assert!(near(path.joint_jump_deg), "{cell:?} {expected}");
        // The curve is a little more bent in its middle, by 1 / cos^3 of half its turn: 0.4 % of k.
        let most = (libm::atan(s / (1.0 - 1.004 * k)) - libm::atan(s)).to_degrees();
        assert!((0.98 * expected..=most + 1e-6).contains(&along_tube.off_path_deg), "{cell:?} {expected}");
        assert_eq!((path.off_path_deg, along_tube.joint_jump_deg < 1e-6), (0.0, true), "{cell:?}");
        assert!(blended.joint_jump_deg < 1e-6, "{cell:?}");
        assert!(path.shading_step_p50 <= path.shading_step_p99);
    }
}

#[test]
fn whole_run() {
    let demo = assets::demo("vases").expect("a demo");
    let subject = (&demo.scene, &demo.contents.lights[..], demo.contents.cameras.first());
    let (report, pictures) = run(subject, [64, 36], || {}).expect("a BendyLight");
    let [along_tube, path, printed, _] = [0, 1, 2, 3].map(|law| report.picture[law]);
    assert!(path.pixels > 500 && path.share_disagreeing == 0.0 && path.past_terminator_max_deg == 0.0);
    assert!(along_tube.share_disagreeing > 0.0 && printed.share_disagreeing > along_tube.share_disagreeing);
    let names: Vec<_> = pictures.iter().map(|picture| picture.file_name.as_str()).collect();
    assert_eq!(names, ["tube.png", "path.png", "printed.png", "blended.png", "panels.png"]);
    let panels = image::load_from_memory(&pictures[4].png).expect("a PNG").to_rgb8();
    assert!(panels.width() > 128 && panels.pixels().any(|p| p.0 != [255; 3]));
    assert_ne!(pictures[0].png, pictures[2].png);
    assert!(chart(&report).expect("a chart").contains("R kappa"));
    assert!(run((&demo.scene, &[], None), [8, 8], || {}).is_err());
}
