//! Probes and picks: rays through a scene, outside the serving tasks.

use std::collections::BTreeSet;
use std::sync::Arc;

use document::{CameraId, Document};
use drag::{Viewport, highlight_near};
use glam::{DVec2, DVec3};
use light::{LightId, LightInstance};
use protocol::{ProbeCamera, Probed, RenderLimits};
use raycast::Bvh;
use reference::{LightState, Reference};
use scene::{Camera, View, ViewRay};

use crate::ServerError;
use crate::background;
use crate::request::valid_camera;
use crate::scenes::DecodedScene;
use crate::services::Services;

/// A pixel to probe.
#[derive(Clone, Debug)]
pub struct ProbeJob {
    pub camera: Camera,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Pixels from the top left corner.
    pub pixel: [f64; 2],
    /// True if the answer has to contain the positions of highlights.
    pub wants_highlights: bool,
    pub lights: Vec<LightInstance>,
    /// Lights that the view hides.
    pub muted: BTreeSet<LightId>,
    pub scene: DecodedScene,
}

/// Returns the camera of the probe: one of the document, or the one in the request.
pub fn chosen_camera(choice: ProbeCamera, document: &Document) -> Result<Camera, ServerError> {
    match choice {
        ProbeCamera::Own(camera) => valid_camera(camera),
        ProbeCamera::Id(id) => document.cameras().get(&CameraId(id)).cloned().ok_or_else(|| {
            let remedy = "give the id of one of the document's";
            ServerError::NotFound { what: "camera", name: id.to_string(), remedy }
        }),
    }
}

/// Finds the reasons why a pixel is lit or not, for each light.
pub async fn probe(services: &Services, probe: ProbeJob) -> Result<Probed, ServerError> {
    let size = RenderLimits::HTTP.check_size(probe.size)?;
    let follow = move |bvh| {
        let reference = Reference::for_point_queries(bvh);
        let viewport = Viewport { camera: probe.camera.clone(), size };
        let view = View::beauty(probe.camera, size);
        let found = reference.probe(&view, probe.pixel.into(), &probe.lights, &probe.muted)?;
        Ok(Probed::new(&found, &reference.bvh.posed, |light| {
            let shows = probe.wants_highlights && light.state == LightState::Lit;
            let centre = || highlight_near(&reference.bvh, &viewport, &light.light.light, probe.pixel.into());
            shows.then(centre).flatten().map(Into::into)
        }))
    };
    follow_rays(services, &probe.scene, follow).await?
}

/// Finds the point in the middle of a camera's picture, in world space. Returns `None` if there is no surface.
pub async fn pick(services: &Services, camera: Camera, scene: &DecodedScene) -> Result<Option<DVec3>, ServerError> {
    let follow = move |bvh: Arc<Bvh>| {
        let origin_in_world = bvh.posed.origin_in_world;
        let ray = ViewRay::new(&camera, [1, 1], DVec2::splat(0.5), origin_in_world);
        bvh.visible_point(&ray).map(|seen| seen.position + origin_in_world)
    };
    follow_rays(services, scene, follow).await
}

/// Traces rays through a scene in the background. A few run at once over all sessions, and others wait.
async fn follow_rays<T: Send + 'static>(
    services: &Services,
    scene: &DecodedScene,
    follow: impl FnOnce(Arc<Bvh>) -> T + Send + 'static,
) -> Result<T, ServerError> {
    let bvh = scene.bvh().await?;
    let permit = Arc::clone(&services.probes).acquire_owned().await.map_err(|_| ServerError::Internal)?;
    background::run_with(permit, move || follow(bvh)).await.map(|(found, _)| found)
}
