//! Scene and casters from which a shadow map is drawn.

use shadow::ShadowSettings;

use crate::casters::CasterSet;
use crate::gpu_scene::GpuScene;
use crate::linked::LinkedCasters;

/// Scene and casters of a map.
#[derive(Clone, Copy)]
pub(crate) struct MapSource<'a> {
    pub scene: &'a GpuScene,
    /// Triangles that the light's links select; `None` if it has no links.
    pub linked: Option<&'a LinkedCasters>,
    pub casting: CasterSet<'a>,
    pub shadows: &'a ShadowSettings,
}
