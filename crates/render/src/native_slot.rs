//! Shadow maps in CPU memory, for the native backend.

use std::sync::Arc;

use relight::{BentMapBuilder, DepthMap, StraightMapBuilder};

use crate::bendy_light::MapShape;
use crate::map_key::MapKey;
use crate::shadow_settings::MapSize;
use crate::straight;

/// Cached shadow map of one light on the native backend, for lights of any shape.
#[derive(Debug)]
pub(crate) struct NativeSlot {
    size: MapSize,
    /// Key of the cached map, and the map. `None` before the first one is drawn.
    pub shown: Option<(MapKey, FittedMap)>,
}

#[derive(Debug)]
pub(crate) struct FittedMap {
    pub map: Arc<DepthMap>,
    pub fitted: MapFit,
}

/// Fit of a light's map to a scene.
#[derive(Debug)]
pub(crate) enum MapFit {
    /// `None` if the light casts no shadows.
    Bent(Option<Box<MapShape>>),
    Straight(straight::Fitted),
}

/// Work memory for drawing maps, reused from one map to the next.
#[derive(Debug, Default)]
pub(crate) struct NativeMapBuilders {
    pub bent: BentMapBuilder,
    pub straight: StraightMapBuilder,
}

impl NativeSlot {
    /// Makes an empty slot for a map of `size`.
    pub fn new(size: MapSize) -> Self {
        Self { size, shown: None }
    }

    pub fn invalidate(&mut self) {
        self.shown = None;
    }

    pub fn size(&self) -> MapSize {
        self.size
    }

    pub fn map_key(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }

    /// Returns memory for a map: that of the previous map if nothing else uses it, else new memory.
    pub fn map(&mut self) -> DepthMap {
        let before = self.shown.take().and_then(|(_, shown)| Arc::into_inner(shown.map));
        before.unwrap_or_else(|| DepthMap::new(self.size.side as usize, self.size.layers as usize))
    }
}
