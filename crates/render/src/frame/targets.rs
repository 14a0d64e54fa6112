//! Targets of pictures and their content: a viewer's whole picture, or one tile of a larger one.

use glam::{DAffine3, DVec2};
use light::{LightDigest, LightId, LightInstance};
use scene::{Projection, View, ViewSlot};

use super::backend::FrameBackend;
use super::layers::Layers;
use super::memory::{Evictable, MemoryKind};
use super::pass_runs::Cause;
use super::shared_scene::SceneView;
use super::tile::Tile;
use crate::RenderError;

#[derive(Debug)]
pub(crate) struct Viewers<B: FrameBackend>(Vec<(ViewSlot, Evictable<Targets<B>>)>);

/// Surfaces, light and caches of one viewer and picture size.
#[derive(Debug)]
pub(crate) struct Targets<B: FrameBackend> {
    /// Width and height in pixels: of the tile, if the picture is drawn in tiles.
    pub size: [u32; 2],
    pub drawn: B::Targets,
    /// Key of the surfaces; `None` if they are invalid.
    surfaces_key: Option<SurfacesKey>,
    pub layers: Layers<B>,
    /// Key of the radiance: scene revision, view, tile, and lights with their digests.
    radiance_key: Option<(u64, View, Tile, Vec<LightRevision>)>,
    /// Number of samples per pixel that the radiance already contains.
    pub samples_drawn: u32,
    /// Number of lights that are already added to the next sample. `None` before that sample has begun.
    pub lights_drawn: Option<usize>,
}

/// Inputs of the surfaces that pixels show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacesKey {
    pub revision: u64,
    pub world_from_camera: DAffine3,
    pub projection: Projection,
    /// Size of the whole picture in pixels.
    pub size: [u32; 2],
    pub tile: Tile,
    /// Offset from the center of each pixel, in pixels.
    pub sample_offset: DVec2,
}

/// Light, with the digest of its values that affect pictures.
type LightRevision = (LightId, LightDigest);

impl SurfacesKey {
    /// Returns the key of the surfaces in a tile, for samples at this offset from the centers of pixels.
    fn new<B: FrameBackend>(&SceneView { scene, raster, tile }: &SceneView<B>, sample_offset: DVec2) -> Self {
        Self {
            revision: scene.revision,
            world_from_camera: raster.world_from_camera,
            projection: raster.projection,
            size: [raster.width, raster.height],
            tile,
            sample_offset,
        }
    }

    /// Returns the cause for drawing these surfaces after those with the key `before`.
    fn cause_after(&self, before: Option<&Self>) -> Cause {
        match before {
            None => Cause::First,
            Some(before) if before.revision != self.revision => Cause::Scene,
            Some(before) if (before.tile, before.sample_offset) != (self.tile, self.sample_offset) => Cause::NotKept,
            Some(_) => Cause::Camera,
        }
    }
}

impl<B: FrameBackend> Default for Viewers<B> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<B: FrameBackend> Viewers<B> {
    /// Takes the targets of the viewer of `view`, with their content if the size is unchanged. The caller must put them
    /// back.
    pub fn take(&mut self, backend: &B, view: &View) -> Result<Targets<B>, RenderError> {
        backend.check_picture_side(view.width.max(view.height))?;
        self.0.retain(|(_, targets)| targets.is_present());
        let size = [view.width, view.height];
        let kept = self.0.iter().find(|(slot, _)| *slot == view.slot).and_then(|(_, kept)| kept.take());
        if let Some(targets) = kept.filter(|targets| targets.size == size) {
            return Ok(targets);
        }
        self.drop_view(view.slot);
        backend.make_room(B::max_target_bytes(size));
        Ok(Targets::new(size))
    }

    /// Caches the targets of a viewer for its next picture.
    pub fn put(&mut self, backend: &B, slot: ViewSlot, targets: Targets<B>) {
        if let Some((_, kept)) = self.0.iter().find(|(known, _)| *known == slot) {
            kept.resize(targets.bytes());
            kept.put(targets);
        } else {
            let kept = backend.host().memory.keep(MemoryKind::Views, targets.bytes(), targets);
            self.0.push((slot, kept));
        }
    }

    /// Marks all content as invalid, and keeps the memory.
    pub fn invalidate(&mut self) {
        for (_, kept) in &self.0 {
            if let Some(mut targets) = kept.take() {
                targets.invalidate();
                kept.put(targets);
            }
        }
    }

    pub fn drop_view(&mut self, slot: ViewSlot) {
        self.0.retain(|(kept, _)| *kept != slot);
    }
}

impl<B: FrameBackend> Targets<B> {
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            drawn: B::new_targets(size),
            surfaces_key: None,
            layers: Layers::default(),
            radiance_key: None,
            samples_drawn: 0,
            lights_drawn: None,
        }
    }

    /// Returns the bytes without layers.
    pub fn bytes(&self) -> u64 {
        B::target_bytes(&self.drawn)
    }

    /// Begins a picture. Clears the progress, unless the radiance already has a part of this picture.
    pub fn begin(&mut self, revision: u64, view: &View, tile: Tile, lights: &[LightInstance]) {
        let shown = lights.iter().map(|instance| (instance.id, instance.light.revisions().picture));
        // Radiance does not include exposure: a view that differs only in exposure is only tone-mapped again.
        let shown = Some((revision, View { exposure: 0.0, ..view.clone() }, tile, shown.collect()));
        if self.radiance_key != shown {
            self.radiance_key = shown;
            (self.samples_drawn, self.lights_drawn) = (0, None);
        }
    }

    /// Draws the surfaces, unless they are there. Returns the cause if they were drawn.
    pub fn draw_surfaces(
        &mut self,
        backend: &mut B,
        scene: &SceneView<B>,
        sample_offset: DVec2,
    ) -> Result<Option<Cause>, RenderError> {
        let key = SurfacesKey::new(scene, sample_offset);
        let cause = match self.surfaces_key {
            Some(before) if before == key => return Ok(None),
            before => key.cause_after(before.as_ref()),
        };
        // Invalid until all of them are drawn.
        self.surfaces_key = None;
        self.layers.invalidate();
        backend.draw_surfaces(&mut self.drawn, scene)?;
        self.surfaces_key = Some(key);
        Ok(Some(cause))
    }

    /// Marks all content as invalid, and keeps the memory.
    pub fn invalidate(&mut self) {
        (self.surfaces_key, self.radiance_key) = (None, None);
        self.layers.invalidate();
    }
}

#[cfg(test)]
mod tests;
