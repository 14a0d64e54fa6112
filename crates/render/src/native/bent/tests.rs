//! Makes deliberate faults in maps of the native backend. A comparison with the traced paths of `walk.rs`, which uses
//! no map, must detect each. The faults of wrong culling are in `tests/culling.rs`, those of unsplit edges in
//! `../tests.rs`.

use std::sync::Arc;

use relight::DepthMap;

use shadow::MapShape;

use crate::wgpu::bendy_light::tests::{PixelInLight, Setup, differing};
use crate::{Aov, Backend, Picture, ShadowSettings};

/// Texels along each side of a map of four bands.
const RESOLUTION: u32 = 256;
/// Resolution of a map on which one texel changes many pixels near edges.
const COARSE: u32 = 64;
/// Rows of a map that one thread draws at once.
const BAND: usize = 64;
/// Depth of a texel on which nothing was drawn.
const CLEARED: f32 = 1.0;

fn setup(resolution: u32) -> Setup {
    let mut setup = Setup::new(Backend::Native);
    let shadows = ShadowSettings { resolution, straighten: false, ..ShadowSettings::default() };
    setup.renderer.set_shadow_settings(shadows).expect("sound");
    setup
}

/// Changes each map of a BendyLight. The next picture shows the fault.
fn corrupt_maps(setup: &mut Setup, mut fault: impl FnMut(&mut DepthMap, &MapShape)) {
    let frame = setup.renderer.native();
    frame.shadow_maps.each_bent_map(|map, shape| {
        fault(Arc::get_mut(map).expect("no picture is under way"), shape);
    });
    frame.viewers.invalidate();
}

/// Renders a picture with a corrupted map, then restores the map.
fn with_corrupt_map(setup: &mut Setup, fault: impl Fn(&mut DepthMap, &MapShape)) -> Picture {
    let mut right = DepthMap::default();
    corrupt_maps(setup, |map, shape| {
        right = map.clone();
        fault(map, shape);
    });
    let picture = setup.picture(Aov::Visibility);
    corrupt_maps(setup, |map, _| *map = right.clone());
    picture
}

/// True if the picture's pixels `near` edges fit the traced paths better than paths shifted by one texel along v or w.
/// The number of differing pixels grows with the displacement of edges, so a minimum at no shift means a displacement
/// below half a texel.
fn is_map_aligned(setup: &Setup, near: &[PixelInLight], picture: &Picture, texel: [f64; 2]) -> bool {
    let misfits = |v: f64, w: f64| {
        let is_lit = |seen: &PixelInLight| seen.is_lit(&setup.tube, [v * texel[0], w * texel[1]]);
        near.iter().filter(|seen| is_lit(seen) != (picture.pixels[seen.pixel][0] >= 0.5)).count()
    };
    let here = misfits(0.0, 0.0);
    let beside = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(v, w)| misfits(v, w));
    beside.iter().all(|beside| here < *beside)
}

#[test]
fn a_map_shifted_by_one_texel_is_seen() {
    let mut setup = setup(COARSE);
    let right = setup.picture(Aov::Visibility);
    let width = right.width as usize;
    let shown = |pixel: usize| right.pixels.get(pixel).map(|pixel| pixel[0]);
    let is_near = |seen: &PixelInLight| {
        let around = [1, width].map(|step| [seen.pixel.wrapping_sub(step), seen.pixel + step]);
        around.as_flattened().iter().any(|other| shown(*other) != shown(seen.pixel))
    };
    let near: Vec<_> = setup.pixels_in_light(1.0).into_iter().filter(is_near).collect();
    let mut texel = [0.0; 2];
    corrupt_maps(&mut setup, |map, shape| {
        let [.., x, y] = shape.fits()[0];
        texel = [x, y].map(|inverse_half| 2.0 / f64::from(inverse_half) / map.side() as f64);
    });
    assert!(near.len() > 200, "{} pixels near edges", near.len());
    assert!(is_map_aligned(&setup, &near, &right, texel));
    let side = COARSE as usize;
    for (what, by) in [("right", 1), ("left", side * side - 1), ("down", side), ("up", side * side - side)] {
        let shifted = with_corrupt_map(&mut setup, |map, _| change(map, |texels| texels.rotate_right(by)));
        assert!(!is_map_aligned(&setup, &near, &shifted, texel), "a texel {what} goes unseen");
    }
}

/// Changes the depths of the first face, in rows from the top.
fn change(map: &mut DepthMap, fault: impl FnOnce(&mut [f32])) {
    let mut texels: Vec<f32> = map.rows(0).flatten().copied().collect();
    fault(&mut texels);
    let side = map.side();
    map.rows_mut(0).zip(texels.chunks(side)).for_each(|(row, texels)| row.copy_from_slice(texels));
}

/// Copies the depths at -w to each w.
fn mirror(map: &mut DepthMap, shape: &MapShape) {
    let side = map.side();
    let [_, middle, _, inverse_half] = shape.fits()[0].map(f64::from);
    let w_of = |row: usize| middle + (1.0 - 2.0 * (row as f64 + 0.5) / side as f64) / inverse_half;
    let row_of = |w: f64| (1.0 - (w - middle) * inverse_half) * side as f64 / 2.0 - 0.5;
    let before: Vec<f32> = map.rows(0).flatten().copied().collect();
    for (row, texels) in map.rows_mut(0).enumerate() {
        let other = row_of(-w_of(row)).round();
        if (0.0..side as f64).contains(&other) {
            texels.copy_from_slice(&before[other as usize * side..][..side]);
        } else {
            texels.fill(CLEARED);
        }
    }
}

/// Returns a setup, and the traced pixels, with which its map agrees.
fn setup_and_traced_pixels() -> (Setup, Vec<(usize, bool)>) {
    let mut setup = setup(RESOLUTION);
    let walked = setup.traced_pixels(1.0, RESOLUTION);
    assert_eq!(differing(&walked, &setup.picture(Aov::Visibility)), 0);
    (setup, walked)
}

#[test]
fn a_lookup_with_the_wrong_sign_of_w_is_seen() {
    let (mut setup, walked) = setup_and_traced_pixels();
    let fault = differing(&walked, &with_corrupt_map(&mut setup, mirror));
    assert!(fault > walked.len() / 50, "a sign error in w changes only {fault} pixels of {}", walked.len());
}

#[test]
fn a_band_that_its_thread_skipped_is_seen() {
    let (mut setup, walked) = setup_and_traced_pixels();
    for band in 0..RESOLUTION as usize / BAND {
        // Cleared but not drawn, or not even cleared.
        for left in [CLEARED, 0.0] {
            let skip = |map: &mut DepthMap, _: &MapShape| {
                let rows = BAND * map.side();
                change(map, |texels| texels[band * rows..][..rows].fill(left));
            };
            let fault = differing(&walked, &with_corrupt_map(&mut setup, skip));
            assert!(fault > 0, "band {band} left at {left} goes unseen");
        }
    }
}
