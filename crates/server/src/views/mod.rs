//! Views of a session's clients: a client has its own view or follows another client's.
//!
//! Views know no room. They get the clients' requests and the state of the session, and put messages into outboxes.

mod detail;
mod frame;
mod moving_pixels;
mod pictures;
mod settings;
mod view;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use protocol::{Interaction, ServerMessage, ViewSource};
use scene::{Camera, PosedScene};
use stream::{FramePacer, ViewContent};
use tokio::task::JoinSet;
use tokio::time::Instant;

use crate::ServerError;
use crate::backend::Services;
use crate::charges::Payer;
use crate::limits::{INTERACTIVE_FOR, STALE_TIME_PER_CLIENT};
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::RenderLease;
use frame::{EncodedFrame, FrameId, ViewStepResult};
pub use moving_pixels::MovingPixels;
pub use settings::ViewSettings;
use view::{ClientView, ViewTarget};

/// The views of one session.
pub struct Views {
    viewers: BTreeMap<ClientId, Viewer>,
    /// Counts changes of the content of views.
    content_revision: u64,
    /// Pictures in progress.
    pictures: JoinSet<ViewStepResult>,
    /// Number of pictures made so far.
    picture_count: u64,
    name: Arc<str>,
    /// Keeps the session's data in the renderer.
    session: Arc<RenderLease>,
    backend: Services,
}

/// Current state of the session, which the views show.
#[derive(Clone, Copy)]
pub struct LiveSession<'a> {
    /// The session's document with its live gestures.
    pub session: &'a edit::Session,
    /// The posed scene.
    pub scene: &'a Arc<PosedScene>,
    /// Counts changes of live gestures. Frames carry it.
    pub revision: u32,
}

/// State of a client for its frames.
struct Viewer {
    /// Client that is charged for pictures of this client's own view.
    payer: Payer,
    source: ViewTarget,
    /// Source and size of the view that the client was last told.
    configured: Option<(ClientId, [u32; 2])>,
    pace: FramePacer,
    /// Number of the client's latest frame. The next field is the latest frame that needs no earlier one.
    frame: u64,
    last_key_frame: u64,
    /// True if the client gets statistics of each frame.
    wants_stats: bool,
    /// Number of the picture that was last sent to the client, or that was the latest one when the client opened its
    /// view.
    latest_picture: u64,
    /// Picture that the client shows, if all of its tiles were sent.
    shown_frame: Option<FrameId>,
    /// Picture that is being sent to the client.
    sending: Option<OutgoingFrame>,
    /// Time at which the client last changed the document or its view.
    last_interaction: Option<Instant>,
}

/// Picture that is being sent to a client, tile by tile.
struct OutgoingFrame {
    picture: Arc<EncodedFrame>,
    /// Number of the frame.
    frame: u64,
    is_key_frame: bool,
    /// True if the picture existed before, and nothing was drawn for this client.
    is_reused: bool,
    /// Number of tiles sent, their bytes, and the time of the latest.
    sent: usize,
    bytes: usize,
    sent_at: std::time::Instant,
}

impl Viewer {
    fn new(payer: Payer, source: ViewTarget, pace: FramePacer) -> Self {
        let (configured, shown_frame, sending, last_interaction) = (None, None, None, None);
        let (frame, last_key_frame, wants_stats, latest_picture) = (0, 0, false, 0);
        Self {
            payer,
            source,
            configured,
            pace,
            frame,
            last_key_frame,
            wants_stats,
            latest_picture,
            shown_frame,
            sending,
            last_interaction,
        }
    }
}

impl Views {
    /// Makes the views of session `name`, without clients. `session` keeps the session's data in the renderer.
    pub fn new(backend: Services, name: Arc<str>, session: Arc<RenderLease>) -> Self {
        let (viewers, pictures) = (BTreeMap::new(), JoinSet::new());
        Self { viewers, content_revision: 0, pictures, picture_count: 0, name, session, backend }
    }

    /// Adds a client of that actor. It has no view yet.
    pub fn insert(&mut self, id: ClientId, actor_id: &str) {
        let (source, pace) = (ViewTarget::Nothing, FramePacer::new());
        self.viewers.insert(id, Viewer::new(Payer::new(&self.name, actor_id), source, pace));
    }

    /// Removes a client. Each follower gets its own copy of the view.
    pub fn remove(&mut self, gone: ClientId) {
        let Some(Viewer { source, .. }) = self.viewers.remove(&gone) else { return };
        let content = self.new_content();
        for viewer in self.viewers.values_mut() {
            if !matches!(viewer.source, ViewTarget::Follow(leader) if leader == gone) {
                continue;
            }
            viewer.source = match &source {
                ViewTarget::Own(view) => {
                    let (camera, lease) = (view.camera.clone(), self.backend.renders.lease());
                    let from = (camera, view.camera_revision);
                    let how = (view.settings.clone(), view.detail_choice.interaction());
                    let view = ClientView::new(from, how, view.size, content, lease);
                    ViewTarget::Own(Box::new(view))
                }
                ViewTarget::Follow(leader) => ViewTarget::Follow(*leader),
                ViewTarget::Nothing => ViewTarget::Nothing,
            };
            viewer.configured = None;
        }
    }

    /// Opens a view for a client, which replaces the client's earlier view. `camera` comes with the client's revision
    /// number of it. `how` has the view's settings and the details that may be reduced while something moves. `size` is
    /// the width and height in pixels.
    pub fn open(
        &mut self,
        id: ClientId,
        camera: (Camera, u32),
        how: (ViewSettings, Interaction),
        size: [u32; 2],
    ) {
        let (content, lease) = (self.new_content(), self.backend.renders.lease());
        let Some(viewer) = self.viewers.get_mut(&id) else { return };
        let view = ClientView::new(camera, how, size, content, lease);
        viewer.source = ViewTarget::Own(Box::new(view));
        viewer.configured = None;
    }

    /// Shows a client the view of another. Gives an error if the clients would follow each other in a circle.
    pub fn follow(&mut self, id: ClientId, leader: ClientId) -> Result<(), ServerError> {
        if self.follows_to(leader, id) {
            let sentence = "that view is your own, or follows it: open one with a camera of its own";
            return Err(ServerError::BadMessage(sentence.into()));
        }
        if self.owner_of(leader).is_none() {
            let remedy = "follow one that presence lists with a camera";
            return Err(ServerError::NotFound { what: "view of client", name: leader.to_string(), remedy });
        }
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.source = ViewTarget::Follow(leader);
            viewer.configured = None;
        }
        Ok(())
    }

    /// Moves the camera of a client's own view.
    pub fn set_camera(
        &mut self,
        id: ClientId,
        camera: Camera,
        camera_revision: u32,
    ) -> Result<(), ServerError> {
        let content = self.new_content();
        let view = self.own_view(id).ok_or_else(no_view)?;
        (view.camera, view.camera_revision) = (camera, camera_revision);
        view.set_content(content, Duration::ZERO);
        Ok(())
    }

    /// Replaces the settings of a client's own view.
    pub fn set_settings(
        &mut self,
        id: ClientId,
        settings: ViewSettings,
        camera_revision: u32,
    ) -> Result<(), ServerError> {
        let content = self.new_content();
        let view = self.own_view(id).ok_or_else(no_view)?;
        (view.settings, view.camera_revision) = (settings, camera_revision);
        view.set_content(content, Duration::ZERO);
        Ok(())
    }

    /// Sets whether a client gets statistics of each frame.
    pub fn set_stats(&mut self, id: ClientId, stats: bool) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.wants_stats = stats;
        }
    }

    /// Sets the size of a client's own view in pixels. A follower sees the size of its leader's view, so nothing
    /// changes for it.
    pub fn resize(&mut self, id: ClientId, size: [u32; 2]) {
        let content = self.new_content();
        if let Some(view) = self.own_view(id).filter(|view| view.size != size) {
            (view.size, view.was_warned_smaller) = (size, false);
            view.set_content(content, Duration::ZERO);
        }
    }

    /// Notes that a client changes the document or its view. For a while its view counts as interactive.
    pub fn mark_interactive(&mut self, id: ClientId) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.last_interaction = Some(Instant::now());
        }
    }

    /// Notes a change that every picture can show.
    pub fn invalidate_all(&mut self) {
        let content = self.new_content();
        let watched_for = STALE_TIME_PER_CLIENT * self.viewers.len() as u32;
        let acts =
            |viewer: &Viewer| viewer.last_interaction.is_some_and(|then| then.elapsed() < INTERACTIVE_FOR);
        let hands = self.viewers.iter().filter(|(_, viewer)| acts(viewer));
        let of_hands: BTreeSet<ClientId> = hands.filter_map(|(id, _)| self.owner_of(*id)).collect();
        for (id, viewer) in &mut self.viewers {
            let keeps_for = if of_hands.contains(id) { Duration::ZERO } else { watched_for };
            if let Some(view) = viewer.source.own() {
                view.set_content(content, keeps_for);
            }
        }
    }

    /// Returns the client that this client follows, if any.
    pub fn leader_of(&self, id: ClientId) -> Option<ClientId> {
        match self.viewers.get(&id)?.source {
            ViewTarget::Follow(leader) => Some(leader),
            ViewTarget::Nothing | ViewTarget::Own(_) => None,
        }
    }

    /// Returns camera and settings of a client's own view, if it has one.
    pub fn view_of(&self, id: ClientId) -> Option<(&Camera, &ViewSettings)> {
        match &self.viewers.get(&id)?.source {
            ViewTarget::Own(view) => Some((&view.camera, &view.settings)),
            ViewTarget::Nothing | ViewTarget::Follow(_) => None,
        }
    }

    /// Returns camera, settings and size of the view that a client sees, its own or another client's.
    pub fn viewed_by(&self, id: ClientId) -> Option<(&Camera, &ViewSettings, [u32; 2])> {
        match &self.viewers.get(&self.owner_of(id)?)?.source {
            ViewTarget::Own(view) => Some((&view.camera, &view.settings, view.size)),
            ViewTarget::Nothing | ViewTarget::Follow(_) => None,
        }
    }

    /// Tells each client the size and source of its view if they have changed.
    pub fn configure(&mut self, outboxes: &mut Outboxes) {
        let ids: Vec<ClientId> = self.viewers.keys().copied().collect();
        for id in ids {
            let owner = self.owner_of(id);
            let configured = owner.and_then(|owner| Some((owner, self.own_view(owner)?.size)));
            let Some(viewer) = self.viewers.get_mut(&id) else { continue };
            if viewer.configured == configured || outboxes.is_behind(id) {
                continue;
            }
            if viewer.configured.map(|(owner, _)| owner) != owner {
                (viewer.pace, viewer.shown_frame, viewer.sending) = (FramePacer::new(), None, None);
                viewer.latest_picture = self.picture_count;
            }
            viewer.configured = configured;
            let source = match &viewer.source {
                ViewTarget::Nothing => continue,
                ViewTarget::Own(view) => ViewSource::Own((&view.camera).into()),
                ViewTarget::Follow(leader) => ViewSource::Follow(*leader),
            };
            if let Some((_, [width, height])) = configured {
                outboxes.send(id, &ServerMessage::ViewConfig { width, height, source });
            }
        }
    }

    /// Returns the client whose own view `id` sees, through any number of followed clients.
    fn owner_of(&self, id: ClientId) -> Option<ClientId> {
        match self.viewers.get(&id)?.source {
            ViewTarget::Nothing => None,
            ViewTarget::Own(_) => Some(id),
            ViewTarget::Follow(leader) => self.owner_of(leader),
        }
    }

    /// True if `from` and `to` are the same client, or if `from` follows `to` directly or through others.
    fn follows_to(&self, from: ClientId, to: ClientId) -> bool {
        std::iter::successors(Some(from), |id| self.leader_of(*id)).any(|id| id == to)
    }

    /// Returns all clients that see the view of `owner`, including `owner`.
    fn watchers_of(&self, owner: ClientId) -> Vec<ClientId> {
        self.viewers.keys().copied().filter(|&id| self.owner_of(id) == Some(owner)).collect()
    }

    fn own_view(&mut self, id: ClientId) -> Option<&mut ClientView> {
        self.viewers.get_mut(&id)?.source.own()
    }

    fn new_content(&mut self) -> ViewContent {
        self.content_revision += 1;
        ViewContent { revision: self.content_revision, changed_at: now() }
    }
}

fn no_view() -> ServerError {
    ServerError::BadMessage("you have no view of your own: open one, then change it".into())
}

/// Returns the current time. Tests can stop this clock.
fn now() -> std::time::Instant {
    Instant::now().into_std()
}
