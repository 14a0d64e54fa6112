//! Slabs of the tube in the layout of the mapping passes.

use relight::MapSlab;
use shadow::BoxedSlab;

use super::{gpu_curve, gpu_structs};

/// Slabs in one uniform; `bent_map.wgsl` has the same number. A light with more slabs is mapped in batches.
pub(crate) const SLABS_PER_UNIFORM: usize = 240;

/// Returns slabs for `bent_map.wgsl`, padded to the size of its array.
pub(crate) fn padded(slabs: &[BoxedSlab]) -> Vec<gpu_structs::Slab> {
    let mut padded: Vec<gpu_structs::Slab> = slabs.iter().map(|boxed| (&boxed.slab).into()).collect();
    padded.resize(SLABS_PER_UNIFORM, gpu_structs::Slab::default());
    padded
}

impl From<&MapSlab> for gpu_structs::Slab {
    fn from(slab: &MapSlab) -> Self {
        let MapSlab { curve, t_start, t_span, planes, edge_bounds } = slab;
        let curve = gpu_curve(curve, *t_start, *t_span);
        Self { curve, planes: *planes, edge_bounds: *edge_bounds }
    }
}
