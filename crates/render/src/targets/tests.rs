//! Tests which memory the targets of a picture take.

use scene::View;

use super::*;
use crate::bendy_light::tests::{renderer_of, view};
use crate::casters::tests::ball_over;

const SIZE: [u32; 2] = [150, 140];

/// Returns the bytes of the targets of a picture of `aov`.
fn bytes_after(backend: Backend, aov: Aov) -> u64 {
    let mut renderer = renderer_of(backend, &ball_over(2.5));
    let view = View { width: SIZE[0], height: SIZE[1], ..view(aov) };
    renderer.render(&view, &[]).expect("drawn");
    renderer.take_targets(&view).bytes()
}

/// The device has a G-buffer and radiance where it draws, and nothing of a picture that the processor draws.
#[test]
fn targets_are_made_where_they_are_drawn() {
    let pixels = pixel_count(SIZE);
    let device = gbuffer::BYTES_PER_PIXEL + LIT_BYTES_PER_PIXEL;
    assert_eq!(bytes_after(Backend::Wgpu, Aov::Beauty), pixels * device);
    for aov in [Aov::Depth, Aov::Beauty] {
        let native = bytes_after(Backend::Native, aov);
        assert!(native > 0 && native <= NativeTargets::max_bytes(SIZE), "{native}");
    }
}
