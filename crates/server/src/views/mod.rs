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

use protocol::{ServerMessage, ViewSource};
use scene::PosedScene;
use stream::{FramePacer, ViewContent};
use tokio::task::JoinSet;
use tokio::time::Instant;

use crate::ServerError;
use crate::charges::Payer;
use crate::limits::STALE_TIME_PER_CLIENT;
use crate::outbox::Outbox;
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::RenderLease;
use crate::request::ViewParameters;
use crate::services::Services;
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
    services: Services,
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

impl Views {
    /// Makes the views of session `name`, without clients. `session` keeps the session's data in the renderer.
    pub fn new(services: Services, name: Arc<str>, session: Arc<RenderLease>) -> Self {
        let (viewers, pictures) = (BTreeMap::new(), JoinSet::new());
        Self { viewers, content_revision: 0, pictures, picture_count: 0, name, session, services }
    }

    /// Adds a client of that actor. It has no view yet.
    pub fn insert(&mut self, id: ClientId, actor_id: &str) {
        let viewer = Viewer {
            payer: Payer::new(&self.name, actor_id),
            source: ViewTarget::Nothing,
            configured: None,
            pace: FramePacer::default(),
            frame: 0,
            last_key_frame: 0,
            wants_stats: false,
            latest_picture: 0,
            shown_frame: None,
            sending: None,
            last_interaction: None,
        };
        self.viewers.insert(id, viewer);
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
                    let lease = self.services.renders.lease();
                    ViewTarget::Own(Box::new(ClientView::new(view.parameters.clone(), content, lease)))
                }
                ViewTarget::Follow(leader) => ViewTarget::Follow(*leader),
                ViewTarget::Nothing => ViewTarget::Nothing,
            };
            viewer.configured = None;
        }
    }

    /// Opens a view for a client, which replaces the client's earlier view.
    pub fn open(&mut self, id: ClientId, parameters: ViewParameters) {
        let (content, lease) = (self.new_content(), self.services.renders.lease());
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.source = ViewTarget::Own(Box::new(ClientView::new(parameters, content, lease)));
            viewer.configured = None;
        }
    }

    /// Shows a client the view of another. Gives an error if the clients would follow each other in a circle.
    pub fn follow(&mut self, id: ClientId, leader: ClientId) -> Result<(), ServerError> {
        if self.follows_to(leader, id) {
            let sentence = "that view is your own, or follows it: open one with a camera of its own";
            return Err(ServerError::bad_message(sentence));
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

    /// Changes the camera or the settings of a client's own view.
    pub fn change(&mut self, id: ClientId, change: impl FnOnce(&mut ViewParameters)) -> Result<(), ServerError> {
        let content = self.new_content();
        let view = self.own_view(id).ok_or_else(no_view)?;
        change(&mut view.parameters);
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
        if let Some(view) = self.own_view(id).filter(|view| view.parameters.size != size) {
            (view.parameters.size, view.was_warned_smaller) = (size, false);
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
        let interactive = self.viewers.iter().filter(|(_, viewer)| viewer.is_interactive());
        let interactive: BTreeSet<ClientId> = interactive.filter_map(|(id, _)| self.owner_of(*id)).collect();
        for (id, viewer) in &mut self.viewers {
            let keeps_for = if interactive.contains(id) { Duration::ZERO } else { watched_for };
            if let Some(view) = viewer.source.own_mut() {
                view.set_content(content, keeps_for);
            }
        }
    }

    /// Returns the client that this client follows, if any.
    pub fn leader_of(&self, id: ClientId) -> Option<ClientId> {
        if let ViewTarget::Follow(leader) = self.viewers.get(&id)?.source { Some(leader) } else { None }
    }

    /// Returns camera, settings and size of a client's own view, if it has one.
    pub fn parameters_of(&self, id: ClientId) -> Option<&ViewParameters> {
        self.view_of(id).map(|view| &view.parameters)
    }

    /// Returns camera, settings and size of the view that a client sees, its own or another client's.
    pub fn parameters_seen_by(&self, id: ClientId) -> Option<&ViewParameters> {
        self.parameters_of(self.owner_of(id)?)
    }

    /// Returns a client's own view, if it has one.
    fn view_of(&self, id: ClientId) -> Option<&ClientView> {
        self.viewers.get(&id)?.source.own()
    }

    /// Tells each client the size and source of its view if they have changed.
    pub fn configure(&mut self, outboxes: &mut Outboxes) {
        let ids: Vec<ClientId> = self.viewers.keys().copied().collect();
        for id in ids {
            let owner = self.owner_of(id);
            let configured = owner.and_then(|owner| Some((owner, self.view_of(owner)?.parameters.size)));
            let Some(viewer) = self.viewers.get_mut(&id) else { continue };
            if viewer.configured == configured || outboxes.is(id, Outbox::is_behind) {
                continue;
            }
            if viewer.configured.map(|(owner, _)| owner) != owner {
                (viewer.pace, viewer.shown_frame, viewer.sending) = (FramePacer::default(), None, None);
                viewer.latest_picture = self.picture_count;
            }
            viewer.configured = configured;
            let source = match &viewer.source {
                ViewTarget::Nothing => continue,
                ViewTarget::Own(view) => ViewSource::Own((&view.parameters.camera).into()),
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
        self.viewers.get_mut(&id)?.source.own_mut()
    }

    fn new_content(&mut self) -> ViewContent {
        self.content_revision += 1;
        ViewContent { revision: self.content_revision, changed_at: now() }
    }
}

fn no_view() -> ServerError {
    ServerError::bad_message("you have no view of your own: open one, then change it")
}

/// Returns the current time. Tests can stop this clock.
fn now() -> std::time::Instant {
    Instant::now().into_std()
}
