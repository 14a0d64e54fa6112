//! A scene made ready to be looked at.

use std::sync::Arc;

use raycast::Bvh;
use scene::PosedScene;

use crate::texture::Textures;

/// A posed scene of which pictures are made.
#[derive(Debug)]
pub struct Reference {
    /// The scene and its triangles.
    pub bvh: Bvh,
    pub(crate) textures: Textures,
}

impl Reference {
    /// Prepares a scene for rays.
    pub fn new(posed: Arc<PosedScene>) -> Self {
        let textures = Textures::new(Arc::clone(&posed.scene));
        Self { bvh: Bvh::new(posed), textures }
    }
}
