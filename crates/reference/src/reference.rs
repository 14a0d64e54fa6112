//! Scene prepared for the reference renderer.

use std::sync::Arc;

use raycast::Bvh;
use scene::PosedScene;

use crate::texture::Textures;

/// Posed scene, prepared for rays.
#[derive(Debug)]
pub struct Reference {
    /// Scene and its triangles.
    pub bvh: Arc<Bvh>,
    pub(crate) textures: Textures,
}

impl Reference {
    /// Prepares a scene for whole pictures.
    pub fn new(posed: Arc<PosedScene>) -> Self {
        let textures = Textures::new(Arc::clone(&posed.scene));
        Self { bvh: Arc::new(Bvh::new(posed)), textures }
    }

    /// Uses a prepared scene for single points. It does not cache mip levels, which take ten times the bytes of
    /// the pictures in f64.
    pub fn for_point_queries(bvh: Arc<Bvh>) -> Self {
        let textures = Textures::uncached(Arc::clone(&bvh.posed.scene));
        Self { bvh, textures }
    }
}
