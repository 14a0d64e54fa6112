//! Pictures in parts: what of one differs from another, and bands of about as many bytes each.

use crate::{FrameTile, StreamError, png};

/// Sides of the blocks that pictures are compared by, in pixels: a multiple of what JPEG works on.
const BLOCK: usize = 64;

/// Where so much of a picture differs all of it is as good.
const WHOLE_PICTURE_SHARE: f64 = 0.6;

/// Bytes that a band is meant to have, and what is thought of the first one's pixels.
const BAND_BYTES: f64 = 30_000.0;
const FIRST_BYTES_PER_PIXEL: f64 = 0.8;

/// Rows of the lowest band.
const MIN_BAND_ROWS: usize = 16;

/// All of a picture.
pub fn whole_tile(width: u16, height: u16) -> FrameTile {
    FrameTile { x: 0, y: 0, width, height }
}

/// Where `to` differs from `from`, two pictures of RGBA pixels of that size: few rectangles that hold every pixel that
/// does and share none. Where most differs it is one, the whole picture; where nothing does there is none.
pub fn changed_tiles(
    before: &[u8],
    after: &[u8],
    width: u16,
    height: u16,
) -> Result<Vec<FrameTile>, StreamError> {
    crate::encode::check_size(before, width, height)?;
    crate::encode::check_size(after, width, height)?;
    let (columns, rows) = (usize::from(width).div_ceil(BLOCK), usize::from(height).div_ceil(BLOCK));
    let differs = |column: usize, row: usize| {
        let from = column * BLOCK;
        let to = (from + BLOCK).min(usize::from(width));
        (row * BLOCK..((row + 1) * BLOCK).min(usize::from(height))).any(|y| {
            let line = 4 * (y * usize::from(width) + from)..4 * (y * usize::from(width) + to);
            before[line.clone()] != after[line]
        })
    };
    let mut rectangles: Vec<[usize; 4]> = Vec::new();
    for row in 0..rows {
        let mut column = 0;
        while column < columns {
            if !differs(column, row) {
                column += 1;
                continue;
            }
            let from = column;
            while column < columns && differs(column, row) {
                column += 1;
            }
            // One as wide that ends here goes on.
            let above =
                rectangles.iter_mut().find(|[x, y, w, h]| (*x, *w, y + *h) == (from, column - from, row));
            match above {
                Some([_, _, _, h]) => *h += 1,
                None => rectangles.push([from, row, column - from, 1]),
            }
        }
    }
    let tile = |[x, y, w, h]: [usize; 4]| {
        let (x, y) = (x * BLOCK, y * BLOCK);
        let (right, bottom) = ((x + w * BLOCK).min(width.into()), (y + h * BLOCK).min(height.into()));
        FrameTile { x: x as u16, y: y as u16, width: (right - x) as u16, height: (bottom - y) as u16 }
    };
    let tiles: Vec<FrameTile> = rectangles.into_iter().map(tile).collect();
    let pixels: f64 = tiles.iter().map(|tile| f64::from(tile.width) * f64::from(tile.height)).sum();
    let is_most = pixels > WHOLE_PICTURE_SHARE * f64::from(width) * f64::from(height);
    Ok(if is_most { vec![whole_tile(width, height)] } else { tiles })
}

/// The pixels of a tile of a picture that is `width` pixels wide, rows from the top.
pub fn crop(rgba: &[u8], width: u16, tile: FrameTile) -> Vec<u8> {
    let (x, y, columns) = (usize::from(tile.x), usize::from(tile.y), usize::from(tile.width));
    let line = |row: usize| {
        let from = 4 * ((y + row) * usize::from(width) + x);
        &rgba[from..from + 4 * columns]
    };
    (0..usize::from(tile.height)).map(line).collect::<Vec<_>>().concat()
}

/// A picture as PNGs that go one below the other, from the top, each of 20 to 40 KB as a rule: a client shows what has come of
/// it, and what has not been sent can be left out.
pub fn png_bands(rgba: &[u8], width: u16, height: u16) -> Result<Vec<(FrameTile, Vec<u8>)>, StreamError> {
    crate::encode::check_size(rgba, width, height)?;
    let (mut bands, mut y, mut bytes_a_pixel) = (Vec::new(), 0, FIRST_BYTES_PER_PIXEL);
    while y < height {
        let rows = (BAND_BYTES / (bytes_a_pixel * f64::from(width))) as usize;
        let rows = rows.max(MIN_BAND_ROWS).min(usize::from(height - y)) as u16;
        let tile = FrameTile { x: 0, y, width, height: rows };
        let bytes = png(&crop(rgba, width, tile), width, rows)?;
        bytes_a_pixel = bytes.len() as f64 / (f64::from(width) * f64::from(rows));
        bands.push((tile, bytes));
        y += rows;
    }
    Ok(bands)
}
