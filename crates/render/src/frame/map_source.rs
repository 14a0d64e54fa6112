//! Scene and casters from which a shadow map is drawn.

use shadow::ShadowSettings;

use super::casters::CasterSet;
use super::linked::LinkedCasters;
use super::scene_backend::SceneBackend;
use super::shared_scene::FrameScene;

/// Scene and casters of a map.
pub(crate) struct MapSource<'a, B: SceneBackend> {
    pub scene: &'a FrameScene<B>,
    /// Triangles that the light's links select; `None` if it has no links.
    pub linked: Option<&'a LinkedCasters<B>>,
    pub casting: CasterSet<'a, B>,
    pub shadows: &'a ShadowSettings,
}
