//! Parts of pictures, composed again.

use proptest::prelude::*;
use stream::{FrameTile, changed_tiles, crop, png_bands, whole_tile};

/// Generates a picture and another one that differs from it in some rectangles.
fn pictures() -> impl Strategy<Value = (u16, u16, Vec<u8>, Vec<u8>)> {
    let spot = (any::<u16>(), any::<u16>(), 1_u16..90, 1_u16..90, any::<u8>());
    (1_u16..300, 1_u16..200, proptest::collection::vec(spot, 0..5)).prop_map(|(width, height, spots)| {
        let count = 4 * usize::from(width) * usize::from(height);
        let before: Vec<u8> = (0..count).map(|k| (k * 7 / 3) as u8).collect();
        let mut after = before.clone();
        for (x, y, w, h, value) in spots {
            let (x, y) = (x % width, y % height);
            for row in y..(y + h).min(height) {
                for column in x..(x + w).min(width) {
                    after[4 * (usize::from(row) * usize::from(width) + usize::from(column))] ^= value;
                }
            }
        }
        (width, height, before, after)
    })
}

/// Draws those parts of `picture` onto `onto`. Also returns the number of times that each pixel was covered.
fn composed(onto: &[u8], picture: &[u8], width: u16, tiles: &[FrameTile]) -> (Vec<u8>, Vec<u8>) {
    let (mut canvas, mut covered) = (onto.to_vec(), vec![0; onto.len() / 4]);
    for tile in tiles {
        let part = crop(picture, width, *tile);
        for (row, line) in part.chunks_exact(4 * usize::from(tile.width)).enumerate() {
            let at = (usize::from(tile.y) + row) * usize::from(width) + usize::from(tile.x);
            canvas[4 * at..4 * at + line.len()].copy_from_slice(line);
            covered[at..at + usize::from(tile.width)].iter_mut().for_each(|count| *count += 1);
        }
    }
    (canvas, covered)
}

proptest! {
    /// The differing tiles, drawn onto the first picture, give the second one. No pixel is sent twice, and tiles start
    /// at blocks of JPEG.
    #[test]
    fn differing_tiles_make_the_picture((width, height, before, after) in pictures()) {
        let tiles = changed_tiles(&before, &after, width, height).expect("sound");
        let (canvas, covered) = composed(&before, &after, width, &tiles);
        prop_assert!(canvas == after);
        prop_assert!(covered.iter().all(|count| *count <= 1));
        prop_assert!(tiles.iter().all(|tile| tile.x % 16 == 0 && tile.y % 16 == 0));
        prop_assert_eq!(tiles.is_empty(), before == after);
        // The comparison notices a missing tile.
        if let Some((_, rest)) = tiles.split_first() {
            prop_assert!(composed(&before, &after, width, rest).0 != after);
        }
    }
}

#[test]
fn little_that_changes_is_little_to_send_and_most_is_all() {
    let (width, height) = (640, 384);
    let before = vec![9; 4 * 640 * 384];
    let with = |changes: &[(usize, usize)]| {
        let mut after = before.clone();
        for (x, y) in changes {
            after[4 * (y * 640 + x)] = 0;
        }
        changed_tiles(&before, &after, width, height).expect("sound")
    };
    assert_eq!(with(&[(100, 70)]), [FrameTile { x: 64, y: 64, width: 64, height: 64 }]);
    // Neighboring blocks become one rectangle.
    let square = [(100, 70), (130, 70), (100, 130), (130, 130)];
    assert_eq!(with(&square), [FrameTile { x: 64, y: 64, width: 128, height: 128 }]);
    let everywhere: Vec<(usize, usize)> = (0..60).map(|k| (64 * (k % 10), 64 * (k / 10))).collect();
    assert_eq!(with(&everywhere), [whole_tile(width, height)]);
}

#[test]
fn bands_are_the_picture_in_pieces_of_tens_of_kilobytes() {
    let (width, height) = (700_u16, 500_u16);
    let mut state = 1_u32;
    let noise = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Real pictures are not all noise.
        if state & 0x3000_0000 == 0 { (state >> 24) as u8 } else { 40 }
    };
    let rgba: Vec<u8> = (0..4 * 700 * 500).map(noise).collect();
    let bands = png_bands(&rgba, width, height).expect("sound");
    let mut y = 0;
    for (tile, bytes) in &bands {
        assert_eq!((tile.x, tile.y, tile.width), (0, y, width), "one below the other");
        let decoded = image::load_from_memory(bytes).expect("a PNG").to_rgb8().into_raw();
        let part = crop(&rgba, width, *tile);
        let wanted: Vec<u8> = part.chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
        assert!(decoded == wanted, "lossless");
        y += tile.height;
    }
    assert_eq!(y, height);
    let sizes: Vec<usize> = bands[1..bands.len() - 1].iter().map(|(_, bytes)| bytes.len()).collect();
    assert!(sizes.len() > 3 && sizes.iter().all(|bytes| (20_000..40_000).contains(bytes)), "{sizes:?}");
}
