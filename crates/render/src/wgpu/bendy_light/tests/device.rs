//! Tests of bent maps on the wgpu backend alone: buffer capacity, wireframes, and constants of the shaders.

use light::Light;
use light::parameters::RANGE;

use super::{Setup, UNSPLIT, alone, light, renderer, scene, view};
use crate::wgpu::bendy_light::shadow_buffers::Capacity;
use crate::wgpu::bendy_light::walk;
use crate::{Aov, Backend, Picture};

/// A map that does not fit into its buffers is drawn again with the same result.
#[test]
fn room_grows_until_a_map_fits() {
    let mut ample = Setup::new(Backend::Wgpu);
    let expected = ample.picture(Aov::Visibility);
    let cramped = || {
        let mut setup = Setup::new(Backend::Wgpu);
        setup.renderer.wgpu().backend.bent_buffers.capacity =
            Capacity { work: 1, patches: 1, split_vertices: 3, masked_vertices: 0 };
        setup
    };
    let mut setup = cramped();
    assert_eq!(setup.picture(Aov::Visibility), expected);
    let room = setup.renderer.wgpu().backend.bent_buffers.capacity;
    assert!(room.work > 1 && room.patches > 1 && room.split_vertices > 3, "{room:?}");

    // For a screen, the fit check comes with the picture.
    let shown = |setup: &mut Setup| setup.renderer.render_display(&view(Aov::Beauty), &setup.lights).expect("drawn");
    let mut setup = cramped();
    assert!(shown(&mut setup) == shown(&mut ample));
    let again = setup.renderer.counts();
    assert!(setup.renderer.wgpu().backend.bent_buffers.capacity.work > 1 && again.shadow > 1, "{again:?}");
    // Once the map fits, nothing is drawn twice.
    shown(&mut setup);
    assert_eq!(setup.renderer.counts().shadow, again.shadow);
}

/// A wireframe shows at each (v, w) the t of the first hit, and nothing where light hits nothing. A wireframe with
/// inverted w does not.
#[test]
fn a_wireframe_shows_what_light_hits_first() {
    let mut setup = Setup::new(Backend::Wgpu);
    let drawn = setup.picture(Aov::Wireframe);
    let (width, height) = (drawn.width as usize, drawn.height as usize);
    let end = setup.tube.n as f64;
    // A drawn triangle lies within 0.4 texel of the truth: along the light 2e-4 of t, and across it the same share of a
    // pixel, which is 13 texels, over which t changes by up to 0.05.
    let margin = 2e-4 + 0.4 / 13.0 * 0.05;
    let agrees = |x: usize, y: usize, w_sign: f64| {
        let [t, .., alpha] = drawn.pixels[y * width + x].map(f64::from);
        let from_middle = |at: usize, size: usize| ((2 * at + 1) as f64 - size as f64) / height as f64;
        let (v, w) = (from_middle(x, width), -w_sign * from_middle(y, height));
        let reaches = |t| walk::reaches(&setup.tube, &setup.triangles, t, v, w);
        (v.hypot(w) < 0.95)
            .then(|| if alpha == 0.0 { reaches(end) } else { reaches(t - margin) && !reaches((t + margin).min(end)) })
    };
    let pixels = || (1..height - 1).step_by(7).flat_map(|y| (1..width - 1).step_by(5).map(move |x| (x, y)));
    // A step of t marks an edge, where a pixel may show either side.
    let t_of = |x: usize, y: usize| drawn.pixels[y * width + x][0];
    let smooth = |&(x, y): &(usize, usize)| {
        let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        around.iter().all(|&(i, j)| (t_of(i, j) - t_of(x, y)).abs() < 0.05)
    };
    let judged = |w_sign| -> Vec<bool> { pixels().filter(smooth).filter_map(|(x, y)| agrees(x, y, w_sign)).collect() };
    let right = judged(1.0);
    assert!(right.len() > 300 && right.iter().all(|agrees| *agrees), "{right:?}");
    let fault = judged(-1.0).iter().filter(|agrees| !**agrees).count();
    assert!(fault > right.len() / 20, "a sign error in w changes only {fault} pixels");

    let edges = |picture: &Picture| picture.pixels.iter().filter(|pixel| pixel[1] > 0.5).count();
    let split = edges(&drawn);
    setup.renderer.set_shadow_settings(UNSPLIT).expect("sound");
    let unsplit = edges(&setup.picture(Aov::Wireframe));
    assert!(unsplit > 100 && split > 2 * unsplit, "{unsplit} pixels of edges, {split} after splitting");
}

/// The wireframe of a spotlight is that of the equal BendyLight.
#[test]
fn a_spotlights_wireframe_is_that_of_its_bendy_light() {
    let spot = Light::spot().with(RANGE, Some(8.0));
    let mut renderer = renderer(&scene());
    let mut picture = |kind: Light| {
        let lights = alone(&kind.with_transform(light().transform()));
        renderer.render(&view(Aov::Wireframe), &lights).expect("drawn")
    };
    let bent = light::bend(&spot, 1).expect("valid");
    let expected = picture(bent);
    assert!(expected.pixels.iter().filter(|pixel| pixel[3] == 1.0).count() > 1000);
    assert_eq!(picture(spot), expected);
}

/// Constants in WGSL equal those in Rust.
#[test]
fn constants_are_the_models() {
    use light::{GAUSS_LEGENDRE, Lanes, Real};
    let solve = include_str!("../../shaders/solve.wgsl");
    let arc = include_str!("../../shaders/arc.wgsl");
    let tube = include_str!("../../shaders/tube.wgsl");
    let split = include_str!("../../shaders/bent_map_split.wgsl");
    let spelled = |wgsl: &str, line: &str| assert!(wgsl.contains(line), "`{line}` is not in the WGSL");
    spelled(solve, &format!("const NEWTON_STEPS = {}u;", f32::NEWTON_STEPS));
    spelled(tube, &format!("const JOINT_MERGE = {:e};", f32::JOINT_MERGE));
    spelled(tube, &format!("const DIRECTION_FLOOR = {:e};", f32::DIRECTION_FLOOR));
    spelled(tube, &format!("segments: array<Segment, {}>;", crate::wgpu::bendy_light::SEGMENT_CAPACITY));
    let map = include_str!("../../shaders/bent_map.wgsl");
    spelled(map, &format!("slabs: array<Slab, {}>;", crate::wgpu::bendy_light::slab::SLABS_PER_UNIFORM));
    spelled(split, &format!("const LAST_LEVEL = {}u;", crate::wgpu::bendy_light::gpu_structs::LEVELS - 1));
    for (abscissa, weight) in GAUSS_LEGENDRE {
        spelled(arc, &format!("vec2f({}, {}),", abscissa as f32, weight as f32));
    }
    for straight in 0..crate::wgpu::bendy_light::Baked::MAX_UNROLLED_SEGMENTS {
        spelled(tube, &format!("if BAKED_SEGMENTS > {straight}u {{ visit_segment(&search, {straight}u, q); }}"));
    }
}
