//! The directory of open sessions. One task opens and closes them, so two requests cannot race.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use edit::Actor;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::JoinHandle;

use super::RoomStart;
use super::message::{Reply, RoomHandle, RoomMessage, RoomOpening, SessionSnapshot};
use crate::ServerError;
use crate::limits::{MAX_ROOMS, ROOM_QUEUE};
use crate::services::Services;

/// Handle to the directory of open sessions.
#[derive(Clone, Debug)]
pub struct Rooms {
    requests: mpsc::Sender<DirectoryRequest>,
}

#[derive(Debug)]
enum DirectoryRequest {
    Find {
        name: String,
        reply: Reply<RoomHandle>,
    },
    /// The room of that number has been idle for a while.
    Idle {
        name: Arc<str>,
        number: u64,
    },
    Clients(oneshot::Sender<BTreeMap<Arc<str>, Vec<Actor>>>),
    /// Asks for the room of a session, without opening it.
    FindOpen {
        name: String,
        reply: oneshot::Sender<Option<RoomHandle>>,
    },
    /// Closes the room of a session without clients and deletes the session.
    Delete {
        name: String,
        reply: Reply<()>,
    },
    /// Closes all rooms and opens no more. Answered once they have ended.
    Drain(oneshot::Sender<()>),
}

struct RoomEntry {
    number: u64,
    /// `None` once the room was told to close.
    handle: Option<RoomHandle>,
    status: Arc<RoomStatus>,
    task: JoinHandle<()>,
}

/// State of an open session that the directory reads.
#[derive(Debug, Default)]
pub(super) struct RoomStatus {
    clients: Mutex<Vec<Actor>>,
    /// Time of the latest message to it, in milliseconds since the server started.
    pub used_ms: AtomicU64,
}

impl RoomStatus {
    /// Sets the actor of each connected client.
    pub fn set_clients(&self, clients: Vec<Actor>) {
        *self.clients.lock().unwrap_or_else(PoisonError::into_inner) = clients;
    }

    fn clients(&self) -> Vec<Actor> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Rooms {
    /// Starts the directory. No session is open.
    pub fn start(services: Services) -> Self {
        let (requests, inbox) = mpsc::channel(ROOM_QUEUE);
        let rooms = Self { requests };
        let directory = Directory { services, rooms: rooms.clone(), entries: BTreeMap::new(), last_number: 0 };
        tokio::spawn(directory.run(inbox));
        rooms
    }

    /// Returns the room of a session, and opens the session if necessary.
    pub async fn find(&self, name: &str) -> Result<RoomHandle, ServerError> {
        self.request(|reply| DirectoryRequest::Find { name: name.into(), reply }).await??.opened().await
    }

    /// Returns the current state of a session, and opens the session if necessary.
    pub async fn snapshot(&self, name: &str) -> Result<SessionSnapshot, ServerError> {
        self.find(name).await?.request(RoomMessage::Snapshot).await
    }

    /// Returns the actor of each connected client of each open session, in the order of joining.
    pub async fn clients(&self) -> Result<BTreeMap<Arc<str>, Vec<Actor>>, ServerError> {
        self.request(DirectoryRequest::Clients).await
    }

    /// Tells the clients of a session that its title or its archived state changed. Does not open the session.
    pub async fn notify_change(&self, name: &str, title: &str, archived: bool) {
        let find = |reply| DirectoryRequest::FindOpen { name: name.into(), reply };
        // A server that stops and a session that ends have no clients to tell.
        if let Ok(Some(room)) = self.request(find).await {
            let _ = room.send(RoomMessage::Changed { title: title.into(), archived }).await;
        }
    }

    /// Deletes an archived session that has no clients.
    pub async fn delete(&self, name: &str) -> Result<(), ServerError> {
        self.request(|reply| DirectoryRequest::Delete { name: name.into(), reply }).await?
    }

    /// Closes all sessions. Returns once each has committed the requests it accepted and has answered its clients.
    pub async fn drain(&self) {
        // An error means that the directory has ended, and all rooms with it.
        let _ = self.request(DirectoryRequest::Drain).await;
    }

    /// Sends a request and waits for its answer.
    async fn request<T>(&self, request: impl FnOnce(oneshot::Sender<T>) -> DirectoryRequest) -> Result<T, ServerError> {
        let (reply, answer) = oneshot::channel();
        self.requests.send(request(reply)).await.map_err(|_| ServerError::Draining)?;
        answer.await.map_err(|_| ServerError::Draining)
    }

    /// Reports a room as idle. If the queue is full, the room reports again later.
    pub(super) fn idle(&self, name: &Arc<str>, number: u64) {
        let _ = self.requests.try_send(DirectoryRequest::Idle { name: Arc::clone(name), number });
    }
}

struct Directory {
    services: Services,
    rooms: Rooms,
    entries: BTreeMap<Arc<str>, RoomEntry>,
    last_number: u64,
}

impl Directory {
    async fn run(mut self, mut inbox: mpsc::Receiver<DirectoryRequest>) {
        while let Some(request) = inbox.recv().await {
            // The asker may have stopped waiting.
            match request {
                DirectoryRequest::Find { name, reply } => drop(reply.send(self.find(name.into()))),
                DirectoryRequest::Idle { name, number } => self.close_room(&name, number),
                DirectoryRequest::Clients(reply) => drop(reply.send(self.clients())),
                DirectoryRequest::FindOpen { name, reply } => {
                    drop(reply.send(self.entries.get(&*name).and_then(|entry| entry.handle.clone())));
                }
                DirectoryRequest::Delete { name, reply } => self.delete(name.into(), reply),
                DirectoryRequest::Drain(done) => {
                    inbox.close();
                    self.drain().await;
                    let _ = done.send(());
                    break;
                }
            }
        }
    }

    fn find(&mut self, name: Arc<str>) -> Result<RoomHandle, ServerError> {
        if let Some(handle) = self.entries.get(&name).and_then(|entry| entry.handle.as_ref())
            && !handle.inbox.is_closed()
        {
            return Ok(handle.clone());
        }
        self.entries.retain(|_, entry| !entry.task.is_finished());
        let before = self.entries.remove(&name).map(|entry| entry.task);
        self.close_unused()?;
        self.last_number += 1;
        let (number, status) = (self.last_number, Arc::new(RoomStatus::default()));
        let (sender, inbox) = mpsc::channel(ROOM_QUEUE);
        let (opening, opened) = watch::channel(RoomOpening::UnderWay);
        let start = RoomStart {
            name: Arc::clone(&name),
            number,
            status: Arc::clone(&status),
            services: self.services.clone(),
            rooms: self.rooms.clone(),
        };
        let room = super::run(start, inbox, opening, before);
        let handle = RoomHandle { inbox: sender, opening: opened };
        let entry = RoomEntry { number, handle: Some(handle.clone()), status, task: tokio::spawn(room) };
        self.entries.insert(name, entry);
        Ok(handle)
    }

    /// Makes place for one more open room. If there are too many, closes the least recently used room that only the
    /// directory can reach. That room finishes by itself, and a request for its session meanwhile waits for it.
    fn close_unused(&mut self) -> Result<(), ServerError> {
        let open = self.entries.values().filter(|entry| entry.handle.is_some()).count();
        if open < MAX_ROOMS {
            return Ok(());
        }
        let unused = |entry: &&mut RoomEntry| entry.handle.as_ref().is_some_and(RoomHandle::is_unshared);
        let candidates = self.entries.values_mut().filter(unused);
        let oldest = candidates.min_by_key(|entry| entry.status.used_ms.load(Ordering::Relaxed));
        let too_many = ServerError::TooMany { what: "open sessions", limit: MAX_ROOMS };
        oldest.ok_or(too_many)?.handle = None;
        Ok(())
    }

    /// Closes a room that only the directory can reach: its inbox ends once the directory's handle is dropped.
    fn close_room(&mut self, name: &str, number: u64) {
        if let Some(entry) = self.entries.get_mut(name)
            && entry.number == number
            && entry.handle.as_ref().is_some_and(RoomHandle::is_unshared)
        {
            entry.handle = None;
        }
    }

    fn clients(&self) -> BTreeMap<Arc<str>, Vec<Actor>> {
        self.entries.iter().map(|(name, entry)| (Arc::clone(name), entry.status.clients())).collect()
    }

    /// Deletes a session after its room has ended, if it has one. The deleting task replaces the room in the directory,
    /// so a request for the session waits for it and then finds no session.
    fn delete(&mut self, name: Arc<str>, reply: Reply<()>) {
        let people = self.entries.get(&name).map(|entry| entry.status.clients()).unwrap_or_default();
        if !people.is_empty() {
            let people = people.into_iter().map(|actor| actor.name).collect();
            return drop(reply.send(Err(ServerError::InUse { session: name.to_string(), people })));
        }
        let before = self.entries.remove(&name);
        let (session, storage) = (Arc::clone(&name), self.services.storage.clone());
        let task = tokio::spawn(async move {
            if let Some(RoomEntry { handle, task, .. }) = before {
                if let Some(handle) = handle {
                    // The room finishes the requests of programs. A room that has ended needs no message.
                    let _ = handle.send(RoomMessage::Drain).await;
                }
                let _ = task.await;
            }
            // The asker may have stopped waiting.
            let _ = reply.send(storage.run_exclusive(move |store| store.delete_session(&session)).await);
        });
        self.last_number += 1;
        let (number, status) = (self.last_number, Arc::default());
        self.entries.insert(name, RoomEntry { number, handle: None, status, task });
    }

    async fn drain(&mut self) {
        for handle in self.entries.values().filter_map(|entry| entry.handle.as_ref()) {
            // A room that has ended needs no message.
            let _ = handle.send(RoomMessage::Drain).await;
        }
        for (_, entry) in std::mem::take(&mut self.entries) {
            let _ = entry.task.await;
        }
    }
}
