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
    pub tasks: JoinSet<ServerMessage>,
    /// The client of each task and the client's name for the probe.
    askers: HashMap<Id, (ClientId, String)>,
    /// The latest question of each client whose earlier probe still runs.
    pub waiting: BTreeMap<ClientId, ProbeQuestion>,
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
            Ok(job) => {
                let (services, probe_name) = (self.services.clone(), name.clone());
                let task = self.probes.tasks.spawn(async move {
                    probe_message(probe_name, log_seq, live_revision, probe(&services, job).await)
                });
                self.probes.askers.insert(task.id(), (client, name));
            }
            Err(error) => {
                self.outboxes.send(client, &probe_message(name, log_seq, live_revision, Err(error)));
            }
        }
    }

    /// Sends the answer of a probe that has ended, and starts the client's waiting question.
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
        let ProbeQuestion { camera, size, pixel, wants_highlights, .. } = question;
        let document = self.session.live_document();
        let view = self.views.parameters_seen_by(client);
        let no_view =
            || ServerError::bad_message("you have no view to look into: open one, or name a camera and a size");
        let camera = match camera {
            Some(choice) => chosen_camera(choice, &document)?,
            None => view.ok_or_else(no_view)?.camera.clone(),
        };
        let size = size.or_else(|| Some(view?.size)).ok_or_else(no_view)?;
        let lights = document.light_instances();
        let muted = view.map(|view| view.settings.hidden_lights(&lights)).unwrap_or_default();
        Ok(ProbeJob { camera, size, pixel, wants_highlights, lights, muted, scene: self.scene.decoded.clone() })
    }
}

fn probe_message(name: String, log_seq: u64, live_revision: u32, found: Result<Probed, ServerError>) -> ServerMessage {
    let (found, refused) = match found {
        Ok(found) => (Some(found), None),
        Err(error) => (None, Some(error.problem())),
    };
    ServerMessage::Probed(Box::new(ProbeAnswer { probe: name, log_seq, live_revision, found, refused }))
}
