//! Clients that read slowly, or while much happens at once.

use light::parameters::NAME;
use protocol::{Command, Document, ServerMessage, Welcome};
use serde_json::{Value, json};
use tokio::task::{JoinHandle, spawn, spawn_blocking};

use crate::client::{Client, insert_and_remove_point, large_light, make_session, on_thread, results_of, spot, state};
use crate::server::SHARED;

/// Makes a session without a scene, and carries out a command that adds its one light.
async fn lit_session(name: &'static str, add: Value) {
    on_thread(&SHARED, move |door| {
        make_session(door, &json!({ "name": name }));
        assert_eq!(batch(name, &[add]), [Some(1)]);
    })
    .await;
}

/// Carries out commands in one request. Returns the records' numbers.
fn batch(session: &str, commands: &[Value]) -> Vec<Option<u64>> {
    let edits = commands.iter().map(|command| json!({ "command": command })).collect();
    results_of(&SHARED, session, &edits).iter().map(|result| result["seq"].as_u64()).collect()
}

/// Returns the hash of a session's document.
async fn current_hash(session: &'static str) -> Value {
    on_thread(&SHARED, move |door| state(door, session)["hash"].clone()).await
}

fn cone_angles(count: u32) -> Vec<Value> {
    let angle = |step| json!({"type": "setLight", "light": 1, "parameter": {"coneAngle": 10 + step % 50}});
    (0..count).map(angle).collect()
}

/// A session's history as a client knows it from its messages.
struct MirroredDocument {
    seq: u64,
    hash: String,
    resyncs: usize,
}

impl MirroredDocument {
    fn new(welcome: Welcome) -> Self {
        Self { seq: welcome.seq, hash: welcome.hash, resyncs: 0 }
    }

    fn apply_message(&mut self, message: &ServerMessage) {
        match message {
            ServerMessage::Log { record, hash, .. } => {
                assert_eq!(record.seq, self.seq + 1, "each record comes once and in order");
                (self.seq, self.hash) = (record.seq, hash.clone());
            }
            ServerMessage::Resync(resync) => {
                assert!(resync.seq >= self.seq, "a resync holds what was missed");
                assert_eq!(hash_of(resync.document.clone()), resync.hash);
                (self.seq, self.hash) = (resync.seq, resync.hash.clone());
                self.resyncs += 1;
            }
            _ => {}
        }
    }
}

fn hash_of(document: Document) -> String {
    document.into_domain(0).expect("a document without a scene").hash().to_string()
}

/// Reads until record `last` is known.
fn watch(mut client: Client, mut known: MirroredDocument, last: u64) -> JoinHandle<MirroredDocument> {
    spawn(async move {
        while known.seq < last {
            known.apply_message(&client.next().await.expect("the server has closed"));
        }
        known
    })
}

/// Rules: SOCK-3, SOCK-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_reads_is_not_closed_however_much_happens() {
    const BATCH: u32 = 1_000;
    lit_session("busy", spot("lamp")).await;
    let mut viewers = Vec::new();
    for number in 0..3 {
        let (client, welcome) = Client::join(&SHARED, "busy", &format!("viewer {number}")).await;
        viewers.push(watch(client, MirroredDocument::new(welcome), 1 + 4 * u64::from(BATCH)));
    }
    let send = || spawn_blocking(|| batch("busy", &cone_angles(BATCH)));
    let batches = [send(), send(), send(), send()];
    for sent in batches {
        let seqs = sent.await.unwrap();
        assert_eq!(seqs.len(), BATCH as usize);
        assert!(seqs.is_sorted() && seqs[0].is_some(), "the order of a request is kept");
    }
    let hash = current_hash("busy").await;
    for viewer in viewers {
        assert_eq!(viewer.await.unwrap().hash, hash);
    }
}

/// Rules: HTTP-6
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_long_request_does_not_make_others_wait_for_its_end() {
    lit_session("shared", spot("lamp")).await;
    let (mut ada, _) = Client::join(&SHARED, "shared", "Ada").await;
    let long = spawn_blocking(|| batch("shared", &cone_angles(1_000)));
    ada.until(|message| matches!(message, ServerMessage::Log { .. }).then_some(())).await;
    ada.say_edit("between", 1, rename()).await;
    let outcome = ada.outcome("between").await;
    let seqs = long.await.unwrap();
    assert!(outcome.seq() < *seqs.last().unwrap(), "{outcome:?} of {:?}", seqs.last());
}

/// Rules: SOCK-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_has_not_read_for_a_while_gets_the_current_state_and_then_its_answers() {
    // 24 MB of records are more than the server and the system buffer for this socket.
    lit_session("late", large_light()).await;
    let (mut ada, welcome) =
        Client::connect_with_small_buffers(&SHARED).await.greet(&SHARED, "late", "Ada").await.expect("a welcome");
    let pairs = insert_and_remove_point().into_iter().cycle().take(600).collect::<Vec<_>>();
    let last = spawn_blocking(move || batch("late", &pairs)).await.unwrap().pop().flatten();
    assert_eq!(last, Some(601));
    ada.say_edit("late", 1, rename()).await;
    let mut known = MirroredDocument::new(welcome);
    let result_in = |message| match message {
        ServerMessage::EditResult(result) => Some(result),
        message => {
            known.apply_message(&message);
            None
        }
    };
    let answer = ada.until(result_in).await;
    assert_eq!(answer.outcome.seq(), Some(602));
    assert_eq!((known.resyncs, known.seq), (1, 602), "an answer comes after what it refers to");
    assert_eq!(current_hash("late").await, known.hash);
}

/// Returns a command that changes no picture.
fn rename() -> Command {
    Command::SetLight { light: 1, parameter: NAME.to("lamp".into()).into(), ignore_pins: false }
}
