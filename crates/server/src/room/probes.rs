//! Probes of pixels by clients: answered outside the session's task, one at a time per client, the latest next.

use std::collections::{BTreeMap, HashMap};

use protocol::{ProbeAnswer, Probed, ServerMessage};
use tokio::task::{Id, JoinError, JoinSet};

use super::Room;
use crate::ServerError;
use crate::outboxes::ClientId;
use crate::probe::{ProbeJob, chosen_camera, probe};
use crate::request::ProbeQuestion;

#[derive(Default)]
pub(super) struct Probes {
    tasks: JoinSet<ServerMessage>,
    /// The client of each task and the client's name for the probe.
    askers: HashMap<Id, (ClientId, String)>,
    /// The latest question of each client whose earlier probe still runs.
    waiting: BTreeMap<ClientId, ProbeQuestion>,
}

impl Probes {
    /// Waits for the next probe to end. Returns `None` if none runs.
    pub async fn next(&mut self) -> Option<Result<(Id, ServerMessage), JoinError>> {
        self.tasks.join_next_with_id().await
    }

    /// Drops the waiting question of a client that left.
    pub fn forget(&mut self, client: ClientId) {
        self.waiting.remove(&client);
    }
}

impl Room {
    /// Starts a probe. If one of the client still runs, keeps only the latest question until then.
    pub(super) fn ask(&mut self, client: ClientId, question: ProbeQuestion) {
        if self.probes.askers.values().any(|(asker, _)| *asker == client) {
            self.probes.waiting.insert(client, question);
            return;
        }
        let name = question.probe.clone();
        let (log_seq, live_revision) = (self.session.seq(), self.live_revision);
        match self.resolve_probe(client, question) {
            Ok(asked) => {
                let backend = self.backend.clone();
                let probe_name = name.clone();
                let task = self.probes.tasks.spawn(async move {
                    probe_message(probe_name, log_seq, live_revision, probe(&backend, asked).await)
                });
                self.probes.askers.insert(task.id(), (client, name));
            }
            Err(error) => {
                self.outboxes.send(client, &probe_message(name, log_seq, live_revision, Err(error)));
            }
        }
    }

    /// Sends the answer from [`Probes::next`], and starts the client's waiting question.
    pub(super) fn take_probe(&mut self, ended: Result<(Id, ServerMessage), JoinError>) {
        let task = ended.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let Some((client, name)) = self.probes.askers.remove(&task) else { return };
        let message = match ended {
            Ok((_, message)) => message,
            Err(fault) => {
                tracing::error!("a probe failed: {fault}");
                probe_message(name, self.session.seq(), self.live_revision, Err(ServerError::Internal))
            }
        };
        self.outboxes.send(client, &message);
        if let Some(question) = self.probes.waiting.remove(&client) {
            self.ask(client, question);
        }
    }

    /// Completes a question with the current state of the session. The default camera is that of the client's view, and
    /// lights that the view hides are left out.
    fn resolve_probe(&self, client: ClientId, question: ProbeQuestion) -> Result<ProbeJob, ServerError> {
        let ProbeQuestion { camera, size, pixel, wants_highlights: highlights, .. } = question;
        let document = self.session.live_document();
        let view = self.views.viewed_by(client);
        let no_view = || {
            let sentence = "you have no view to look into: open one, or name a camera and a size";
            ServerError::BadMessage(sentence.into())
        };
        let camera = match camera {
            Some(wanted) => chosen_camera(wanted, &document)?,
            None => view.map(|(camera, ..)| camera.clone()).ok_or_else(no_view)?,
        };
        let size = size.or_else(|| view.map(|(.., size)| size)).ok_or_else(no_view)?;
        let lights = document.light_instances();
        let muted = view.map(|(_, settings, _)| settings.hidden_lights(&lights)).unwrap_or_default();
        Ok(ProbeJob {
            camera,
            size,
            pixel,
            wants_highlights: highlights,
            lights,
            muted,
            scene: self.scene.decoded.clone(),
        })
    }
}

fn probe_message(
    name: String,
    log_seq: u64,
    live_revision: u32,
    found: Result<Probed, ServerError>,
) -> ServerMessage {
    let (found, refused) = match found {
        Ok(found) => (Some(found), None),
        Err(error) => (None, Some(error.problem())),
    };
    ServerMessage::Probed(Box::new(ProbeAnswer { probe: name, log_seq, live_revision, found, refused }))
}
