//! A scene made ready to be looked at.

use std::sync::Arc;

use raycast::Bvh;
use scene::PosedScene;

use crate::texture::Textures;

/// A posed scene of which pictures are made.
#[derive(Debug)]
pub struct Reference {
    /// The scene and its triangles.
    pub bvh: Arc<Bvh>,
    pub(crate) textures: Textures,
}

impl Reference {
    /// Prepares a scene for rays.
    pub fn new(posed: Arc<PosedScene>) -> Self {
        let textures = Textures::new(Arc::clone(&posed.scene));
        Self { bvh: Arc::new(Bvh::new(posed)), textures }
    }

    /// Of a scene that is prepared for rays, to look at single points: it keeps nothing of textures, whose levels in f64 take
    /// ten times their pictures' bytes.
    pub fn for_point_queries(bvh: Arc<Bvh>) -> Self {
        let textures = Textures::uncached(Arc::clone(&bvh.posed.scene));
        Self { bvh, textures }
    }
}
