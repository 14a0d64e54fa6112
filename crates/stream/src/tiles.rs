//! Parts of pictures: the tiles that differ between two, and bands of about equal size in bytes.

use crate::{FrameTile, StreamError, png};

/// Side of the blocks in which pictures are compared, in pixels. A multiple of the block size of JPEG.
const BLOCK: usize = 64;

/// Share of differing pixels above which the whole picture is sent.
const WHOLE_PICTURE_SHARE: f64 = 0.6;

/// Size that a band should have, in bytes. The next constant is the estimated number of bytes per pixel before the
/// first band is encoded.
const BAND_BYTES: f64 = 30_000.0;
const FIRST_BYTES_PER_PIXEL: f64 = 0.8;

/// Least number of rows in a band, except for the last one.
const MIN_BAND_ROWS: usize = 16;

/// Returns the tile that covers the whole picture.
pub fn whole_tile(width: u16, height: u16) -> FrameTile {
    FrameTile { x: 0, y: 0, width, height }
}

/// Finds the rectangles in which two pictures of RGBA pixels of that size differ. They hold every pixel that differs
/// and do not overlap. If most of the picture differs, the only rectangle is the whole picture. If nothing differs,
/// there is none.
pub fn changed_tiles(before: &[u8], after: &[u8], width: u16, height: u16) -> Result<Vec<FrameTile>, StreamError> {
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
            // A rectangle of the same columns that ends above grows by this row.
            let above = rectangles.iter_mut().find(|[x, y, w, h]| (*x, *w, y + *h) == (from, column - from, row));
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

/// Copies the pixels of a tile from a picture that is `width` pixels wide, with rows from the top.
pub fn crop(rgba: &[u8], width: u16, tile: FrameTile) -> Vec<u8> {
    let (x, y, columns) = (usize::from(tile.x), usize::from(tile.y), usize::from(tile.width));
    let line = |row: usize| {
        let from = 4 * ((y + row) * usize::from(width) + x);
        &rgba[from..from + 4 * columns]
    };
    (0..usize::from(tile.height)).map(line).collect::<Vec<_>>().concat()
}

/// Cuts a picture into PNG bands from top to bottom, each of 20 to 40 KB as a rule. A client shows the bands it has,
/// and the sender can stop between two.
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
