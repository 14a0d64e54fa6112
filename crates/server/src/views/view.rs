//! A view, and a client's choice of view.

use std::sync::Arc;
use std::time::{Duration, Instant};

use light::UndrawableLight;
use stream::{FrameQuality, ViewContent};
use tokio::task::AbortHandle;

use super::detail::DetailChoice;
use super::frame::{DrawnFrame, EncodedFrame};
use crate::outboxes::ClientId;
use crate::renderer::{PictureTicket, RenderLease};
use crate::request::ViewParameters;

/// The view that a client sees.
pub enum ViewTarget {
    Nothing,
    /// The client's own view.
    Own(Box<ClientView>),
    /// The view of another client.
    Follow(ClientId),
}

/// A camera with its settings and pictures.
pub struct ClientView {
    pub parameters: ViewParameters,
    pub detail_choice: DetailChoice,
    pub content: ViewContent,
    /// Latest picture of the view.
    pub latest: Option<Arc<EncodedFrame>>,
    /// Picture that is being drawn. The next fields are the drawn picture that waits for its encoding, and the one
    /// being encoded.
    pub drawing: Option<PendingPicture>,
    pub drawn: Option<DrawnFrame>,
    pub encoding: Option<PendingPicture>,
    /// Time at which a moving picture was queued that was cancelled before drawing began. The next picture takes over
    /// its position.
    pub waits_since: Option<Instant>,
    /// Revision of content that could not be drawn. Other content may succeed.
    pub failed: Option<u64>,
    /// Lights that the view's latest lossless picture leaves out.
    pub left_out: Vec<UndrawableLight>,
    /// True if the clients that see the view were warned that its moving pictures are reduced.
    pub was_warned_smaller: bool,
    /// Keeps the view's data in the renderer.
    pub lease: Arc<RenderLease>,
}

/// A picture in progress. Dropping this cancels it.
pub struct PendingPicture {
    pub quality: FrameQuality,
    /// Revision of the content that the picture shows.
    pub revision: u64,
    /// Ticket in the renderer's queue, if it is being drawn.
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
    pub fn own(&self) -> Option<&ClientView> {
        if let Self::Own(view) = self { Some(view) } else { None }
    }

    pub fn own_mut(&mut self) -> Option<&mut ClientView> {
        if let Self::Own(view) = self { Some(view) } else { None }
    }
}

impl ClientView {
    pub fn new(parameters: ViewParameters, content: ViewContent, lease: Arc<RenderLease>) -> Self {
        Self {
            detail_choice: DetailChoice::new(parameters.interaction),
            parameters,
            content,
            latest: None,
            drawing: None,
            drawn: None,
            encoding: None,
            waits_since: None,
            failed: None,
            left_out: Vec::new(),
            was_warned_smaller: false,
            lease,
        }
    }

    /// Sets new content. Cancels a lossless picture of the old content. Also cancels a moving picture of which drawing
    /// has not begun, unless it was requested within `keeps_for`. The next picture then shows the new content and takes
    /// over the position of the cancelled one.
    pub fn set_content(&mut self, content: ViewContent, keeps_for: Duration) {
        self.content = content;
        self.drawing.take_if(|job| job.quality == FrameQuality::Settled);
        self.encoding.take_if(|job| job.quality == FrameQuality::Settled);
        self.drawn.take_if(|drawing| drawing.stamp.quality == FrameQuality::Settled);
        let is_old = |job: &&PendingPicture| job.asked_at.elapsed() >= keeps_for;
        let queued_at = self.drawing.as_ref().filter(is_old).and_then(|job| job.ticket.as_ref()?.cancel());
        if queued_at.is_some() {
            (self.drawing, self.waits_since) = (None, queued_at);
        }
    }

    /// Returns the number of the view's pictures that are drawn and not sent yet.
    pub fn encoding_count(&self) -> usize {
        usize::from(self.drawn.is_some()) + usize::from(self.encoding.is_some())
    }

    /// True if a picture of that quality of the current content is in progress or has failed.
    pub fn is_pending_or_failed(&self, quality: FrameQuality) -> bool {
        let is_it = |job: &PendingPicture| (job.quality, job.revision) == (quality, self.content.revision);
        let encoding = self.encoding.as_ref().is_some_and(is_it);
        encoding || self.drawing.is_some() || self.drawn.is_some() || self.failed == Some(self.content.revision)
    }
}
