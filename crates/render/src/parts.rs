//! Parts of pixel rectangles, between which work can yield.

/// Returns the number of pixels of `[x, y, width, height]`.
pub(crate) fn area([_, _, width, height]: [u32; 4]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Cuts `[x, y, width, height]` into `count` bands of rows, fewer if there are fewer rows. The flag is true for the
/// last.
pub(crate) fn row_bands(
    [x, y, width, height]: [u32; 4],
    parts: u32,
) -> impl Iterator<Item = ([u32; 4], bool)> {
    let rows = height.div_ceil(parts).max(1);
    (0..height.div_ceil(rows).max(1)).map(move |part| {
        let first = part * rows;
        ([x, y + first, width, rows.min(height - first)], first + rows >= height)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
