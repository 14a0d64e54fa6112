//! Compares the G-buffer in CPU memory with pictures of it.

use scene::{Projection, View};

use super::*;
use crate::bendy_light::tests::{renderer, view};
use crate::casters::tests::ball_over;
use crate::{Picture, Renderer, readback};

/// Size whose rows of packed surfaces, offsets and depths all have padding in copies: none is a multiple of 256 bytes.
const SIZE: [u32; 2] = [150, 140];

/// Largest error of depth from rasterization. Corners snap to a 16th of a pixel at the coarsest that Vulkan permits,
/// and depths of this view change by less than a 12th per pixel.
const SNAPPED: f32 = 1.0 / 16.0 / 12.0;

fn seen(aov: Aov, yaw: f64) -> View {
    let mut view = View { width: SIZE[0], height: SIZE[1], ..view(aov) };
    view.camera.rotation = glam::DQuat::from_rotation_y(yaw) * view.camera.rotation;
    view
}

/// Returns the targets of a depth picture, and that picture.
fn drawn(renderer: &mut Renderer, yaw: f64) -> (Targets, Picture) {
    let view = seen(Aov::Depth, yaw);
    let picture = renderer.render(&view, &[]).expect("drawn");
    (renderer.take_targets(&view), picture)
}

/// True if the depths in `texels` agree with those of `picture`.
fn agree(texels: &GbufferTexels, picture: &Picture) -> bool {
    let Projection::Perspective { znear, .. } = seen(Aov::Depth, 0.0).camera.projection else { return false };
    texels.depth.iter().zip(&picture.pixels).all(|(&depth, shown)| match shown[0] {
        nothing if !(nothing > 0.0 && nothing.is_finite()) => depth == 0.0,
        shown => (znear as f32 / depth - shown).abs() <= SNAPPED * shown,
    })
}

#[test]
fn a_gbuffer_in_memory_is_what_was_drawn() {
    let mut renderer = renderer(&ball_over(2.5));
    let (mut targets, picture) = drawn(&mut renderer, 0.0);
    let (gpu, _) = renderer.gpu_scene();
    let [packed, offset, _] = targets.gbuffer.textures.each_ref();
    let packed = readback::read::<[u32; 4]>(gpu, packed, SIZE).expect("read");
    let offset = readback::read::<f32>(gpu, offset, SIZE).expect("read");
    assert!(offset.iter().any(|&offset| offset > 0.0), "the ball is smooth");
    assert!(packed.iter().any(|texel| texel[1] == 0) && packed.iter().any(|texel| texel[1] != 0));
    let texels = targets.gbuffer_texels(gpu).expect("read");
    assert!(texels.packed == packed && texels.offset == offset);
    assert!(agree(texels, &picture));
    // Deliberate fault that the check must detect: rows that begin at the padding of the one before.
    let mut shifted = std::mem::take(&mut targets.texels.1);
    shifted.depth.rotate_right(SIZE[0] as usize + 42);
    assert!(!agree(&shifted, &picture));
}

#[test]
fn a_gbuffer_is_read_back_when_it_has_changed() {
    let mut renderer = renderer(&ball_over(2.5));
    let (mut targets, picture) = drawn(&mut renderer, 0.0);
    let pixels = u64::from(SIZE[0]) * u64::from(SIZE[1]);
    assert_eq!(targets.bytes(), pixels * 44);
    targets.gbuffer_texels(renderer.gpu_scene().0).expect("read");
    // Rows of 2,400 and 600 bytes are padded in copies.
    assert_eq!(targets.bytes(), pixels * (44 + 24) + (2560 + 2 * 768) * u64::from(SIZE[1]));
    // The copy in CPU memory stays while the G-buffer does: a mark shows it.
    let nowhere = targets.texels.1.depth.iter().position(|&depth| depth == 0.0).expect("background");
    targets.texels.1.depth[nowhere] = 7.0;
    renderer.put_targets(targets);
    let (mut same, _) = drawn(&mut renderer, 0.0);
    let texels = same.gbuffer_texels(renderer.gpu_scene().0).expect("read");
    assert!(!agree(texels, &picture) && texels.depth[nowhere] == 7.0);
    renderer.put_targets(same);
    let (mut turned, picture) = drawn(&mut renderer, 0.1);
    assert!(agree(turned.gbuffer_texels(renderer.gpu_scene().0).expect("read"), &picture));
}

#[test]
fn what_the_device_does_not_light_has_no_radiance() {
    let mut renderer = renderer(&ball_over(2.5));
    let view = seen(Aov::Beauty, 0.0);
    let targets = renderer.take_targets(&view);
    assert_eq!(targets.bytes(), u64::from(SIZE[0]) * u64::from(SIZE[1]) * 24);
}
