//! Interface by which shadow maps are drawn, on the GPU or the CPU.

use std::sync::Arc;

use relight::{BentMapBuilder, DepthMap, StraightMapBuilder};
use shadow::{MapSize, PlacedLight};

use crate::RenderError;
use crate::backend::Backend;
use crate::bendy_light::BentMapBuffers;
use crate::map_source::MapSource;
use crate::straight_map::ShadowMap;

/// Draws shadow maps of lights, on the GPU or the CPU.
pub(crate) trait MapPainter {
    /// Light with its map, as lighting passes of this backend use it.
    type Light;
    const BACKEND: Backend;

    /// Makes memory for a map of this size. Nothing is drawn yet.
    fn storage(&self, size: MapSize) -> MapStorage;

    /// Draws the map of a light with shadows.
    fn draw(
        &mut self,
        storage: &mut MapStorage,
        placed: &PlacedLight,
        source: &MapSource,
        builders: MapBuilders,
    ) -> Result<(), RenderError>;

    /// Makes a light with its drawn map.
    fn light(&self, storage: &MapStorage, placed: PlacedLight) -> Self::Light;
}

/// Depths of a map, by backend.
#[derive(Debug)]
pub(crate) enum MapStorage {
    Wgpu(ShadowMap),
    Native(Arc<DepthMap>),
}

/// Work memory of both backends, reused from one map to the next.
pub(crate) struct MapBuilders<'a> {
    pub bent_buffers: &'a mut BentMapBuffers,
    pub native: &'a mut NativeMapBuilders,
}

/// Work memory of the native backend.
#[derive(Debug, Default)]
pub(crate) struct NativeMapBuilders {
    pub bent: BentMapBuilder,
    pub straight: StraightMapBuilder,
}
