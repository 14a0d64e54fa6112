//! Tests coarse maps of simplified casters: the position of shadows, and the cases that use the scene's own casters.

use std::time::{Duration, Instant};

use glam::DVec3;
use light::Light;
use light::parameters::TRANSLATION;
use scene::{MapScale, ViewSlot};

use crate::frame::casters::tests::{ball_over, floor, lights};
use crate::frame::{Frame, SceneBackend};
use crate::wgpu::bendy_light::tests::{alone, renderer, view};
use crate::{Aov, Picture, Renderer, View};

/// Half the side of a floor that contains the ball's shadow.
const FLOOR: f64 = 2.5;
/// Timeout for a thread that makes casters of a few thousand triangles.
const AT_MOST: Duration = Duration::from_secs(30);

fn half(aov: Aov) -> View {
    View { shadow_map: MapScale::Half, ..view(aov) }
}

/// Returns a renderer that has drawn nothing.
fn fresh() -> Renderer {
    renderer(&ball_over(FLOOR))
}

/// Returns the light `k` of a drag that moves too little to show.
fn dragged(light: &Light, k: u32) -> Light {
    light.clone().with(TRANSLATION, light.get(TRANSLATION) + 1e-9 * f64::from(k) * DVec3::X)
}

fn draw(renderer: &mut Renderer, view: &View, light: &Light) -> Picture {
    renderer.render(view, &alone(light)).expect("drawn")
}

/// Returns a renderer whose coarse casters are made, after a drag of the returned light.
fn with_coarse_casters() -> (Renderer, Light) {
    let (mut renderer, (light, _)) = (fresh(), lights()[2].clone());
    let since = Instant::now();
    for k in 0.. {
        draw(&mut renderer, &half(Aov::Visibility), &dragged(&light, k));
        if renderer.wgpu().shadow_maps.coarse.made().is_some() {
            break;
        }
        assert!(since.elapsed() < AT_MOST, "no coarse casters after {k} pictures");
    }
    (renderer, light)
}

/// Replaces the casters with ones of a hundred times the error.
fn plant(renderer: &mut Renderer) {
    let Frame { backend, scene, shadow_maps, .. } = renderer.wgpu();
    let coarser = scene.casters_within(backend.device(), 0.2).expect("made");
    shadow_maps.coarse.made().expect("made").casters = coarser;
}

/// Coarse maps use fewer triangles, and shadows move by no more than the permitted error. Full maps use all triangles.
#[test]
fn coarse_maps_are_of_fewer_triangles() {
    let (mut renderer, light) = with_coarse_casters();
    let all = renderer.wgpu().scene.casters.triangle_count;
    let coarse = renderer.wgpu().shadow_maps.coarse.made().expect("made");
    let (count, mesh_error) = (coarse.casters.triangle_count, coarse.mesh_error);
    assert!((100..all / 4).contains(&count), "{count} of {all}");
    assert!(mesh_error < 0.003, "{mesh_error}");

    // Three texels of the map, 2 R / 1024 wide with R at most 2.3, and the casters' error. The light moves by far less.
    let slack = mesh_error + 3.0 * 2.3 / 512.0;
    let pair = (dragged(&light, 1_000_000), light.clone());
    let ([dark, lit], wrong) = floor(&mut renderer, MapScale::Half, &pair, slack + 1e-3);
    assert!(dark > 500 && lit > 500, "{dark} dark, {lit} lit");
    assert_eq!(wrong, 0);

    plant(&mut renderer);
    let pair = (dragged(&light, 2_000_000), light.clone());
    assert!(floor(&mut renderer, MapScale::Half, &pair, slack + 2e-3).1 > 0, "the planted fault went unseen");
    let exact = draw(&mut fresh(), &view(Aov::Visibility), &light);
    assert_eq!(draw(&mut renderer, &view(Aov::Visibility), &light), exact);
}

/// A map with texels so fine that the error would show uses the scene's own triangles.
#[test]
fn narrow_lights_have_exact_casters() {
    let (mut renderer, wide) = with_coarse_casters();
    plant(&mut renderer);
    let narrow = wide.clone().map_points(|_, point| point.radius *= 0.2);
    let mut other = fresh();
    let exact = draw(&mut other, &half(Aov::Visibility), &narrow);
    assert_eq!(draw(&mut renderer, &half(Aov::Visibility), &narrow), exact);
    // The wide light shows the changed casters.
    let moved = dragged(&wide, 1_000_000);
    assert_ne!(draw(&mut renderer, &half(Aov::Visibility), &moved), draw(&mut other, &half(Aov::Visibility), &moved));
}

/// Casters of a replaced scene are freed.
#[test]
fn another_scene_gives_their_memory_back() {
    let (mut renderer, light) = with_coarse_casters();
    renderer.set_scene(&scene::pose(ball_over(FLOOR), 0.0)).expect("fits");
    draw(&mut renderer, &view(Aov::Visibility), &light);
    assert!(renderer.wgpu().shadow_maps.coarse.made().is_none());
}

/// A scene that changes with each picture starts no threads.
#[test]
fn scenes_that_move_make_none() {
    let mut renderer = fresh();
    let (light, _) = &lights()[2];
    for k in 0..6 {
        renderer.set_scene(&scene::pose(ball_over(FLOOR), 0.0)).expect("fits");
        let view = View { slot: ViewSlot(1), ..half(Aov::Visibility) };
        draw(&mut renderer, &view, &dragged(light, k));
        assert!(!renderer.wgpu().shadow_maps.coarse.is_begun(), "{k}");
    }
}
