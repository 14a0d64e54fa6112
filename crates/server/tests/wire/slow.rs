//! Clients that read slowly, or while much happens at once.

use light::parameters::NAME;
use protocol::{ClientMessage, Command, Document, ServerMessage};
use serde_json::{Value, json};
use tokio::task::{JoinHandle, spawn, spawn_blocking};

use crate::client::{Client, ReceivedMessage, get, post};
use crate::server::SHARED;

/// Opens a session without a scene, with one light.
fn lit_session(name: &str, light: &Value) {
    let made = post(&SHARED, "/sessions", &json!({ "name": name }).to_string());
    assert_eq!(made.status, 201, "{}", made.text());
    assert_eq!(batch(name, &[json!({"type": "addLight", "light": light})]), [Some(1)]);
}

/// Carries out commands in one request. Returns the records' numbers.
fn batch(session: &str, commands: &[Value]) -> Vec<Option<u64>> {
    let edits: Vec<Value> = commands.iter().map(|command| json!({ "command": command })).collect();
    let answer = post(&SHARED, &format!("/sessions/{session}/edits"), &json!({ "edits": edits }).to_string());
    assert_eq!(answer.status, 200, "{}", answer.text());
    let answer = answer.json();
    answer["results"].as_array().unwrap().iter().map(|result| result["seq"].as_u64()).collect()
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
            match client.next().await {
                ReceivedMessage::Control(message) => known.apply_message(&message),
                ReceivedMessage::Frame(_) => {}
                ReceivedMessage::End => panic!("closed at record {}", known.seq),
            }
        }
        known
    })
}

/// Rules: SOCK-3, SOCK-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_reads_is_not_closed_however_much_happens() {
    const BATCH: u32 = 1_000;
    spawn_blocking(|| lit_session("busy", &json!({"type": "spot"}))).await.unwrap();
    let mut viewers = Vec::new();
    for number in 0..3 {
        let (client, welcome) = Client::join(&SHARED, "busy", &format!("viewer {number}")).await;
        let known = MirroredDocument { seq: welcome.seq, hash: welcome.hash, resyncs: 0 };
        viewers.push(watch(client, known, 1 + 4 * u64::from(BATCH)));
    }
    let send = || spawn_blocking(|| batch("busy", &cone_angles(BATCH)));
    let batches = [send(), send(), send(), send()];
    for sent in batches {
        let seqs = sent.await.unwrap();
        assert_eq!(seqs.len(), BATCH as usize);
        assert!(seqs.is_sorted() && seqs[0].is_some(), "the order of a request is kept");
    }
    let hash = spawn_blocking(|| get(&SHARED, "/sessions/busy").json()["hash"].clone()).await.unwrap();
    for viewer in viewers {
        assert_eq!(viewer.await.unwrap().hash, hash.as_str().unwrap());
    }
}

/// Rules: HTTP-6
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_long_request_does_not_make_others_wait_for_its_end() {
    spawn_blocking(|| lit_session("shared", &json!({"type": "spot"}))).await.unwrap();
    let (mut ada, _) = Client::join(&SHARED, "shared", "Ada").await;
    let long = spawn_blocking(|| batch("shared", &cone_angles(1_000)));
    let record = |came| matches!(came, ReceivedMessage::Control(ServerMessage::Log { .. })).then_some(());
    ada.until(record).await;
    let parameter = NAME.to("lamp".into()).into();
    let command = Command::SetLight { light: 1, parameter };
    ada.say(&ClientMessage::Edit { op_id: "between".into(), base_seq: 1, command }).await;
    let result = ada.until(result).await;
    let seqs = long.await.unwrap();
    assert!(result.outcome.seq() < *seqs.last().unwrap(), "{:?} of {:?}", result.outcome, seqs.last());
}

/// Rules: SOCK-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_has_not_read_for_a_while_is_told_the_outcome_and_then_its_answers() {
    // Records of 40 kB, because of their digits. 24 MB are more than the server and the system buffer for this socket.
    let third = 1.0 / 3.0;
    let points: Vec<[f64; 3]> = (0..200).map(|k| [0.0, 0.0, -third * f64::from(k)]).collect();
    let (colors, numbers) = ([[third; 3]; 200].to_vec(), [third; 200].to_vec());
    let light = json!({"type": "bendy", "points": points, "radii": numbers, "colors": colors, "intensities": numbers});
    spawn_blocking(move || lit_session("late", &light)).await.unwrap();
    let (mut ada, welcome) = Client::join_with_small_buffers(&SHARED, "late", "Ada").await;
    let insert_and_remove = || {
        let pair = [
            json!({"type": "insertPoint", "light": 1, "point": 100}),
            json!({"type": "removePoint", "light": 1, "point": 100}),
        ];
        batch("late", &pair.iter().cycle().take(600).cloned().collect::<Vec<_>>())
    };
    let last = spawn_blocking(insert_and_remove).await.unwrap().pop().flatten();
    assert_eq!(last, Some(601));
    let parameter = NAME.to("lamp".into()).into();
    let command = Command::SetLight { light: 1, parameter };
    ada.say(&ClientMessage::Edit { op_id: "late".into(), base_seq: 1, command }).await;
    let mut known = MirroredDocument { seq: welcome.seq, hash: welcome.hash, resyncs: 0 };
    let answer = ada
        .until(|came| match came {
            ReceivedMessage::Control(ServerMessage::EditResult(result)) => Some(result),
            ReceivedMessage::Control(message) => {
                known.apply_message(&message);
                None
            }
            ReceivedMessage::Frame(_) | ReceivedMessage::End => None,
        })
        .await;
    assert_eq!(answer.outcome.seq(), Some(602));
    assert_eq!((known.resyncs, known.seq), (1, 602), "an answer comes after what it refers to");
    let hash = spawn_blocking(|| get(&SHARED, "/sessions/late").json()["hash"].clone()).await.unwrap();
    assert_eq!(known.hash, hash.as_str().unwrap());
}

fn result(came: ReceivedMessage) -> Option<protocol::EditResult> {
    match came {
        ReceivedMessage::Control(ServerMessage::EditResult(result)) => Some(result),
        _ => None,
    }
}
