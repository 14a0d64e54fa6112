//! Repeated operations, undo past a restart, and a disk that refuses writes.

use light::parameters::CONE_ANGLE;
use protocol::{
    ClientMessage, Command, Committed, ErrorCode, GestureState, GestureStatus, Outcome, Scope, ServerMessage,
};
use rusqlite::{Connection, TransactionBehavior};
use serde_json::{Value, json};

use crate::client::{Client, edit, get, make_session, metric, new_session, post_edits, state};
use crate::server::{OwnServer, SHARED, ServerDoor};

/// Carries out edits of Ada's.
fn edits(door: &ServerDoor, session: &str, edits: &Value) -> Value {
    edit(door, session, &json!({"actor": {"id": "ada", "name": "Ada"}, "edits": edits}))
}

fn all_are_committed(answer: &Value) -> bool {
    answer["results"].as_array().expect("results").iter().all(|result| result["status"] == "committed")
}

fn cone_angle(degrees: f64) -> Command {
    Command::SetLight { light: 1, parameter: CONE_ANGLE.to(degrees).into(), ignore_pins: false }
}

async fn edited(client: &mut Client, op_id: &str, base_seq: u64, command: Command) -> Outcome {
    client.say_edit(op_id, base_seq, command).await;
    client.outcome(op_id).await
}

fn committed(seq: u64) -> Outcome {
    Outcome::Committed(Committed { seq, ..Committed::default() })
}

/// Rules: REC-4, SOCK-5
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_operation_that_comes_again_gets_its_first_answer() {
    let own = OwnServer::start().await;
    let (mut ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    let (mut ben, _) = Client::join(&own.door, "main", "Ben").await;
    let known = welcome.seq;
    let theirs = edited(&mut ben, "x", known, cone_angle(30.0)).await;
    assert_eq!(theirs, committed(known + 1));
    let rebased = edited(&mut ada, "x", known, cone_angle(31.0)).await;
    let expected = Committed { seq: known + 2, rebased: true, ..Committed::default() };
    assert_eq!(rebased, Outcome::Committed(expected), "another actor's x");
    let folded = edited(&mut ada, "y", known, cone_angle(95.0)).await;
    assert!(matches!(&folded, Outcome::Rejected(problem) if problem.code == ErrorCode::InvalidLight));
    ada.say(&ClientMessage::Undo { op_id: "z".into(), scope: Scope::Mine }).await;
    let undone = ada.outcome("z").await;
    assert_eq!(undone.seq(), Some(known + 3));
    let first = [rebased, folded, undone];

    let own = OwnServer::start_in(own.stopped().await).await;
    let (mut ada, _) = Client::join(&own.door, "main", "Ada").await;
    // The same ids with commands that would be carried out now.
    for (op_id, expected) in ["x", "y", "z"].into_iter().zip(first) {
        assert_eq!(edited(&mut ada, op_id, known + 3, cone_angle(40.0)).await, expected);
    }
    let fresh = edited(&mut ada, "w", known + 3, cone_angle(40.0)).await;
    assert_eq!(fresh.seq(), Some(known + 4), "nothing was carried out twice");
    own.stopped().await;
}

/// A page and a script of a person are one actor, whatever the name. Without the token a named actor has no access.
///
/// Rules: WHO-1, UNDO-1
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn mine_are_the_steps_of_the_named_actor_under_the_token() {
    let own = OwnServer::start().await;
    let (mut ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    assert_eq!(edited(&mut ada, "x", welcome.seq, cone_angle(30.0)).await, committed(welcome.seq + 1));
    let undo = |door: &ServerDoor, actor: Value| {
        post_edits(door, "main", &json!({"actor": actor, "edits": [{"undo": "mine"}]}))
    };
    let anonymous = ServerDoor { token: "0".repeat(32), ..own.door.clone() };
    let the_same = json!({"id": "ada", "name": "Ada's script"});
    assert_eq!(undo(&anonymous, the_same.clone()).refusal(), (401, "unauthorized".into()));
    let by_ben = undo(&own.door, json!({"id": "ben", "name": "Ada"})).json();
    assert_eq!(by_ben["results"][0]["code"], "nothingToUndo", "a name is not who somebody is");
    let by_ada = undo(&own.door, the_same).json();
    assert_eq!(by_ada["results"][0]["seq"], welcome.seq + 2);
    own.stopped().await;
}

/// Rules: REC-4, HTTP-6
#[test]
fn an_operation_twice_in_one_request_is_carried_out_once() {
    new_session(&SHARED, "twice");
    let angle = |(op, degrees): (&str, f64)| json!({"opId": op, "command": {"type": "setLight", "light": 1, "parameter": {"coneAngle": degrees}}});
    let answer = edits(&SHARED, "twice", &json!([("a", 20.0), ("a", 21.0), ("b", 95.0), ("b", 22.0)].map(angle)));
    let results = &answer["results"];
    assert_eq!((&results[0], &results[2]), (&results[1], &results[3]));
    assert_eq!((results[0]["seq"].as_u64(), results[2]["code"].as_str()), (Some(2), Some("invalidLight")));
    assert_eq!(answer["seq"], 2);
}

/// A refusal by a limit is no outcome of the operation: when it is sent again with room, it is carried out.
///
/// Rules: REC-4, HTTP-11
#[test]
fn an_operation_that_a_limit_refused_may_be_sent_again() {
    make_session(&SHARED, &json!({"name": "full"}));
    let add = json!({"type": "addLight", "light": {"type": "spot"}});
    let lights: Vec<Value> = (0..257).map(|n| json!({"opId": n.to_string(), "command": add})).collect();
    let answer = edits(&SHARED, "full", &lights.into());
    assert_eq!(answer["results"][256]["code"], "tooMany");
    let again = json!([
        {"command": {"type": "removeLight", "light": 7}},
        {"opId": "256", "command": add},
        {"opId": "255", "command": add},
    ]);
    let answer = edits(&SHARED, "full", &again);
    assert_eq!(answer["results"][1]["seq"], 258);
    assert_eq!(answer["results"][2]["seq"], 256, "that one was carried out before");
}

/// Each of these edits holds all lights of a full document. Carried out together, like small edits, 1,000 of them would
/// take gigabytes of memory.
///
/// Rules: HTTP-6
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn large_edits_of_one_request_are_committed_in_parts() {
    let own = OwnServer::start().await;
    let commits = |door: &ServerDoor| metric(door, "bendylights_commit_seconds_count").expect("it is counted");
    let add = json!({"command": {"type": "addLight", "light": {"type": "spot"}}});
    let before = commits(&own.door);
    edits(&own.door, "main", &vec![add; 255].into());
    let small = commits(&own.door) - before;
    let turn = [json!({"command": {"type": "loadScene", "scene": "demo:vases"}}), json!({"undo": "mine"})];
    let turns: Vec<Value> = turn.into_iter().cycle().take(64).collect();
    let answer = edits(&own.door, "main", &turns.into());
    assert!(all_are_committed(&answer));
    let large = commits(&own.door) - before - small;
    // 64 records of 258 changes and more: eight fill a tick. A checkpoint is no commit of records.
    assert!(small <= 2.0 && large >= 8.0, "{small} for 255 small edits, {large} for 64 large ones");
    own.stopped().await;
}

/// Rules: UNDO-1, UNDO-4, LOG-5
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn undo_reaches_past_a_checkpoint_and_a_restart() {
    let own = OwnServer::start().await;
    let hash = |door: &ServerDoor| state(door, "main")["hash"].clone();
    let before = hash(&own.door);
    let step = |n: u32| json!({"command": {"type": "setLight", "light": 1, "parameter": {"coneAngle": 20.0 + f64::from(n % 30)}}});
    for part in 0..2 {
        let part: Vec<Value> = (0..600).map(|n| step(600 * part + n)).collect();
        edits(&own.door, "main", &part.into());
    }
    let folder = own.stopped().await;
    let database = Connection::open(folder.path().join("bendylights.sqlite")).expect("a database");
    let seq: u64 = database.query_row("SELECT seq FROM checkpoint", [], |row| row.get(0)).expect("a checkpoint");
    assert!((1_000..1_201).contains(&seq), "{seq}");
    drop(database);

    let own = OwnServer::start_in(folder).await;
    let undo: Vec<Value> = (0..600).map(|_| json!({"undo": "mine"})).collect();
    for _ in 0..2 {
        assert!(all_are_committed(&edits(&own.door, "main", &undo.clone().into())));
    }
    assert_eq!(hash(&own.door), before);
    let nothing = edits(&own.door, "main", &json!([{"undo": "mine"}]));
    assert_eq!(nothing["results"][0]["code"], "nothingToUndo");
    own.stopped().await;
}

/// Another program locks the database while a drag is committed. The server waits ten seconds and gives up.
///
/// Rules: GEST-6, SOCK-4, REC-4
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_drag_that_the_disk_refuses_frees_its_light() {
    let own = OwnServer::start().await;
    let (mut ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    let (mut ben, _) = Client::join(&own.door, "main", "Ben").await;
    let base_seq = welcome.seq;
    let gesture = || "drag".to_owned();
    ada.say(&ClientMessage::GestureBegin { gesture: gesture(), light: 1, base_seq }).await;
    ada.say(&ClientMessage::GestureUpdate { gesture: gesture(), update: 1, command: cone_angle(40.0) }).await;
    let updated = |message| match message {
        ServerMessage::GestureState(state) if state.update == 1 => Some(state),
        _ => None,
    };
    let dragged = ben.until(updated).await;
    assert_eq!(dragged.status, GestureStatus::Held { refused: None });

    let path = own.folder.path().join("bendylights.sqlite");
    let mut other = Connection::open(path).expect("a database");
    let lock = other.transaction_with_behavior(TransactionBehavior::Immediate).expect("it is free");
    ada.say(&ClientMessage::GestureCommit { gesture: gesture(), op_id: "commit".into() }).await;
    for client in [&mut ada, &mut ben] {
        let has_ended = |state: &GestureState| !matches!(state.status, GestureStatus::Held { .. });
        let ended = client.until(|message| updated(message).filter(has_ended)).await;
        let GestureStatus::Rejected(problem) = ended.status else { panic!("{ended:?}") };
        assert_eq!((problem.code, ended.changes), (ErrorCode::Storage, Vec::new()));
    }
    let refused = ada.outcome("commit").await;
    let Outcome::Rejected(problem) = refused else { panic!("{refused:?}") };
    assert_eq!(problem.code, ErrorCode::Storage);
    assert!(problem.message.contains("cannot write"));
    lock.rollback().expect("let go");

    let free = edited(&mut ben, "mine", base_seq, cone_angle(41.0)).await;
    assert_eq!(free, committed(base_seq + 1), "the light is free");
    let again = edited(&mut ada, "commit", base_seq + 1, cone_angle(40.0)).await;
    assert_eq!(again.seq(), Some(base_seq + 2), "what the disk refused is no answer for good");
    own.stopped().await;
}

/// Earlier operations cannot be read, so it is unknown if this one is in the log.
///
/// Rules: SOCK-4, REC-4
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_operation_that_may_have_come_before_is_not_called_refused() {
    let own = OwnServer::start().await;
    let (mut ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    let first = edited(&mut ada, "x", welcome.seq, cone_angle(30.0)).await;
    assert_eq!(first, committed(welcome.seq + 1));
    let database = Connection::open(own.folder.path().join("bendylights.sqlite")).expect("a database");
    let rename = |from: &str, to: &str| {
        database.execute_batch(&format!("ALTER TABLE {from} RENAME TO {to}")).expect("a planted fault");
    };
    rename("rejection", "lost");
    let fresh = edited(&mut ada, "y", welcome.seq + 1, cone_angle(31.0)).await;
    assert!(matches!(fresh, Outcome::Unknown(problem) if problem.code == ErrorCode::UnknownOutcome));
    rename("lost", "rejection");
    let again = edited(&mut ada, "y", welcome.seq + 1, cone_angle(31.0)).await;
    assert_eq!(again.seq(), Some(welcome.seq + 2), "and it may be sent again");
    assert_eq!(edited(&mut ada, "x", welcome.seq + 2, cone_angle(32.0)).await, first);
    own.stopped().await;
}

/// Rules: HTTP-3, LOG-3
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_damaged_asset_is_not_called_absent() {
    let folder = OwnServer::start().await.stopped().await;
    let assets = std::fs::read_dir(folder.path().join("assets")).expect("a folder");
    let asset = assets.map(|file| file.expect("a file").path()).next().expect("the demo's");
    let bytes = std::fs::read(&asset).expect("bytes");
    std::fs::write(&asset, b"damaged").expect("a planted fault");
    let own = OwnServer::start_in(folder).await;
    let refusal = |door: &ServerDoor| get(door, "/sessions/main").refusal();
    assert_eq!(refusal(&own.door), (500, "damagedAsset".into()));
    std::fs::remove_file(&asset).expect("removed");
    assert_eq!(refusal(&own.door), (404, "unknownAsset".into()));
    std::fs::write(&asset, bytes).expect("mended");
    assert_eq!(get(&own.door, "/sessions/main").status, 200);
    own.stopped().await;
}
