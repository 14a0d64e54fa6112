//! Measured backends: the requested one, and wgpu if that is another.

use std::sync::Arc;

use render::{Backend, Device, Host, RenderError, Renderer, StageCost, Stopwatch};
use scene::PosedScene;

use super::subject::FrameRequest;

/// A device, and a renderer on it with one backend.
pub(super) struct MeasuredBackend {
    pub device: Device,
    pub renderer: Renderer,
}

impl MeasuredBackend {
    /// Returns the name of the backend in reports.
    pub fn backend(&self) -> &'static str {
        self.device.backend().name()
    }
}

/// Returns the `wanted` backend, or that of the device if `None`, and then wgpu if that is another.
pub(crate) fn backends(wanted: Option<Backend>) -> Result<Vec<Backend>, RenderError> {
    let main = match wanted {
        Some(backend) => backend,
        None => Device::open(Host::default(), None)?.backend(),
    };
    Ok([main].into_iter().chain((main != Backend::Wgpu).then_some(Backend::Wgpu)).collect())
}

/// Opens the [`backends`], each with `scene`.
pub(super) fn open_backends(
    wanted: Option<Backend>,
    scene: &Arc<PosedScene>,
) -> Result<Vec<MeasuredBackend>, RenderError> {
    let open = |backend| {
        let device = Device::open(Host::default(), Some(backend))?;
        let mut renderer = Renderer::new(&device)?;
        renderer.set_scene(scene)?;
        Ok(MeasuredBackend { device, renderer })
    };
    backends(wanted)?.into_iter().map(open).collect()
}

/// Draws a whole frame. Returns its bytes and its time.
pub(super) fn timed(renderer: &mut Renderer, frame: &FrameRequest) -> Result<(Vec<u8>, StageCost), RenderError> {
    let mut watch = Stopwatch::start();
    let bytes = renderer.render_display(&frame.view, &frame.lights)?;
    Ok((bytes, watch.lap()))
}
