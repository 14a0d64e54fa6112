//! Simplified casters for coarse maps of bent lights. A separate thread makes them, and maps use them once they are
//! ready.

use std::sync::Arc;
use std::thread::{self, JoinHandle};

use shadow::CasterMesh;

use super::casters::Casters;
use super::geometry::Vertices;
use super::memory::{MemoryKind, Reservation};
use super::scene_backend::SceneBackend;
use super::shared_scene::FrameScene;
use crate::RenderError;

/// Largest error as a share of half the scene's diagonal: a quarter of a texel of a coarse map, with 1024 texels a
/// side, that shows the whole scene.
const SHARE_OF_SCENE: f64 = 1.0 / 2048.0;
/// Number of coarse maps that are drawn before the casters of a scene are simplified. A scene whose nodes move is a new
/// scene in each picture, and simplification would never pay off.
const MAPS_BEFORE_START: u32 = 3;
/// Largest ratio of simplified triangles to the scene's triangles at which simplified casters are kept. With more
/// triangles they save too little for the memory they take.
const MAX_TRIANGLE_RATIO: f64 = 0.75;

/// Simplified casters of a scene, which are made in the background once they are needed.
#[derive(Debug)]
pub(crate) struct CoarseCasters<B: SceneBackend> {
    /// Revision of the scene that the casters belong to.
    scene_revision: u64,
    state: State<B>,
}

#[derive(Debug)]
enum State<B: SceneBackend> {
    /// Simplification has not started. The number counts the coarse maps that could have used simplified casters.
    Asked(u32),
    Making(JoinHandle<Option<CasterMesh>>),
    Made(SimplifiedCasters<B>),
    /// Simplified casters would have hardly fewer triangles than the scene.
    NotWorthwhile,
}

#[derive(Debug)]
pub(crate) struct SimplifiedCasters<B: SceneBackend> {
    pub casters: Casters<B>,
    /// Largest distance of the casters from the surface, in world units.
    pub mesh_error: f64,
    _memory: Reservation,
}

impl<B: SceneBackend> Default for State<B> {
    fn default() -> Self {
        Self::Asked(0)
    }
}

impl<B: SceneBackend> SimplifiedCasters<B> {
    fn new(device: &B::Device, scene: &FrameScene<B>, mesh: CasterMesh) -> Result<Self, RenderError> {
        let casters = Casters::upload(device, mesh)?;
        let memory = B::host_of(device).memory.reserve(MemoryKind::Scenes, casters.bytes());
        Ok(Self { casters, mesh_error: mesh_error(scene), _memory: memory })
    }
}

impl<B: SceneBackend> Default for CoarseCasters<B> {
    fn default() -> Self {
        Self { scene_revision: 0, state: State::default() }
    }
}

impl<B: SceneBackend> CoarseCasters<B> {
    /// Frees the casters if they belong to another revision of the scene.
    pub fn forget_before(&mut self, scene_revision: u64) {
        if self.scene_revision != scene_revision && matches!(self.state, State::Made(_)) {
            self.state = State::default();
        }
    }

    /// Returns the simplified casters for one more map of `scene`, if they are ready. After some maps starts the thread
    /// that makes them, and later takes its result.
    pub fn get(
        &mut self,
        device: &B::Device,
        scene: &FrameScene<B>,
    ) -> Result<Option<&SimplifiedCasters<B>>, RenderError> {
        self.state = match std::mem::take(&mut self.state) {
            // One thread at a time, even if the scene has changed.
            State::Making(thread) if !thread.is_finished() => {
                self.state = State::Making(thread);
                return Ok(None);
            }
            _ if self.scene_revision != scene.revision => State::default(),
            // A thread that panicked has already reported it.
            State::Making(thread) => match thread.join().ok().flatten() {
                Some(mesh) => State::Made(SimplifiedCasters::new(device, scene, mesh)?),
                None => State::NotWorthwhile,
            },
            state => state,
        };
        self.scene_revision = scene.revision;
        if let State::Asked(times) = &mut self.state {
            *times += 1;
            if *times > MAPS_BEFORE_START {
                self.state = State::Making(spawn_simplification(scene));
            }
        }
        Ok(if let State::Made(coarse) = &self.state { Some(coarse) } else { None })
    }
}

#[cfg(test)]
impl<B: SceneBackend> CoarseCasters<B> {
    /// True if a thread is making simplified casters, or has made them.
    pub fn is_begun(&self) -> bool {
        !matches!(self.state, State::Asked(_))
    }

    pub fn made(&mut self) -> Option<&mut SimplifiedCasters<B>> {
        if let State::Made(coarse) = &mut self.state { Some(coarse) } else { None }
    }
}

fn mesh_error<B: SceneBackend>(scene: &FrameScene<B>) -> f64 {
    SHARE_OF_SCENE * scene.posed.half_extent.length()
}

/// Starts the thread. It returns `None` if the casters are not worthwhile.
fn spawn_simplification<B: SceneBackend>(scene: &FrameScene<B>) -> JoinHandle<Option<CasterMesh>> {
    let (posed, opaque_indices) = (Arc::clone(&scene.posed), scene.opaque_indices as usize);
    let (mesh_error, most) = (mesh_error(scene), MAX_TRIANGLE_RATIO * f64::from(scene.triangle_count));
    thread::spawn(move || {
        let vertices = Vertices::new(&posed).ok()?;
        let mesh = CasterMesh::new(&vertices.positions, &vertices.indices, opaque_indices, mesh_error);
        Some(mesh).filter(|mesh| mesh.triangle_count() as f64 <= most)
    })
}

#[cfg(test)]
mod tests;
