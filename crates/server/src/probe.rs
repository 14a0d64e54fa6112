//! Why a pixel is lit or not: rays, off the tasks that serve.

use std::collections::BTreeSet;
use std::sync::Arc;

use document::{CameraId, Document};
use drag::{Viewport, highlight_near};
use light::{LightId, LightInstance};
use protocol::{ProbeCamera, Probed, RenderLimits};
use reference::{LightState, Reference};
use scene::{Camera, View};

use crate::ServerError;
use crate::backend::Backend;
use crate::background;
use crate::request::valid_camera;
use crate::scenes::Decoded;

/// A point of a picture that somebody asks about.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Who looks.
    pub camera: Camera,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// In pixels from its top left corner.
    pub pixel: [f64; 2],
    /// Whether it is asked where highlights lie.
    pub highlights: bool,
    /// The lights of the document.
    pub lights: Vec<LightInstance>,
    /// Those of them that the view does not show.
    pub muted: BTreeSet<LightId>,
    /// What they light.
    pub scene: Decoded,
}

/// The camera that is asked for, of a document or of the asker's own.
pub fn chosen_camera(wanted: ProbeCamera, document: &Document) -> Result<Camera, ServerError> {
    match wanted {
        ProbeCamera::Own(camera) => valid_camera(camera),
        ProbeCamera::Id(id) => document.cameras().get(&CameraId(id)).cloned().ok_or_else(|| {
            let remedy = "give the id of one of the document's";
            ServerError::NotFound { what: "camera", name: id.to_string(), remedy }
        }),
    }
}

/// Follows the rays of a probe. A few at once do so, over all sessions; others wait.
pub async fn probe(backend: &Backend, probe: Probe) -> Result<Probed, ServerError> {
    let size = RenderLimits::HTTP.check_size(probe.size)?;
    let bvh = probe.scene.bvh().await?;
    let permit = Arc::clone(&backend.probes).acquire_owned().await.map_err(|_| ServerError::Fault)?;
    let found = background::run(move || {
        let _permit = permit;
        let reference = Reference::for_points(bvh);
        let viewport = Viewport { camera: probe.camera.clone(), size };
        let view = View::beauty(probe.camera, size);
        let found = reference.probe(&view, probe.pixel.into(), &probe.lights, &probe.muted)?;
        Ok(Probed::new(&found, &reference.bvh.posed, |light| {
            let shows = probe.highlights && light.state == LightState::Lit;
            let centre = || highlight_near(&reference.bvh, &viewport, &light.light.light, probe.pixel.into());
            shows.then(centre).flatten().map(Into::into)
        }))
    });
    found.await?
}
