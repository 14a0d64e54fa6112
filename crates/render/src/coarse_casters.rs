//! Casters of fewer triangles for coarse maps of bent lights: made by a thread of their own, and used once they are there.

use std::sync::Arc;
use std::thread::{self, JoinHandle};

use crate::casters::{CasterMesh, Casters};
use crate::geometry::Vertices;
use crate::gpu_scene::GpuScene;
use crate::memory::{MemoryKind, Reservation};
use crate::{Gpu, RenderError};

/// They may stray so far, of half the diagonal of the scene: a quarter of a texel of a coarse map, 1024 texels a side, that shows
/// all of it.
const SHARE_OF_SCENE: f64 = 1.0 / 2048.0;
/// And so many texels of the map that they are drawn to, where its texels are widest: its filter blends two.
const MOST_TEXELS: f64 = 2.0;
/// Coarse maps that a scene is asked for first: one that moves is another scene for each picture.
const MAPS_BEFORE_START: u32 = 3;
/// With more triangles, of those of the scene, they are not worth their memory.
const MAX_TRIANGLE_RATIO: f64 = 0.75;

/// Those of one scene.
#[derive(Debug, Default)]
pub(crate) struct CoarseCasters {
    /// Of the scene that they are, or were begun, for.
    scene_revision: u64,
    state: State,
}

#[derive(Debug)]
enum State {
    /// So many maps could have used them.
    Asked(u32),
    Making(JoinHandle<Option<CasterMesh>>),
    Made(SimplifiedCasters),
    /// They would be hardly fewer.
    NotWorthwhile,
}

/// What they are.
#[derive(Debug)]
pub(crate) struct SimplifiedCasters {
    pub casters: Casters,
    /// How far they may stray from the surface, in world units.
    pub mesh_error: f64,
    /// Counts their buffers.
    _memory: Reservation,
}

impl Default for State {
    fn default() -> Self {
        Self::Asked(0)
    }
}

impl SimplifiedCasters {
    fn new(gpu: &Gpu, scene: &GpuScene, mesh: CasterMesh) -> Result<Self, RenderError> {
        let casters = mesh.upload(gpu)?;
        let memory = gpu.memory.reserve(MemoryKind::Scenes, casters.bytes());
        Ok(Self { casters, mesh_error: mesh_error(scene), _memory: memory })
    }

    /// Whether they are close enough for a map whose texels are `texel` wide, in world units.
    pub fn is_accurate_for(&self, texel: f64) -> bool {
        self.mesh_error <= MOST_TEXELS * texel
    }
}

impl CoarseCasters {
    /// Gives their memory back where they are of a scene before that revision.
    pub fn forget_before(&mut self, scene_revision: u64) {
        if self.scene_revision != scene_revision && matches!(self.state, State::Made(_)) {
            self.state = State::default();
        }
    }

    /// Those of `scene` for one more map, where they are there: begins to make them, or takes what is made.
    pub fn get(&mut self, gpu: &Gpu, scene: &GpuScene) -> Result<Option<&SimplifiedCasters>, RenderError> {
        self.state = match std::mem::take(&mut self.state) {
            // One thread at a time, also where the scene is another by now.
            State::Making(thread) if !thread.is_finished() => {
                self.state = State::Making(thread);
                return Ok(None);
            }
            _ if self.scene_revision != scene.revision => State::default(),
            // A thread that panicked has said so.
            State::Making(thread) => match thread.join().ok().flatten() {
                Some(mesh) => State::Made(SimplifiedCasters::new(gpu, scene, mesh)?),
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
impl CoarseCasters {
    /// Whether a thread makes them, or has made them.
    pub fn is_begun(&self) -> bool {
        !matches!(self.state, State::Asked(_))
    }

    pub fn made(&mut self) -> Option<&mut SimplifiedCasters> {
        if let State::Made(coarse) = &mut self.state { Some(coarse) } else { None }
    }
}

fn mesh_error(scene: &GpuScene) -> f64 {
    SHARE_OF_SCENE * scene.posed.half_extent.length()
}

/// Begins to make them; the thread gives none where they are not worthwhile.
fn spawn_simplification(scene: &GpuScene) -> JoinHandle<Option<CasterMesh>> {
    let (posed, opaque_indices) = (Arc::clone(&scene.posed), scene.opaque_indices as usize);
    let (mesh_error, most) = (mesh_error(scene), MAX_TRIANGLE_RATIO * f64::from(scene.triangle_count));
    thread::spawn(move || {
        let vertices = Vertices::new(&posed).ok()?;
        let mesh = CasterMesh::new((&vertices, opaque_indices), mesh_error);
        Some(mesh).filter(|mesh| mesh.triangle_count() as f64 <= most)
    })
}

#[cfg(test)]
mod tests;
