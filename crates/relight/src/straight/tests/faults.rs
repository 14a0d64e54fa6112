//! Deliberate faults of drawn maps. With them, shadows have other outlines than any board on such a map.

use glam::{Mat3, Mat4};

use super::shadows::{BOARD, SIDE, SPOT_FACE, drawn, judged_by, scene, spot, sun, sun_places};
use crate::DepthMap;
use crate::shape::RelitShape;

/// Counts the wrong points beside the outline that the board has on a map. A filter of four texels reaches half a texel
/// beyond it, and a tenth covers rounding.
fn wrong_by_a_texel<S: RelitShape>(shape: &S, map: &DepthMap, spread: f32) -> usize {
    let positions = BOARD.positions();
    let margin = 0.6 * 2.0 / SIDE as f32 * spread;
    judged_by((&BOARD.on_map(), 4), shape, map, &scene(&positions, &[], 2), (spread, margin)).wrong
}

#[test]
fn a_map_that_is_shifted_by_one_texel_or_lacks_a_band_is_seen() {
    let of_spot = drawn((Mat4::IDENTITY, Some(0.1)), (SPOT_FACE, 0), 0);
    let of_sun = drawn((sun_places(), None), (Mat3::IDENTITY, 0), 0);
    let wrong = |of_spot: &DepthMap, of_sun: &DepthMap| {
        [wrong_by_a_texel(&spot(), of_spot, 2.0), wrong_by_a_texel(&sun(), of_sun, 1.0)]
    };
    assert_eq!(wrong(&of_spot, &of_sun), [0; 2]);
    let faulty = |fault: &dyn Fn(&mut [f32])| {
        let mut maps = [of_spot.clone(), of_sun.clone()];
        for map in &mut maps {
            let mut texels: Vec<f32> = map.rows(0).flatten().copied().collect();
            fault(&mut texels);
            map.rows_mut(0).zip(texels.chunks(SIDE)).for_each(|(row, texels)| row.copy_from_slice(texels));
        }
        wrong(&maps[0], &maps[1])
    };
    for by in [1, SIDE * SIDE - 1, SIDE, SIDE * SIDE - SIDE] {
        let seen = faulty(&|texels| texels.rotate_right(by));
        assert!(seen.iter().all(|wrong| *wrong > 40), "shifted by {by} texels: {seen:?}");
    }
    // The whole board is in the second band of 64 rows.
    let seen = faulty(&|texels| texels[64 * SIDE..128 * SIDE].fill(0.0));
    assert!(seen.iter().all(|wrong| *wrong > 1000), "without a band: {seen:?}");
}
