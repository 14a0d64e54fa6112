//! Measured backends: the requested one, and wgpu if that is another.

use std::sync::Arc;

use render::{Backend, Gpu, MemoryBudget, RenderError, Renderer, StageCost, Stopwatch};
use scene::PosedScene;

use super::subject::FrameRequest;

/// A device, and a renderer on it with one backend.
pub(super) struct MeasuredBackend {
    pub gpu: Arc<Gpu>,
    pub renderer: Renderer,
}

impl MeasuredBackend {
    /// Returns the name of the backend in reports.
    pub fn backend(&self) -> &'static str {
        self.gpu.backend().name()
    }
}

/// Returns the `wanted` backend, or that of the device if `None`, and then wgpu if that is another.
pub(crate) fn backends(wanted: Option<Backend>) -> Result<Vec<Backend>, RenderError> {
    let main = match wanted {
        Some(backend) => backend,
        None => Gpu::open(MemoryBudget::default(), None)?.backend(),
    };
    Ok([main].into_iter().chain((main != Backend::Wgpu).then_some(Backend::Wgpu)).collect())
}

/// Opens the [`backends`], each with `scene`.
pub(super) fn open_backends(
    wanted: Option<Backend>,
    scene: &Arc<PosedScene>,
) -> Result<Vec<MeasuredBackend>, RenderError> {
    let open = |backend| {
        let gpu = Arc::new(Gpu::open(MemoryBudget::default(), Some(backend))?);
        let mut renderer = Renderer::new(Arc::clone(&gpu))?;
        renderer.set_scene(scene)?;
        Ok(MeasuredBackend { gpu, renderer })
    };
    backends(wanted)?.into_iter().map(open).collect()
}

/// Draws a whole frame. Returns its bytes and its time.
pub(super) fn timed(renderer: &mut Renderer, frame: &FrameRequest) -> Result<(Vec<u8>, StageCost), RenderError> {
    let mut watch = Stopwatch::start();
    let bytes = renderer.render_display(&frame.view, &frame.lights)?;
    Ok((bytes, watch.lap()))
}
