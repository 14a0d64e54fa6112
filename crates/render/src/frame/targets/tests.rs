//! Tests which memory the targets of a picture take.

use scene::{Aov, View};

use super::*;
use crate::Backend;
use crate::frame::Frame;
use crate::frame::casters::tests::ball_over;
use crate::frame::tile::pixel_count;
use crate::native::Native;
use crate::wgpu::Wgpu;
use crate::wgpu::bendy_light::tests::{renderer_of, view};

const SIZE: [u32; 2] = [150, 140];

/// Returns the bytes of the targets of a picture of `aov`.
fn bytes_after<B: FrameBackend>(frame: &mut Frame<B>, aov: Aov) -> u64 {
    let view = View { width: SIZE[0], height: SIZE[1], ..view(aov) };
    frame.render(&view, &[]).expect("drawn");
    frame.viewers.take(&frame.backend, &view).expect("it is small").bytes()
}

/// On the GPU every picture has a G-buffer and radiance.
#[test]
fn targets_take_what_is_drawn() {
    let scene = ball_over(2.5);
    let (mut on_gpu, mut on_cpu) = (renderer_of(Backend::Wgpu, &scene), renderer_of(Backend::Native, &scene));
    // Surface, offset and depth; radiance and the screen's picture.
    assert_eq!(bytes_after(on_gpu.wgpu(), Aov::Beauty), pixel_count(SIZE) * (16 + 4 + 4 + 16 + 4));
    assert_eq!(Wgpu::max_target_bytes(SIZE), pixel_count(SIZE) * (16 + 4 + 4 + 16 + 4));
    for aov in [Aov::Depth, Aov::Beauty] {
        let native = bytes_after(on_cpu.native(), aov);
        assert!(native > 0 && native <= Native::max_target_bytes(SIZE), "{native}");
    }
}
