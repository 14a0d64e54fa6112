//! How a straight light's map is looked at, for whoever draws it.

use glam::DMat4;

use crate::camera::columns;
use crate::gpu_structs;

/// How the faces of a light's map are drawn.
#[derive(Clone, Debug)]
pub(crate) struct MapViews {
    pub light_from_scene: DMat4,
    /// The near plane, in world units; `None` where rays are parallel.
    pub near: Option<f64>,
    /// One a face; `None` where nothing casts shadows.
    pub clip_from_light: Vec<Option<DMat4>>,
}

impl MapViews {
    /// One a face of the map; `None` where nothing casts shadows.
    pub fn shadow_views(&self) -> Vec<Option<gpu_structs::ShadowView>> {
        let view = |clip_from_light: &DMat4| {
            let clip_from_scene = columns(&(*clip_from_light * self.light_from_scene));
            gpu_structs::ShadowView { clip_from_scene }
        };
        self.clip_from_light.iter().map(|face| face.as_ref().map(view)).collect()
    }
}
