//! Deliberate faults of drawn maps. With them, shadows have other outlines than any board on such a map.

use super::shadows::{
    BOARD, BoardShadow, SIDE, SPOT_BOARD, SPOT_SHADOW, SUN_BOARD, SUN_SHADOW, judge, opaque_scene, spot, sun,
};
use crate::DepthMap;

#[test]
fn a_map_that_is_shifted_by_one_texel_or_lacks_a_band_is_seen() {
    let drawn = [SPOT_BOARD.drawn(), SUN_BOARD.drawn()];
    // Counts the wrong points beside the outline that the board has on a map. A filter of four texels reaches half a
    // texel beyond it, and a tenth covers rounding.
    let shadows = [SPOT_SHADOW, SUN_SHADOW].map(|shadow| BoardShadow {
        board: BOARD.on_map(),
        margin: 0.6 * 2.0 / SIDE as f32 * shadow.spread,
        finer: 4,
        ..shadow
    });
    let wrong = |[of_spot, of_sun]: &[DepthMap; 2]| {
        let scene = opaque_scene();
        [judge(&spot(), of_spot, &scene, &shadows[0]).wrong, judge(&sun(), of_sun, &scene, &shadows[1]).wrong]
    };
    assert_eq!(wrong(&drawn), [0; 2]);
    let faulty = |fault: &dyn Fn(&mut [f32])| {
        let mut maps = drawn.clone();
        for map in &mut maps {
            let mut texels: Vec<f32> = map.rows(0).flatten().copied().collect();
            fault(&mut texels);
            map.rows_mut(0).zip(texels.chunks(SIDE)).for_each(|(row, texels)| row.copy_from_slice(texels));
        }
        wrong(&maps)
    };
    for by in [1, SIDE * SIDE - 1, SIDE, SIDE * SIDE - SIDE] {
        let seen = faulty(&|texels| texels.rotate_right(by));
        assert!(seen.iter().all(|wrong| *wrong > 40), "shifted by {by} texels: {seen:?}");
    }
    // The whole board is in the second band of 64 rows.
    let seen = faulty(&|texels| texels[64 * SIDE..128 * SIDE].fill(0.0));
    assert!(seen.iter().all(|wrong| *wrong > 1000), "without a band: {seen:?}");
}
