//! Places lights in a scene: the triangles that cast shadows, the part of them that a light's shadow map shows, and the
//! projections of that map, for every shape of light and for both backends.
//!
//! The crate knows no device. `render` draws the maps that it describes, on the GPU or by `relight`.
//!
//! Begin with [`PlacedLight`] in `placed.rs`, the one place that tells the shapes of lights apart. `casters` has the
//! triangles and the boxes around them, `straight` the maps of lights with straight rays, `bent` those of BendyLights.
//! Bent and straight share casters and settings and nothing else, so each can test the other.

mod bent;
mod bounds;
mod casters;
mod placed;
mod settings;
mod straight;

pub use bent::{
    BoxedSlab, CastersNearSlabs, MapShape, PlacedBent, slab_bounds, slabs, slabs_of_map, t_max, tube_from_scene,
};
pub use casters::{
    CasterMesh, ClusterBounds, ClusterLeaf, Clusters, TRIANGLES_PER_LEAF, TriangleComponent, VERTICES_PER_BLOCK,
    VisibleLeaves, visible_runs,
};
pub use placed::{CoarseClusters, MapFit, PlacedLight, fit_map, lit_hull_in_world, map_size, wireframe_of};
pub use settings::{Culling, InvalidSettings, MapSize, ShadowSettings};
pub use straight::{PlacedStraight, StraightCoords};
