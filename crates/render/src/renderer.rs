//! The renderer: a scene, its caches and pictures, on the backend of its device.

use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use light::LightInstance;
use scene::{PosedScene, View, ViewSlot};

use crate::frame::shared_scene::SharedScene;
use crate::frame::tiled::{TiledRequest, TiledWork};
use crate::frame::{Frame, FrameBackend, SceneBackend};
use crate::native::Native;
use crate::wgpu::Wgpu;
use crate::{
    Device, FileNeeds, PassCounts, PassRun, Picture, Pixels, Recording, RenderError, SampleProgress, ShadowSettings,
};

/// Draws pictures of one scene at a time, for any number of viewers.
///
/// A light out of the scene's reach ([`light::SceneBounds`]) is left out of the beauty. An AOV of that light is an
/// error.
///
/// A picture reuses the work of earlier ones: each light's shadow map, and for each [`ViewSlot`] the surfaces and the
/// picture itself.
#[derive(Debug)]
pub struct Renderer(Frames);

#[derive(Debug)]
enum Frames {
    Wgpu(Box<Frame<Wgpu>>),
    Native(Box<Frame<Native>>),
}

/// Scene on a device, which any number of renderers can use. Clones share it.
#[derive(Clone, Debug)]
pub struct SceneOnDevice(SharedScenes);

#[derive(Clone, Debug)]
enum SharedScenes {
    Wgpu(Arc<SharedScene<Wgpu>>),
    Native(Arc<SharedScene<Native>>),
}

/// A picture in progress. Each tile is drawn with all its samples before the next. So the picture needs the memory of
/// one tile and of the finished pixels, regardless of its size and number of samples.
///
/// It has the pixels of [`Renderer::render`], except for the rasterizer's arithmetic at another position on the target.
/// Dropping it cancels it; [`Renderer::drop_view`] of its slot frees the rest.
#[derive(Debug)]
pub struct TiledPicture {
    request: TiledRequest,
    /// Work of the backend that draws it; `None` until drawing begins.
    wgpu: Option<TiledWork<Wgpu>>,
    native: Option<TiledWork<Native>>,
}

/// Evaluates an expression with the frame of either backend.
macro_rules! with_frame {
    ($renderer:expr, $frame:ident => $work:expr) => {
        match $renderer {
            Frames::Wgpu($frame) => $work,
            Frames::Native($frame) => $work,
        }
    };
}

impl Renderer {
    /// Makes a renderer with an empty scene.
    pub fn new(device: &Device) -> Result<Self, RenderError> {
        Ok(Self(match device {
            Device::Wgpu(gpu) => Frames::Wgpu(Box::new(Frame::new(Wgpu::new(Arc::clone(gpu))?)?)),
            Device::Native(cpu) => Frames::Native(Box::new(Frame::new(Native::new(Arc::clone(cpu)))?)),
        }))
    }

    /// Makes a renderer with an empty scene of its own that shares this one's pipelines, including those compiled
    /// later.
    pub fn with_same_pipelines(&self) -> Result<Self, RenderError> {
        Ok(Self(match &self.0 {
            Frames::Wgpu(frame) => Frames::Wgpu(Box::new(Frame::new(frame.backend.sibling()?)?)),
            Frames::Native(frame) => Frames::Native(Box::new(Frame::new(frame.backend.sibling()?)?)),
        }))
    }

    /// Sets the scene: its geometry, materials and fill. Its cameras and lights are ignored. On an error the previous
    /// scene stays.
    pub fn set_scene(&mut self, scene: &Arc<PosedScene>) -> Result<(), RenderError> {
        with_frame!(&mut self.0, frame => frame.set_scene(scene))
    }

    /// Sets a scene that another renderer on this device has uploaded, without a copy. Panics if it is on another
    /// device's backend.
    pub fn share_scene(&mut self, uploaded: SceneOnDevice) -> Result<(), RenderError> {
        match (&mut self.0, uploaded.0) {
            (Frames::Wgpu(frame), SharedScenes::Wgpu(scene)) => frame.share_scene(scene),
            (Frames::Native(frame), SharedScenes::Native(scene)) => frame.share_scene(scene),
            _ => panic!("the scene is on another backend"),
        }
    }

    /// Returns the uploaded scene, for [`Self::share_scene`].
    pub fn scene_on_device(&self) -> SceneOnDevice {
        SceneOnDevice(match &self.0 {
            Frames::Wgpu(frame) => SharedScenes::Wgpu(Arc::clone(frame.scene.shared())),
            Frames::Native(frame) => SharedScenes::Native(Arc::clone(frame.scene.shared())),
        })
    }

    /// Sets the shadow settings for later pictures. On an error the previous settings stay.
    pub fn set_shadow_settings(&mut self, shadows: ShadowSettings) -> Result<(), RenderError> {
        with_frame!(&mut self.0, frame => frame.set_shadow_settings(shadows))
    }

    /// Returns the number of runs of each pass.
    pub fn counts(&self) -> PassCounts {
        with_frame!(&self.0, frame => frame.pass_runs.counts)
    }

    /// Returns the passes that ran for the latest picture, with their causes. For a picture drawn in several slices of
    /// time, returns those of the latest slice.
    pub fn runs(&self) -> &[PassRun] {
        with_frame!(&self.0, frame => &frame.pass_runs.runs)
    }

    /// Drops a viewer's cached data and frees its memory. The viewer's next picture starts from scratch.
    pub fn drop_view(&mut self, slot: ViewSlot) {
        with_frame!(&mut self.0, frame => frame.drop_view(slot));
    }

    /// Frees the memory of dropped renderers on this device.
    pub fn free_dropped_memory(&self) {
        with_frame!(&self.0, frame => frame.backend.free_dropped_memory());
    }

    /// Releases the lights of `slot`. Their maps stay, but are the first to be evicted.
    pub fn release_view(&mut self, slot: ViewSlot) {
        with_frame!(&mut self.0, frame => frame.shadow_maps.release_view(slot));
    }

    /// Draws the raw values of `view` under `lights`.
    pub fn render(&mut self, view: &View, lights: &[LightInstance]) -> Result<Picture, RenderError> {
        with_frame!(&mut self.0, frame => frame.render(view, lights))
    }

    /// True if [`Self::render_display`] caches layers for such a picture: it has one sample per pixel, and the layers
    /// of `light_count` lights and their sums take at most half of the [`crate::MemoryBudget`].
    pub fn keeps_layers(&self, view: &View, light_count: usize) -> bool {
        with_frame!(&self.0, frame => frame.keeps_layers(view, light_count))
    }

    /// Draws the beauty of `view` under `lights` for a screen, regardless of `view.aov`: exposed, tone-mapped, sRGB,
    /// RGBA, 8 bits per channel, rows from the top.
    ///
    /// With layers ([`Self::keeps_layers`]), an edit of a factor of a light's whole radiance draws only the sum, and
    /// another edit draws the edited light. Otherwise lights are added to the picture one after another, as in
    /// [`Self::render`].
    pub fn render_display(&mut self, view: &View, lights: &[LightInstance]) -> Result<Vec<u8>, RenderError> {
        with_frame!(&mut self.0, frame => frame.render_display(view, lights))
    }

    /// Works on [`Self::render_display`] for about `aim`, until the current piece of work is done: the surfaces, a
    /// shadow map, or a light over the whole picture. Pending if work is left. Another call with the same arguments
    /// continues, and draws again only what was evicted meanwhile.
    pub fn advance_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        aim: Duration,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        with_frame!(&mut self.0, frame => frame.advance_display(view, lights, aim))
    }

    /// Draws the same picture as [`Self::render_display`], stage by stage. Each stage is submitted and waited for, so
    /// the total takes longer. The wait includes work of other threads on the same device. A stage compiles pipelines
    /// at their first use, so draw the picture once before.
    pub fn record_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
    ) -> Result<(Vec<u8>, Recording), RenderError> {
        with_frame!(&mut self.0, frame => frame.record_display(view, lights))
    }

    /// Draws `view` under `lights` in the form that files need, with the values of [`Self::render`], in the memory of
    /// one tile. Calls `sampled` with the progress after each sample of a tile and at the end.
    pub fn render_for_files(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        needs: FileNeeds,
        sampled: impl FnMut(SampleProgress),
    ) -> Result<Pixels, RenderError> {
        with_frame!(&mut self.0, frame => frame.render_for_files(view, lights, needs, sampled))
    }

    /// Works on `picture` for about `aim`, until the current piece of work is done: a shadow map, or one light over a
    /// tile. The time of these pieces determines the sizes of tiles. Returns true if the picture is finished.
    ///
    /// After an error the picture is unusable.
    pub fn advance_tiled(&mut self, picture: &mut TiledPicture, aim: Duration) -> Result<bool, RenderError> {
        let TiledPicture { request, wgpu, native } = picture;
        match &mut self.0 {
            Frames::Wgpu(frame) => frame.advance_tiled(request, wgpu, aim),
            Frames::Native(frame) => frame.advance_tiled(request, native, aim),
        }
    }

    /// Marks all cached results as invalid, and keeps their memory.
    pub fn invalidate(&mut self) {
        with_frame!(&mut self.0, frame => frame.invalidate());
    }

    /// Draws the common kinds of screen pictures once, in a small scene: drivers compile a pipeline at its first draw.
    /// Serves every renderer that shares the pipelines. The native backend has none.
    ///
    /// Each set of features of a BendyLight is a pipeline of its own. This covers lights of up to 4 segments with
    /// defaults otherwise. The first picture with other features or with an AOV waits for its pipeline.
    ///
    /// Ends early, between two pictures, if `keep_going` returns false.
    pub fn compile_pipelines(&self, keep_going: impl FnMut() -> bool) -> Result<(), RenderError> {
        match &self.0 {
            Frames::Wgpu(frame) => crate::wgpu::compile_pipelines(&frame.backend, keep_going),
            Frames::Native(_) => Ok(()),
        }
    }
}

impl TiledPicture {
    /// Begins a picture of the beauty of `view` under `lights` for a screen, regardless of `view.aov`. Nothing is drawn
    /// yet.
    pub fn for_screen(view: &View, lights: &[LightInstance]) -> Result<Self, RenderError> {
        TiledRequest::for_screen(view, lights).map(Self::new)
    }

    /// Begins a picture of `view` under `lights`, in the form that files need. Nothing is drawn yet.
    pub fn for_files(view: &View, lights: &[LightInstance], needs: FileNeeds) -> Result<Self, RenderError> {
        TiledRequest::for_files(view, lights, needs).map(Self::new)
    }

    fn new(request: TiledRequest) -> Self {
        Self { request, wgpu: None, native: None }
    }

    pub fn progress(&self) -> SampleProgress {
        self.request.progress()
    }

    /// Returns the pixels drawn so far.
    pub fn into_pixels(self) -> Pixels {
        self.request.into_pixels()
    }
}

#[cfg(test)]
impl Renderer {
    /// Returns the frame on the GPU, to inspect data and to plant faults. A test that plants a fault has to do so before
    /// the first picture.
    pub(crate) fn wgpu(&mut self) -> &mut Frame<Wgpu> {
        let Frames::Wgpu(frame) = &mut self.0 else { panic!("the renderer is on the CPU") };
        frame
    }

    /// Returns the clusters of the scene's casters, on either backend.
    pub(crate) fn clusters(&mut self) -> &mut shadow::Clusters {
        with_frame!(&mut self.0, frame => &mut Arc::make_mut(&mut frame.scene.casters).clusters)
    }

    /// Returns the frame on the CPU, as [`Self::wgpu`].
    pub(crate) fn native(&mut self) -> &mut Frame<Native> {
        let Frames::Native(frame) = &mut self.0 else { panic!("the renderer is on the GPU") };
        frame
    }
}
