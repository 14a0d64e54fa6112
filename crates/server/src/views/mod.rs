//! What each client of a session looks at: a view of its own, or another's.
//!
//! Views know no session's task. They are told what clients ask and what the session is now, and put what is to be sent
//! into outboxes.

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

/// What the clients of one session look at.
pub struct Views {
    viewers: BTreeMap<ClientId, Viewer>,
    /// Counts what views show.
    content_revision: u64,
    /// Those that are being made.
    pictures: JoinSet<ViewStepResult>,
    /// Counts those that were made.
    picture_count: u64,
    /// The session's name.
    name: Arc<str>,
    /// Keeps what the renderer has of the session's scenes.
    session: Arc<RenderLease>,
    backend: Services,
}

/// The session that views show, as it is now.
#[derive(Clone, Copy)]
pub struct LiveSession<'a> {
    /// Its document, with the gestures under way.
    pub session: &'a edit::Session,
    /// Its scene, in place.
    pub scene: &'a Arc<PosedScene>,
    /// Counts what gestures show; frames carry it.
    pub revision: u32,
}

/// A client, as views know it.
struct Viewer {
    /// Who is charged for the pictures of its own view.
    payer: Payer,
    source: ViewTarget,
    /// Whose view it is shown, and how large, as it was last sent.
    configured: Option<(ClientId, [u32; 2])>,
    /// When it gets its next frame.
    pace: FramePacer,
    /// Number of its latest frame, and of the latest that goes onto no other.
    frame: u64,
    last_key_frame: u64,
    /// Whether it is told what each frame came to.
    wants_stats: bool,
    /// Of the pictures that were made, which one it was sent last, or was the last when it began to look.
    latest_picture: u64,
    /// The picture that it was sent last, where it was sent all of it.
    shown_frame: Option<FrameId>,
    /// What it is being sent.
    sending: Option<OutgoingFrame>,
    /// When it last changed the document or its view.
    last_interaction: Option<Instant>,
}

/// A picture on its way to a client, tile by tile.
struct OutgoingFrame {
    picture: Arc<EncodedFrame>,
    /// The number of the frame.
    frame: u64,
    is_key_frame: bool,
    /// Whether it was there before: nothing had to be drawn for this client.
    is_reused: bool,
    /// The tiles that were sent, their bytes, and when the last was.
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
    /// Nobody is here yet. `name` is the session's, and `session` keeps what the renderer has of it.
    pub fn new(backend: Services, name: Arc<str>, session: Arc<RenderLease>) -> Self {
        let (viewers, pictures) = (BTreeMap::new(), JoinSet::new());
        Self { viewers, content_revision: 0, pictures, picture_count: 0, name, session, backend }
    }

    /// A client comes, an actor of that id. It looks at nothing yet.
    pub fn insert(&mut self, id: ClientId, actor_id: &str) {
        let (source, pace) = (ViewTarget::Nothing, FramePacer::new());
        self.viewers.insert(id, Viewer::new(Payer::new(&self.name, actor_id), source, pace));
    }

    /// A client goes. Who looked at its view goes on from there.
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

    /// Opens a view of a client's own, from `camera` and with its revision. `size` is its width and height in pixels.
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

    /// Shows a client what another sees. Nobody follows in a circle.
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

    /// Sets how a client's own view is.
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

    /// Says whether a client is told what each frame came to.
    pub fn set_stats(&mut self, id: ClientId, stats: bool) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.wants_stats = stats;
        }
    }

    /// Gives a client's own view another size in pixels. Who follows another sees that one's size, and so nothing changes.
    pub fn resize(&mut self, id: ClientId, size: [u32; 2]) {
        let content = self.new_content();
        if let Some(view) = self.own_view(id).filter(|view| view.size != size) {
            (view.size, view.was_warned_smaller) = (size, false);
            view.set_content(content, Duration::ZERO);
        }
    }

    /// A client changes the document or its view: for a while what it sees is seen by a hand.
    pub fn mark_interactive(&mut self, id: ClientId) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            viewer.last_interaction = Some(Instant::now());
        }
    }

    /// Something changed that every picture can show.
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

    /// Whom a client follows, if anybody.
    pub fn leader_of(&self, id: ClientId) -> Option<ClientId> {
        match self.viewers.get(&id)?.source {
            ViewTarget::Follow(leader) => Some(leader),
            ViewTarget::Nothing | ViewTarget::Own(_) => None,
        }
    }

    /// The camera of a client's own view and how that is, if it has one.
    pub fn view_of(&self, id: ClientId) -> Option<(&Camera, &ViewSettings)> {
        match &self.viewers.get(&id)?.source {
            ViewTarget::Own(view) => Some((&view.camera, &view.settings)),
            ViewTarget::Nothing | ViewTarget::Follow(_) => None,
        }
    }

    /// What a client sees, in a view of its own or another's: from where, how, and how large.
    pub fn viewed_by(&self, id: ClientId) -> Option<(&Camera, &ViewSettings, [u32; 2])> {
        match &self.viewers.get(&self.owner_of(id)?)?.source {
            ViewTarget::Own(view) => Some((&view.camera, &view.settings, view.size)),
            ViewTarget::Nothing | ViewTarget::Follow(_) => None,
        }
    }

    /// Sends each client how its view is served, where that has changed.
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

    /// The client whose own view `id` sees in the end.
    fn owner_of(&self, id: ClientId) -> Option<ClientId> {
        match self.viewers.get(&id)?.source {
            ViewTarget::Nothing => None,
            ViewTarget::Own(_) => Some(id),
            ViewTarget::Follow(leader) => self.owner_of(leader),
        }
    }

    /// Whether who follows `from` sees, directly or by others, what `to` looks at.
    fn follows_to(&self, from: ClientId, to: ClientId) -> bool {
        std::iter::successors(Some(from), |id| self.leader_of(*id)).any(|id| id == to)
    }

    /// Who sees the view of `owner`, itself included.
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

/// The clock of views, which tests can stop.
fn now() -> std::time::Instant {
    Instant::now().into_std()
}
