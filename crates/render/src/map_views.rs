//! Projections of a straight light's map, for both backends.

use glam::DMat4;

use crate::camera::columns;
use crate::gpu_structs;

/// Projections of the faces of a light's map.
#[derive(Clone, Debug)]
pub(crate) struct MapViews {
    pub light_from_scene: DMat4,
    /// Distance of the near plane in world units; `None` for parallel rays.
    pub near: Option<f64>,
    /// Projections, one per face; `None` for a face without casters.
    pub clip_from_light: Vec<Option<DMat4>>,
}

impl MapViews {
    /// Returns the uniforms, one per face of the map; `None` for a face without casters.
    pub fn shadow_views(&self) -> Vec<Option<gpu_structs::ShadowView>> {
        let view = |clip_from_light: &DMat4| {
            let clip_from_scene = columns(&(*clip_from_light * self.light_from_scene));
            gpu_structs::ShadowView { clip_from_scene }
        };
        self.clip_from_light.iter().map(|face| face.as_ref().map(view)).collect()
    }
}
