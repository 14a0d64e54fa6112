//! Interface by which frames are drawn, on the GPU or the CPU.

use std::fmt::Debug;
use std::sync::Arc;

use scene::MapScale;
use shadow::{MapShape, MapSize, PlacedBent, PlacedLight};

use super::camera::SampleView;
use super::linked::LinkedCasters;
use super::map_source::MapSource;
use super::memory::Reservation;
use super::pass_runs::Cause;
use super::scene_backend::SceneBackend;
use super::shared_scene::{SceneView, SharedScene};
use crate::{Aov, RenderError};

/// Most layers or sums that one pass adds up, in `terms.wgsl`. Together with the fill this stays below every device's
/// limit of bindings. If there are more layers, intermediate sums are less work.
pub(crate) const TERMS: usize = 8;

/// Draws the frames of one renderer. It has the work memory that one frame hands to the next.
pub(crate) trait FrameBackend: SceneBackend {
    /// Depths of a shadow map.
    type Map: Debug + Send;
    /// Light with its map, ready for lookups.
    type Light: Debug;
    /// Surfaces of a view or a tile, with the light on them.
    type Targets: Debug + Send;
    /// Storage of a layer; clones share it.
    type Layer: Clone + Debug + Send;
    /// Storage of a sum of layers; clones share it.
    type Sum: Clone + Debug + Send;
    /// Terms of a picture or a sum: at least one and at most [`TERMS`] layers or sums.
    type Terms;

    const LAYER_BYTES_PER_PIXEL: u64;
    const SUM_BYTES_PER_PIXEL: u64;

    /// Makes a backend on the same device, which shares compiled pipelines.
    fn sibling(&self) -> Result<Self, RenderError>;

    /// Returns the longest side of pictures and of shadow maps, in pixels.
    fn max_side(&self) -> u32;

    /// Binds the scene of later draws.
    fn bind_scene(&mut self, scene: &SharedScene<Self>);

    /// Makes memory for a map of this size. Nothing is drawn yet.
    fn new_map(&self, size: MapSize) -> Self::Map;

    /// Draws the map of a light with shadows.
    fn draw_map(
        &mut self,
        map: &mut Self::Map,
        placed: &PlacedLight,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError>;

    /// Makes a light with its drawn map.
    fn light(&self, map: &Self::Map, placed: PlacedLight) -> Self::Light;

    /// Draws the triangles of a light's map, which has that shape, as radiance.
    fn draw_wireframe(
        &mut self,
        targets: &mut Self::Targets,
        placed: &PlacedBent,
        shape: &MapShape,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError>;

    /// Makes targets of `size` pixels. Their memory is allocated at first use.
    fn new_targets(size: [u32; 2]) -> Self::Targets;

    /// Returns the bytes of targets, without layers.
    fn target_bytes(targets: &Self::Targets) -> u64;

    /// Returns the largest number of bytes of targets of `size` pixels, without layers.
    fn max_target_bytes(size: [u32; 2]) -> u64;

    /// Sets the camera and the weight of later draws.
    fn set_sample(&mut self, view: &SampleView);

    /// Draws the surfaces of the tile.
    fn draw_surfaces(&mut self, targets: &mut Self::Targets, scene: &SceneView<Self>) -> Result<(), RenderError>;

    /// Begins a sample of `aov` without light, or with all that does not depend on lights. The first sample replaces the
    /// radiance.
    fn begin_sample(
        &mut self,
        targets: &mut Self::Targets,
        scene: &SceneView<Self>,
        aov: Aov,
        is_first: bool,
    ) -> Result<(), RenderError>;

    /// Adds the light to the sample. Its pixels are those of the whole picture.
    fn add_light(
        &mut self,
        targets: &mut Self::Targets,
        scene: &SceneView<Self>,
        aov: Aov,
        light: &ReadyLight<Self>,
    ) -> Result<(), RenderError>;

    /// Adds the sample to the radiance, unless its parts have been added already.
    fn end_sample(&mut self, targets: &mut Self::Targets, aov: Aov) -> Result<(), RenderError>;

    /// Returns the radiance of the upper left corner: linear RGBA, rows from the top.
    fn read_radiance(&mut self, targets: &Self::Targets, size: [u32; 2]) -> Result<Vec<[f32; 4]>, RenderError>;

    /// Returns the bytes of a screen for the radiance of the upper left corner, with `exposure` in stops.
    fn show_radiance(&mut self, targets: &Self::Targets, size: [u32; 2], exposure: f64)
    -> Result<Vec<u8>, RenderError>;

    /// Draws the fill as radiance for [`Self::show`]. Returns false if the fill is added there.
    fn draw_fill(&mut self, targets: &mut Self::Targets, scene: &SceneView<Self>) -> Result<bool, RenderError>;

    /// Draws the contribution of a light to `pixels`, `[x, y, width, height]`, and zero elsewhere. Reuses the storage of
    /// `over`, which is no longer needed. Records [`crate::FrameStage::Light`].
    fn draw_layer(
        &mut self,
        targets: &Self::Targets,
        scene: &SceneView<Self>,
        light: &ReadyLight<Self>,
        pixels: [u32; 4],
        over: Option<Self::Layer>,
    ) -> Result<Self::Layer, RenderError>;

    /// Draws a sum. Reuses the storage of `over`, which is no longer needed. Records [`crate::FrameStage::Sum`].
    fn draw_sum(
        &mut self,
        targets: &Self::Targets,
        terms: &Self::Terms,
        over: Option<Self::Sum>,
    ) -> Result<Self::Sum, RenderError>;

    /// Makes the terms of a sum from layers and their factors.
    fn terms_of_layers(&self, layers: &[Term<Self::Layer>]) -> Self::Terms;

    /// Makes the terms of a sum from sums, each with factor 1.
    fn terms_of_sums(&self, sums: &[Self::Sum]) -> Self::Terms;

    /// Returns the bytes of a screen for the fill plus the sum of `terms`, with `exposure` in stops.
    fn show(
        &mut self,
        targets: &Self::Targets,
        terms: Option<&Self::Terms>,
        exposure: f64,
    ) -> Result<Vec<u8>, RenderError>;

    /// Waits until all work is drawn.
    fn finish(&mut self) -> Result<(), RenderError>;

    /// Drops work that was recorded but not drawn, after an error.
    fn discard(&mut self);

    /// Lets maps be checked for their fit only after the picture, in [`Self::have_maps_fitted`].
    fn defer_fit_checks(&mut self);

    /// Returns true if all maps since [`Self::defer_fit_checks`] are valid. Otherwise they have to be drawn again.
    fn have_maps_fitted(&mut self) -> Result<bool, RenderError>;

    /// Returns an error if no picture of this device can have a side of this length.
    fn check_picture_side(&self, side: u32) -> Result<(), RenderError> {
        RenderError::check_size("the picture's width or height", side.into(), self.max_side().into())
    }
}

/// Light whose shadow map is valid, as lighting passes of the backend use it.
#[derive(Debug)]
pub(crate) struct ReadyLight<B: FrameBackend> {
    pub light: B::Light,
    /// Linear RGB factors of its layer: of the diffuse and of the specular part.
    pub factors: [[f32; 3]; 2],
    /// Rectangle of pixels that the light may reach: `[x, y, width, height]`.
    pub pixels: [u32; 4],
    /// Triangles that the light's links select; `None` if it has no links.
    pub linked: Option<Arc<LinkedCasters<B>>>,
    pub shadow_map: MapScale,
    /// Cause for which the light's shadow map was drawn; `None` if a cached map was valid.
    pub shadow_map_cause: Option<Cause>,
    /// Counts the memory of the map if the budget has no room to cache it. The map is freed together with this.
    pub transient_map: Option<Reservation>,
}

/// Layer of a picture, with the linear RGB factors of its diffuse and specular light.
#[derive(Clone, Debug)]
pub(crate) struct Term<Layer> {
    pub layer: Layer,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
}
