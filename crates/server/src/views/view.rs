//! One view, and what a client looks at.

use std::sync::Arc;

use light::OutOfReach;
use scene::Camera;
use stream::{Content, Quality};
use tokio::task::AbortHandle;

use super::frame::Frame;
use super::settings::ViewSettings;
use crate::outboxes::ClientId;
use crate::renderer::Lease;

/// What a client looks at.
pub enum Source {
    /// Nothing yet.
    Nothing,
    /// A view of its own.
    Own(Box<View>),
    /// What another sees.
    Follow(ClientId),
}

/// A camera and what it is shown of.
pub struct View {
    pub camera: Camera,
    pub camera_revision: u32,
    pub settings: ViewSettings,
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub content: Content,
    /// The latest picture that was made of it.
    pub latest: Option<Arc<Frame>>,
    pub under_way: Option<UnderWay>,
    /// The revision of the content that could not be drawn; another may.
    pub failed: Option<u64>,
    /// The lights that its latest lossless picture lacks.
    pub left_out: Vec<OutOfReach>,
    /// Keeps what the renderer has of it.
    pub lease: Arc<Lease>,
}

/// A picture that is being made; dropping this gives it up.
pub struct UnderWay {
    pub quality: Quality,
    /// Of the content that it shows.
    pub revision: u64,
    pub task: AbortHandle,
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Source {
    pub fn own(&mut self) -> Option<&mut View> {
        match self {
            Self::Own(view) => Some(view),
            Self::Nothing | Self::Follow(_) => None,
        }
    }
}

impl View {
    pub fn new(
        (camera, camera_revision): (Camera, u32),
        settings: ViewSettings,
        size: [u32; 2],
        content: Content,
        lease: Arc<Lease>,
    ) -> Self {
        let (latest, under_way, failed, left_out) = (None, None, None, Vec::new());
        Self { camera, camera_revision, settings, size, content, latest, under_way, failed, left_out, lease }
    }

    /// It shows something else from now on. A lossless picture of what it showed is given up.
    pub fn touch(&mut self, content: Content) {
        self.content = content;
        self.under_way.take_if(|job| job.quality == Quality::Settled);
    }
}
