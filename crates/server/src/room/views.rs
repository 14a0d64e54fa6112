//! What clients look at: views of their own, and others'.

use std::sync::Arc;

use light::OutOfReach;
use protocol::{ServerMessage, ViewSource};
use scene::Camera;
use stream::{Content, Pace, Quality};
use tokio::task::AbortHandle;

use super::Room;
use super::message::ClientId;
use super::pictures::Frame;
use crate::ServerError;
use crate::renderer::Lease;

/// What a client looks at.
pub(super) enum Source {
    /// Nothing yet.
    Nothing,
    /// A view of its own.
    Own(Box<View>),
    /// What another sees.
    Follow(ClientId),
}

/// A camera and what it is shown of.
pub(super) struct View {
    pub camera: Camera,
    pub camera_revision: u32,
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
pub(super) struct UnderWay {
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

impl Room {
    pub(super) fn open_view(&mut self, id: ClientId, camera: Camera, camera_revision: u32, size: [u32; 2]) {
        let (content, lease) = (self.new_content(), self.backend.renders.lease());
        let Some(client) = self.clients.get_mut(&id) else { return };
        let view = View::new((camera, camera_revision), size, content, lease);
        client.source = Source::Own(Box::new(view));
        client.shown = None;
        self.presence_changed = true;
    }

    pub(super) fn follow(&mut self, id: ClientId, leader: ClientId) {
        let error = if self.leads_to(leader, id) {
            let sentence = "that view is your own, or follows it: open one with a camera of its own";
            Some(ServerError::BadMessage(sentence.into()))
        } else if self.owner_of(leader).is_none() {
            let remedy = "follow one that presence lists with a camera";
            Some(ServerError::NotFound { what: "view of client", name: leader.to_string(), remedy })
        } else {
            None
        };
        if let Some(error) = error {
            return self.complain_to(id, &error);
        }
        let Some(client) = self.clients.get_mut(&id) else { return };
        client.source = Source::Follow(leader);
        client.shown = None;
        self.presence_changed = true;
    }

    pub(super) fn set_camera(&mut self, id: ClientId, camera: Camera, camera_revision: u32) {
        let content = self.new_content();
        let Some(view) = self.own_view(id) else {
            let sentence = "you have no view of your own: open one, then move its camera";
            return self.complain_to(id, &ServerError::BadMessage(sentence.into()));
        };
        (view.camera, view.camera_revision) = (camera, camera_revision);
        view.touch(content);
        self.presence_changed = true;
    }

    /// The size of a view of one's own. Who follows another sees that one's size, and so nothing changes.
    pub(super) fn resize_view(&mut self, id: ClientId, size: [u32; 2]) {
        let content = self.new_content();
        if let Some(view) = self.own_view(id).filter(|view| view.size != size) {
            view.size = size;
            view.touch(content);
        }
    }

    /// Something changed that every picture can show.
    pub(super) fn touch_views(&mut self) {
        let content = self.new_content();
        for view in self.clients.values_mut().filter_map(|client| client.source.own()) {
            view.touch(content);
        }
    }

    /// Who looked at what `gone` looked at goes on from there.
    pub(super) fn hand_over(&mut self, gone: ClientId, source: &Source) {
        let content = self.new_content();
        for client in self.clients.values_mut() {
            if !matches!(client.source, Source::Follow(leader) if leader == gone) {
                continue;
            }
            client.source = match source {
                Source::Own(view) => {
                    let (camera, lease) = (view.camera.clone(), self.backend.renders.lease());
                    let view = View::new((camera, view.camera_revision), view.size, content, lease);
                    Source::Own(Box::new(view))
                }
                Source::Follow(leader) => Source::Follow(*leader),
                Source::Nothing => Source::Nothing,
            };
            client.shown = None;
        }
    }

    /// Tells each client how its view is served, where that has changed.
    pub(super) fn configure_views(&mut self) {
        let ids: Vec<ClientId> = self.clients.keys().copied().collect();
        for id in ids {
            let owner = self.owner_of(id);
            let shown = owner.and_then(|owner| Some((owner, self.own_view(owner)?.size)));
            let Some(client) = self.clients.get_mut(&id) else { continue };
            if client.shown == shown || client.lane.is_behind() {
                continue;
            }
            if client.shown.map(|(owner, _)| owner) != owner {
                client.pace = Pace::new();
            }
            client.shown = shown;
            let source = match &client.source {
                Source::Nothing => continue,
                Source::Own(view) => ViewSource::Own((&view.camera).into()),
                Source::Follow(leader) => ViewSource::Follow(*leader),
            };
            if let Some((_, [width, height])) = shown {
                client.lane.say(&ServerMessage::ViewConfig { width, height, source });
            }
        }
    }

    /// The client whose own view `id` sees in the end. Nobody follows in a circle.
    fn owner_of(&self, id: ClientId) -> Option<ClientId> {
        match self.clients.get(&id)?.source {
            Source::Nothing => None,
            Source::Own(_) => Some(id),
            Source::Follow(leader) => self.owner_of(leader),
        }
    }

    /// Whether who follows `from` sees, directly or by others, what `to` looks at.
    fn leads_to(&self, from: ClientId, to: ClientId) -> bool {
        let next = |id: &ClientId| match self.clients.get(id)?.source {
            Source::Follow(leader) => Some(leader),
            Source::Nothing | Source::Own(_) => None,
        };
        std::iter::successors(Some(from), next).any(|id| id == to)
    }

    /// Who sees the view of `owner`, itself included.
    pub(super) fn watchers_of(&self, owner: ClientId) -> Vec<ClientId> {
        self.clients.keys().copied().filter(|&id| self.owner_of(id) == Some(owner)).collect()
    }

    pub(super) fn own_view(&mut self, id: ClientId) -> Option<&mut View> {
        self.clients.get_mut(&id)?.source.own()
    }

    fn new_content(&mut self) -> Content {
        self.content_revision += 1;
        Content { revision: self.content_revision, changed_at: super::now() }
    }
}

impl Source {
    pub(super) fn own(&mut self) -> Option<&mut View> {
        match self {
            Self::Own(view) => Some(view),
            Self::Nothing | Self::Follow(_) => None,
        }
    }
}

impl View {
    fn new(
        (camera, camera_revision): (Camera, u32),
        size: [u32; 2],
        content: Content,
        lease: Arc<Lease>,
    ) -> Self {
        let (latest, under_way, failed, left_out) = (None, None, None, Vec::new());
        Self { camera, camera_revision, size, content, latest, under_way, failed, left_out, lease }
    }

    /// It shows something else from now on. A lossless picture of what it showed is given up.
    fn touch(&mut self, content: Content) {
        self.content = content;
        self.under_way.take_if(|job| job.quality == Quality::Settled);
    }
}
