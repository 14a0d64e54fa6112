//! One view, and what a client looks at.

use std::sync::Arc;
use std::time::{Duration, Instant};

use light::OutOfReach;
use protocol::Interaction;
use scene::Camera;
use stream::{Content, Quality};
use tokio::task::AbortHandle;

use super::detail::DetailChoice;
use super::frame::{Drawing, Frame};
use super::settings::ViewSettings;
use crate::outboxes::ClientId;
use crate::renderer::{Lease, Place};

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
    /// How fine its moving pictures are.
    pub moving: DetailChoice,
    pub content: Content,
    /// The latest picture that was made of it.
    pub latest: Option<Arc<Frame>>,
    /// The picture that is being drawn, the one that is drawn and waits to be encoded, and the one that is.
    pub drawing: Option<UnderWay>,
    pub drawn: Option<Drawing>,
    pub encoding: Option<UnderWay>,
    /// Since when a moving picture waited that was given up, as it was stale before it was begun.
    pub waits_since: Option<Instant>,
    /// The revision of the content that could not be drawn; another may.
    pub failed: Option<u64>,
    /// The lights that its latest lossless picture lacks.
    pub left_out: Vec<OutOfReach>,
    /// Whether who sees it has been told that its moving pictures are smaller than they would be.
    pub is_told_smaller: bool,
    /// Keeps what the renderer has of it.
    pub lease: Arc<Lease>,
}

/// A picture that is being made; dropping this gives it up.
pub struct UnderWay {
    pub quality: Quality,
    /// Of the content that it shows.
    pub revision: u64,
    /// In line for the renderer, of one that is drawn.
    pub place: Option<Place>,
    pub asked_at: Instant,
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
        (settings, interaction): (ViewSettings, Interaction),
        size: [u32; 2],
        content: Content,
        lease: Arc<Lease>,
    ) -> Self {
        let (latest, drawing, drawn, encoding) = (None, None, None, None);
        let (waits_since, failed, left_out, is_told_smaller) = (None, None, Vec::new(), false);
        let moving = DetailChoice::new(interaction);
        Self {
            camera,
            camera_revision,
            settings,
            size,
            moving,
            content,
            latest,
            drawing,
            drawn,
            encoding,
            waits_since,
            failed,
            left_out,
            is_told_smaller,
            lease,
        }
    }

    /// It shows something else from now on. A lossless picture of what it showed is given up, and a moving one that is not
    /// begun yet, unless it was asked for within `keeps_for`: the next is of what it shows now, and has its place in line.
    pub fn touch(&mut self, content: Content, keeps_for: Duration) {
        self.content = content;
        self.drawing.take_if(|job| job.quality == Quality::Settled);
        self.encoding.take_if(|job| job.quality == Quality::Settled);
        self.drawn.take_if(|drawing| drawing.stamp.quality == Quality::Settled);
        let is_old = |job: &&UnderWay| job.asked_at.elapsed() >= keeps_for;
        let given_up = self.drawing.as_ref().filter(is_old).and_then(|job| job.place.as_ref()?.give_up());
        if given_up.is_some() {
            (self.drawing, self.waits_since) = (None, given_up);
        }
    }

    /// How many of its pictures are drawn and not yet sent.
    pub fn in_encoding(&self) -> usize {
        usize::from(self.drawn.is_some()) + usize::from(self.encoding.is_some())
    }

    /// Whether a picture of that quality of what it shows now is on its way, or cannot be made.
    pub fn has_asked_for(&self, quality: Quality) -> bool {
        let is_it = |job: &UnderWay| (job.quality, job.revision) == (quality, self.content.revision);
        let encoding = self.encoding.as_ref().is_some_and(is_it);
        encoding
            || self.drawing.is_some()
            || self.drawn.is_some()
            || self.failed == Some(self.content.revision)
    }
}
