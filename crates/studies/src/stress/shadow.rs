//! Compares shadows in pictures, pixel by pixel, with the visibility that follows from tracing light paths as polylines
//! (`walk`).

use glam::DVec3;
use light::Tube;
use proptest::prelude::*;
use render::{Aov, Picture, ShadowSettings, View};
use scene::Material;

use super::adapter::{Adapter, StressPicture};
use super::light::LightLimits;
use super::runner::{Check, CheckTally};
use super::scenes::{Facet, HEIGHT, Shot, WIDTH, YFOV, obstacle, shots, square, wall};
use super::walk::{RESOLUTION, WalkReceiver, light_reaches};

/// Limits of lights whose shadow maps have their full accuracy. No light is so close to a fold that the width of a
/// texel spans the whole light.
const LIGHTS: LightLimits = LightLimits { segments: 4, fold: 0.9, pinched: false, flipping: false };

/// Deliberate fault in a check's input, which the check must detect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The renderer also draws a copy of the scene at half the distance from the source. The tracing of light paths
    /// does not know the copy.
    Ghost,
    /// The renderer leaves out every second facet of a wall. The tracing of light paths keeps it.
    Holes,
    /// The renderer draws all objects except the receiver after half a turn about the z axis, so on the other side of
    /// the light. The tracing of light paths leaves them in place.
    WrongSide,
}

/// Generates planes without casters.
pub fn lone_planes() -> impl Strategy<Value = Shot> {
    shots(LIGHTS, square(1.0..8.0), Just(vec![]))
}

/// Generates planes behind a closed wall.
pub fn walls() -> impl Strategy<Value = Shot> {
    shots(LIGHTS, square(3.0..8.0), wall().prop_map(|wall| vec![wall]))
}

/// Generates planes behind triangles of every kind.
pub fn clutter() -> impl Strategy<Value = Shot> {
    shots(LIGHTS, square(1.0..8.0), prop::collection::vec(obstacle(false), 1..6))
}

/// Maximum number of pixels compared in one picture.
const PIXELS: usize = 48;

/// Makes the check. It makes the deliberate fault `fault` if the tally says so.
pub fn check(fault: Fault) -> impl Fn(&Shot, &Adapter, &mut CheckTally) -> Check {
    move |shot, adapter, tally| {
        let planted = tally.is_planted.then_some(fault);
        agrees_with_the_walk(shot, planted, adapter, tally)
    }
}

/// Checks that visibility is in 0 to 1. At a distance of at least two texels from a shadow edge, checks that it equals
/// the visibility along the traced light path.
fn agrees_with_the_walk(shot: &Shot, planted: Option<Fault>, adapter: &Adapter, tally: &mut CheckTally) -> Check {
    let drawn: Vec<Facet> = match planted {
        Some(Fault::Ghost) => {
            let ghosts = shot.facets.iter().map(|facet| facet.map(|p| p.map(|x| 0.5 * x)));
            shot.facets.iter().copied().chain(ghosts).collect()
        }
        Some(Fault::Holes) => shot.facets.iter().copied().step_by(2).collect(),
        Some(Fault::WrongSide) => {
            let (others, receiver) = shot.facets.split_at(shot.facets.len() - 2);
            let turned = others.iter().map(|facet| facet.map(|[x, y, z]| [-x, -y, z]));
            turned.chain(receiver.iter().copied()).collect()
        }
        None => shot.facets.clone(),
    };
    let shadows = ShadowSettings { resolution: RESOLUTION, straighten: false, ..ShadowSettings::default() };
    let scene = shot.scene(&drawn, vec![Material { double_sided: true, ..Material::default() }]);
    let (view, aovs) = (shot.view(), [Aov::Depth, Aov::Normal, Aov::Visibility]);
    let tube = Tube::new(&shot.light).expect("cases are valid");
    let in_tube =
        |p: [f32; 3]| glam::Vec3::from(p).as_dvec3() * (shot.light.transform().scale / tube.placement.world_per_tube);
    let triangles: Vec<[DVec3; 3]> = shot.facets.iter().map(|facet| facet.map(in_tube)).collect();
    let reach = triangles.iter().flatten().map(|p| p.length()).fold(1.0, f64::max);
    let shown = StressPicture { scene: &scene, view: &view, lights: &shot.lights(), shadows };
    adapter.check_pictures(shown, aovs, |pictures| {
        let visibility = &pictures[2].pixels;
        let pixels: Vec<usize> = (0..visibility.len()).filter(|&pixel| visibility[pixel][3] == 1.0).collect();
        let odd = pixels.iter().find(|&&pixel| !(0.0..=1.0).contains(&visibility[pixel][0]));
        tally.holds(odd.is_none(), || format!("the visibility of pixel {odd:?} is not from 0 to 1"))?;
        for &pixel in pixels.iter().step_by(pixels.len().div_ceil(PIXELS).max(1)) {
            pixel_agrees(&tube, &triangles, reach, &view, &pictures, pixel, tally)?;
        }
        Ok(())
    })
}

/// Compares one pixel of the pictures of depth, normal and visibility.
fn pixel_agrees(
    tube: &Tube<f64>,
    triangles: &[[DVec3; 3]],
    reach: f64,
    view: &View,
    [depth, normal, visibility]: &[Picture; 3],
    pixel: usize,
    tally: &mut CheckTally,
) -> Check {
    let q = tube.placement.tube_from_world(position(view, depth, pixel));
    let mut roots = Vec::new();
    tube.for_each_root(q, |root| roots.push(root));
    // If the tube overlaps itself, rounding decides between the roots.
    let [root] = &roots[..] else { return Ok(()) };
    let facing = DVec3::from_array([0, 1, 2].map(|k| f64::from(normal.pixels[pixel][k])));
    let receiver = WalkReceiver { root, normal: tube.placement.rotation.transpose() * facing };
    let Some(expected) = light_reaches(tube, triangles, reach, &receiver) else { return Ok(()) };
    let shown = visibility.pixels[pixel][0];
    tally.holds(shown == f32::from(u8::from(expected)), || {
        let (t, v, w) = (root.segment as f64 + root.u, root.v_len / root.radius, root.w_len / root.radius);
        let (x, y) = (pixel % WIDTH as usize, pixel / WIDTH as usize);
        let light = if expected { "reaches it" } else { "is blocked" };
        format!(
            "pixel ({x}, {y}), at (t, v, w) = ({t:.6}, {v:.6}, {w:.6}), has the visibility {shown} where light {light}"
        )
    })
}

/// Returns the world position of a pixel of the depth AOV.
fn position(view: &View, depth: &Picture, pixel: usize) -> DVec3 {
    let (width, height) = (f64::from(WIDTH), f64::from(HEIGHT));
    let (x, y) = ((pixel % WIDTH as usize) as f64 + 0.5, (pixel / WIDTH as usize) as f64 + 0.5);
    let half = (YFOV / 2.0).tan();
    let ray = DVec3::new((2.0 * x / width - 1.0) * half * width / height, (1.0 - 2.0 * y / height) * half, -1.0);
    view.camera.world_from_camera().transform_point3(ray * f64::from(depth.pixels[pixel][0]))
}
