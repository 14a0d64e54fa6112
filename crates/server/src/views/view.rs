//! One view, and what a client looks at.

use std::sync::Arc;
use std::time::{Duration, Instant};

use light::UndrawableLight;
use protocol::Interaction;
use scene::Camera;
use stream::{FrameQuality, ViewContent};
use tokio::task::AbortHandle;

use super::detail::DetailChoice;
use super::frame::{DrawnFrame, EncodedFrame};
use super::settings::ViewSettings;
use crate::outboxes::ClientId;
use crate::renderer::{PictureTicket, RenderLease};

/// What a client looks at.
pub enum ViewTarget {
    /// Nothing yet.
    Nothing,
    /// A view of its own.
    Own(Box<ClientView>),
    /// What another sees.
    Follow(ClientId),
}

/// A camera and what it is shown of.
pub struct ClientView {
    pub camera: Camera,
    pub camera_revision: u32,
    pub settings: ViewSettings,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How fine its moving pictures are.
    pub detail_choice: DetailChoice,
    pub content: ViewContent,
    /// The latest picture that was made of it.
    pub latest: Option<Arc<EncodedFrame>>,
    /// The picture that is being drawn, the one that is drawn and waits to be encoded, and the one that is.
    pub drawing: Option<PendingPicture>,
    pub drawn: Option<DrawnFrame>,
    pub encoding: Option<PendingPicture>,
    /// Since when a moving picture waited that was given up, as it was stale before it was begun.
    pub waits_since: Option<Instant>,
    /// The revision of the content that could not be drawn; another may.
    pub failed: Option<u64>,
    /// The lights that its latest lossless picture lacks.
    pub left_out: Vec<UndrawableLight>,
    /// Whether who sees it has been told that its moving pictures are smaller than they would be.
    pub was_warned_smaller: bool,
    /// Keeps what the renderer has of it.
    pub lease: Arc<RenderLease>,
}

/// A picture that is being made; dropping this gives it up.
pub struct PendingPicture {
    pub quality: FrameQuality,
    /// Of the content that it shows.
    pub revision: u64,
    /// In line for the renderer, of one that is drawn.
    pub ticket: Option<PictureTicket>,
    pub asked_at: Instant,
    pub task: AbortHandle,
}

impl Drop for PendingPicture {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl ViewTarget {
    pub fn own(&mut self) -> Option<&mut ClientView> {
        match self {
            Self::Own(view) => Some(view),
            Self::Nothing | Self::Follow(_) => None,
        }
    }
}

impl ClientView {
    pub fn new(
        (camera, camera_revision): (Camera, u32),
        (settings, interaction): (ViewSettings, Interaction),
        size: [u32; 2],
        content: ViewContent,
        lease: Arc<RenderLease>,
    ) -> Self {
        let (latest, drawing, drawn, encoding) = (None, None, None, None);
        let (waits_since, failed, left_out, was_warned_smaller) = (None, None, Vec::new(), false);
        let detail_choice = DetailChoice::new(interaction);
        Self {
            camera,
            camera_revision,
            settings,
            size,
            detail_choice,
            content,
            latest,
            drawing,
            drawn,
            encoding,
            waits_since,
            failed,
            left_out,
            was_warned_smaller,
            lease,
        }
    }

    /// It shows something else from now on. A lossless picture of what it showed is given up, and a moving one that is not
    /// begun yet, unless it was asked for within `keeps_for`: the next is of what it shows now, and has its place in line.
    pub fn set_content(&mut self, content: ViewContent, keeps_for: Duration) {
        self.content = content;
        self.drawing.take_if(|job| job.quality == FrameQuality::Settled);
        self.encoding.take_if(|job| job.quality == FrameQuality::Settled);
        self.drawn.take_if(|drawing| drawing.stamp.quality == FrameQuality::Settled);
        let is_old = |job: &&PendingPicture| job.asked_at.elapsed() >= keeps_for;
        let given_up = self.drawing.as_ref().filter(is_old).and_then(|job| job.ticket.as_ref()?.cancel());
        if given_up.is_some() {
            (self.drawing, self.waits_since) = (None, given_up);
        }
    }

    /// How many of its pictures are drawn and not yet sent.
    pub fn encoding_count(&self) -> usize {
        usize::from(self.drawn.is_some()) + usize::from(self.encoding.is_some())
    }

    /// Whether a picture of that quality of what it shows now is on its way, or cannot be made.
    pub fn is_pending_or_failed(&self, quality: FrameQuality) -> bool {
        let is_it = |job: &PendingPicture| (job.quality, job.revision) == (quality, self.content.revision);
        let encoding = self.encoding.as_ref().is_some_and(is_it);
        encoding
            || self.drawing.is_some()
            || self.drawn.is_some()
            || self.failed == Some(self.content.revision)
    }
}
