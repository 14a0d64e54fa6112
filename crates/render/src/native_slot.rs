//! A shadow map in memory, drawn by the processor.

use std::sync::Arc;

use relight::{BentMapBuilder, DepthMap, StraightMapBuilder};

use crate::bendy_light::MapShape;
use crate::map_key::MapKey;
use crate::shadow_settings::MapSize;
use crate::straight;

/// What is kept of one light that the processor draws from picture to picture, whatever its shape.
#[derive(Debug)]
pub(crate) struct NativeSlot {
    size: MapSize,
    /// What the map shows, and the map.
    pub shown: Option<(MapKey, FittedMap)>,
}

/// A map, and how it is fitted.
#[derive(Debug)]
pub(crate) struct FittedMap {
    pub map: Arc<DepthMap>,
    pub fitted: MapFit,
}

/// How the map of a light is fitted to a scene.
#[derive(Debug)]
pub(crate) enum MapFit {
    /// `None` where nothing shadows the light.
    Bent(Option<Box<MapShape>>),
    Straight(straight::Fitted),
}

/// Memory of making maps, kept from one to the next.
#[derive(Debug, Default)]
pub(crate) struct NativeMapBuilders {
    pub bent: BentMapBuilder,
    pub straight: StraightMapBuilder,
}

impl NativeSlot {
    /// Of a map of that size.
    pub fn new(size: MapSize) -> Self {
        Self { size, shown: None }
    }

    /// Draws the map anew when it is next asked for.
    pub fn invalidate(&mut self) {
        self.shown = None;
    }

    /// How large its map is.
    pub fn size(&self) -> MapSize {
        self.size
    }

    /// What its map shows.
    pub fn map_key(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }

    /// Memory for a map: that of the one before where nobody looks at it any more.
    pub fn map(&mut self) -> DepthMap {
        let before = self.shown.take().and_then(|(_, shown)| Arc::into_inner(shown.map));
        before.unwrap_or_else(|| DepthMap::new(self.size.side as usize, self.size.layers as usize))
    }
}
