//! Splits of a node by the surface area heuristic.

use crate::Aabb;

/// Number of bins along each axis.
const BINS: usize = 16;
/// Maximum number of boxes in a leaf.
const MAX_LEAF: usize = 8;
/// Cost of a visit to an inner node (a test of its two boxes), in tests of one box of a leaf.
const NODE_COST: f32 = 2.0;
/// Number of levels that are split by cost. Below them nodes are split into halves of equal count.
pub const MAX_DEPTH: u32 = 64;

/// Box with its index in the input.
#[derive(Clone, Copy)]
pub(crate) struct IndexedBox {
    pub bounds: Aabb,
    pub index: u32,
}

/// Boxes whose centres lie in one bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, count: 0 };

    fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }
}

pub(crate) fn union_of(items: &[IndexedBox]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, item| all.union(item.bounds))
}

/// Partitions `items` into two parts and returns the size of the first. Returns `None` if one leaf is cheaper.
pub(crate) fn split(items: &mut [IndexedBox], bounds: Aabb, depth: u32) -> Option<usize> {
    if items.len() < 2 {
        return None;
    }
    let middles = items.iter().fold(Aabb::EMPTY, |all, IndexedBox { bounds, .. }| {
        let middle = bounds.doubled_center();
        Aabb { min: all.min.min(middle), max: all.max.max(middle) }
    });
    let cheapest = (depth < MAX_DEPTH).then(|| cheapest_split(items, middles)).flatten();
    let leaf_cost = items.len() as f32 * bounds.half_area();
    let fits = items.len() <= MAX_LEAF;
    match cheapest {
        Some((cost, ..)) if fits && NODE_COST * bounds.half_area() + cost >= leaf_cost => None,
        Some((_, axis, bin)) => {
            let bin_of = bins_along(middles, axis);
            Some(partition(items, |item| bin_of(item) <= bin))
        }
        None if fits => None,
        None => {
            let half = items.len() / 2;
            let axis = longest_axis(middles);
            let order = |a: &IndexedBox, b: &IndexedBox| {
                a.bounds.doubled_center()[axis].total_cmp(&b.bounds.doubled_center()[axis])
            };
            items.select_nth_unstable_by(half, |a, b| order(a, b).then(a.index.cmp(&b.index)));
            Some(half)
        }
    }
}

/// Returns the least cost of a split, its axis, and the last bin of its first part. `None` if the centres lie in one
/// point.
fn cheapest_split(items: &[IndexedBox], middles: Aabb) -> Option<(f32, usize, usize)> {
    let mut cheapest: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if middles.max[axis] <= middles.min[axis] {
            continue;
        }
        let bin_of = bins_along(middles, axis);
        let mut bins = [Bin::EMPTY; BINS];
        for item in items {
            let bin = &mut bins[bin_of(item)];
            *bin = bin.union(Bin { bounds: item.bounds, count: 1 });
        }
        let mut after = [0.0; BINS];
        let mut seen = Bin::EMPTY;
        for bin in (1..BINS).rev() {
            seen = seen.union(bins[bin]);
            after[bin - 1] = seen.count as f32 * seen.bounds.half_area();
        }
        seen = Bin::EMPTY;
        for bin in 0..BINS - 1 {
            seen = seen.union(bins[bin]);
            if seen.count == 0 || seen.count == items.len() {
                continue;
            }
            let cost = seen.count as f32 * seen.bounds.half_area() + after[bin];
            if cheapest.is_none_or(|(least, ..)| cost < least) {
                cheapest = Some((cost, axis, bin));
            }
        }
    }
    cheapest
}

/// Returns a function that gives the bin of a box from its centre.
fn bins_along(middles: Aabb, axis: usize) -> impl Fn(&IndexedBox) -> usize {
    let (low, scale) = (middles.min[axis], BINS as f32 / (middles.max[axis] - middles.min[axis]));
    // An overflowing quotient falls into the last bin.
    move |item| (((item.bounds.doubled_center()[axis] - low) * scale) as usize).min(BINS - 1)
}

fn longest_axis(bounds: Aabb) -> usize {
    let side = bounds.max - bounds.min;
    (0..3).max_by(|a, b| side[*a].total_cmp(&side[*b])).unwrap_or(0)
}

/// Moves the items for which `first` holds to the front and returns their number.
fn partition(items: &mut [IndexedBox], first: impl Fn(&IndexedBox) -> bool) -> usize {
    let mut count = 0;
    for index in 0..items.len() {
        if first(&items[index]) {
            items.swap(count, index);
            count += 1;
        }
    }
    count
}
