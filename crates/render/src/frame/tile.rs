//! Cuts pictures into tiles and rectangles into bands, between which work can yield.

use std::time::Duration;

/// A rectangle of pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Pixels from the picture's left edge to the tile's.
    pub x: u32,
    /// Pixels from the picture's upper edge to the tile's.
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Tile {
    /// Returns the intersection with `[x, y, width, height]` of the picture, relative to this tile's corner.
    pub fn clip(self, [x, y, width, height]: [u32; 4]) -> [u32; 4] {
        let [left, top] = [x.max(self.x), y.max(self.y)];
        let right = (x + width).min(self.x + self.width);
        let bottom = (y + height).min(self.y + self.height);
        [left - self.x, top - self.y, right.saturating_sub(left), bottom.saturating_sub(top)]
    }
}

/// Returns the number of pixels of a picture of this size.
pub(crate) fn pixel_count([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Returns the number of pixels of `[x, y, width, height]`.
pub(crate) fn area([_, _, width, height]: [u32; 4]) -> u64 {
    pixel_count([width, height])
}

/// Cuts `[x, y, width, height]` into `parts` bands of rows, fewer if there are fewer rows. The flag is true for the
/// last.
pub(crate) fn row_bands([x, y, width, height]: [u32; 4], parts: u32) -> impl Iterator<Item = ([u32; 4], bool)> {
    let rows = height.div_ceil(parts).max(1);
    (0..height.div_ceil(rows).max(1)).map(move |part| {
        let first = part * rows;
        ([x, y + first, width, rows.min(height - first)], first + rows >= height)
    })
}

/// Shortest side of a tile in pixels, except at the picture's edges. A tile of that size takes half its time for its
/// pixels, where they are cheapest, and half for work that does not depend on its size.
const MIN_SIDE: u32 = 128;
/// Longest side of a tile in pixels. The targets of such a tile take 46 MB, on the native backend 84 MB.
const MAX_SIDE: u32 = 1024;
/// Side of the first tile in pixels, before any measurement.
const FIRST_SIDE: u32 = 256;
/// Divisor of sides, so that four pixels which share a texture's level of detail are in one tile.
const STEP: u32 = 16;

/// Division of a picture into tiles, row by row. The time of earlier tiles determines the size of later ones.
#[derive(Debug)]
pub(crate) struct Tiling {
    size: [u32; 2],
    /// Shortest side of a tile.
    min_side: u32,
    /// Approximate side of the next row's tiles.
    side: u32,
    next: Option<Tile>,
}

impl Tiling {
    /// Begins with the first tile. The work of each tile grows with `triangle_count`, where a triangle costs about as
    /// much as a pixel: tiles have at least that number of pixels, within the limits of their sides.
    pub fn new(size: [u32; 2], triangle_count: u32) -> Self {
        let min_side = triangle_count.isqrt().clamp(MIN_SIDE, MAX_SIDE);
        let mut tiling = Self { size, min_side, side: FIRST_SIDE.max(min_side), next: None };
        tiling.next = Some(tiling.row_from(0));
        tiling
    }

    /// Returns the current tile. `None` after the last one.
    pub fn tile(&self) -> Option<Tile> {
        self.next
    }

    /// Advances to the next tile. `took` is the time of the longest piece of work that grew with the tile's pixels,
    /// `aim` its target.
    pub fn advance(&mut self, took: Duration, aim: Duration) {
        let Some(tile) = self.next else { return };
        let ratio = aim.as_secs_f64() / took.as_secs_f64().max(1e-6);
        let pixels = f64::from(tile.width) * f64::from(tile.height);
        // At most four times the pixels at once, because a single measurement is unreliable.
        let wanted = (pixels * ratio.clamp(0.25, 4.0)).sqrt() as u32;
        self.side = wanted.clamp(self.min_side, MAX_SIDE);
        let right = tile.x + tile.width;
        self.next = if right < self.size[0] {
            let width = tile.width.min(self.size[0] - right);
            Some(Tile { x: right, width, ..tile })
        } else if tile.y + tile.height < self.size[1] {
            Some(self.row_from(tile.y + tile.height))
        } else {
            None
        };
    }

    fn row_from(&self, y: u32) -> Tile {
        let [width, height] = [(self.size[0], 0), (self.size[1], y)].map(|(size, from)| {
            let left = size - from;
            let count = left.div_ceil(self.side);
            left.div_ceil(count).next_multiple_of(STEP).min(left)
        });
        Tile { x: 0, y, width, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns all tiles of a picture with a cost of a microsecond per pixel, and the aim `aim_ms`.
    fn tiles(size: [u32; 2], triangles: u32, aim_ms: u64) -> Vec<Tile> {
        let mut tiling = Tiling::new(size, triangles);
        let mut tiles = Vec::new();
        while let Some(tile) = tiling.tile() {
            tiles.push(tile);
            let took = Duration::from_micros(u64::from(tile.width) * u64::from(tile.height));
            tiling.advance(took, Duration::from_millis(aim_ms));
        }
        tiles
    }

    #[test]
    fn every_pixel_is_in_one_tile() {
        for size in [[1, 1], [17, 3], [256, 256], [257, 511], [1000, 30], [33, 2000]] {
            for aim_ms in [1, 50, 10_000] {
                let mut seen = vec![0_u8; (size[0] * size[1]) as usize];
                for tile in tiles(size, 12, aim_ms) {
                    for y in tile.y..tile.y + tile.height {
                        for x in tile.x..tile.x + tile.width {
                            seen[(y * size[0] + x) as usize] += 1;
                        }
                    }
                    assert!(tile.x % 2 == 0 && tile.y % 2 == 0, "{tile:?} parts pixels that belong together");
                }
                assert!(seen.iter().all(|count| *count == 1), "{size:?} {aim_ms}");
            }
        }
    }

    #[test]
    fn tiles_grow_to_what_may_be_spent() {
        let pixels = |tile: &Tile| tile.width * tile.height;
        for (triangles, aim_ms, least, most) in [
            (12, 50, 35_000, 60_000),
            (12, 200, 140_000, 240_000),
            // Within limits: no tile is tiny, and none has fewer pixels than the scene has triangles.
            (12, 0, 12_000, 20_000),
            (12, 10_000, 800_000, 1_100_000),
            (400_000, 0, 320_000, 480_000),
        ] {
            let tiles = tiles([4096, 4096], triangles, aim_ms);
            // The first rows measure.
            let late = pixels(&tiles[tiles.len() - 2]);
            assert!((least..=most).contains(&late), "{triangles} {aim_ms}: {late}");
        }
    }

    #[test]
    fn what_lies_in_a_tile_is_counted_from_its_corner() {
        let tile = Tile { x: 100, y: 50, width: 20, height: 10 };
        assert_eq!(tile.clip([0, 0, 500, 500]), [0, 0, 20, 10]);
        assert_eq!(tile.clip([110, 40, 5, 15]), [10, 0, 5, 5]);
        assert_eq!(tile.clip([0, 0, 100, 500])[2], 0, "beside it");
        assert_eq!(tile.clip([0, 70, 500, 9])[3], 0, "below it");
    }

    #[test]
    fn parts_are_all_of_a_rectangle_and_no_more() {
        for height in [0, 1, 7, 100] {
            for parts in [1, 3, 7, 1_000] {
                let all: Vec<_> = row_bands([5, 9, 30, height], parts).collect();
                assert_eq!(all.iter().map(|(part, _)| area(*part)).sum::<u64>(), 30 * u64::from(height));
                let mut next = 9;
                for ([x, y, width, rows], is_last) in &all {
                    assert_eq!((*x, *y, *width), (5, next, 30));
                    next += rows;
                    assert_eq!(*is_last, next == 9 + height);
                }
            }
        }
    }
}
