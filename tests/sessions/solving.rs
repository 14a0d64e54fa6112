//! Drags with slow solves, and work in parallel to them.

use std::process::Command as Program;
use std::thread;
use std::time::Duration;

use protocol::{
    Action, ClientMessage, Command, Drag, DragKind, DragRadii, EditResults, ErrorCode, GestureStatus, Record, Scope,
    ServerMessage, parse_body,
};
use serde_json::{Value, json};

use crate::sessions::support::{
    Mirror, Server, begin_request, committed, drag_ends, has_ended, ok, rejected, rename, state_of,
};

const SIZE: [u32; 2] = [640, 360];
/// Number of acknowledged edits of others that shows parallel work. A session that waited for the drag would
/// acknowledge two: the one before it, and the one that waited with it.
const MANY: usize = 5;
/// Enough pins that a drag takes longer than these edits, even on a busy machine.
const PINS: usize = 240;

/// Adds pins at many points of the light, two of them hard. Returns a drag that takes tens of times as long as most,
/// since its pins limit it.
fn slow_drag(server: &Server, mirror: &mut Mirror) -> Command {
    let seen = (160..360).step_by(24).flat_map(|y| (100..600).step_by(24).map(move |x| (x, y)));
    let queries: Vec<Value> = seen
        .map(|(x, y)| [f64::from(x) + 0.5, f64::from(y) + 0.5])
        .map(|at| json!({"light": 0, "kind": "hotspot", "size": SIZE, "from": at, "to": at, "pins": []}))
        .collect();
    let post = |path: &str, body: Value| ok(server.post(path, &body)).text();
    let answers: Vec<Value> = parse_body(&post("/sessions/main/drags", json!(queries))).expect("an array of results");
    let lit: Vec<&Value> =
        answers.iter().filter(|answer| answer["status"] == "landed").map(|answer| &answer["fromWorld"]).collect();
    let kinds = ["direction", "lit", "shadowed", "shadow"];
    let pin = |n: usize| {
        let (kind, at, hard) = (if n < 2 { kinds[0] } else { kinds[n % 4] }, lit[n * 5 % lit.len()], n < 2);
        json!({"command": {"type": "addPin", "pin": {"kind": kind, "light": mirror.light(), "at": at, "hard": hard}}})
    };
    let edits: Vec<Value> = (0..PINS).map(pin).collect();
    let results: EditResults = parse_body(&post("/sessions/main/edits", json!({"edits": edits}))).expect("results");
    mirror.catch_up(results.seq);
    assert_eq!(mirror.document.pins().len(), PINS);
    Command::DragFeature(Box::new(Drag {
        light: mirror.light(),
        kind: DragKind::Shadow,
        points: Some(vec![1, 2, 3, 4]),
        radii: DragRadii::Follow,
        camera: mirror.document.cameras().values().next().expect("the demo has a camera").into(),
        size: SIZE,
        from: [430.5, 265.5],
        to: [400.5, 300.5],
        pins: None,
        alternative: None,
        alternatives: false,
        source_outside: None,
    }))
}

/// Calls `wait`, and `edit` again and again until it returns. Returns the number of edits, and the result.
fn count_during<T: Send>(wait: impl FnOnce() -> T + Send, mut edit: impl FnMut(usize)) -> (usize, T) {
    thread::scope(|scope| {
        let waiting = scope.spawn(wait);
        let mut count = 0;
        while !waiting.is_finished() {
            edit(count);
            count += 1;
        }
        (count, waiting.join().expect("a result"))
    })
}

/// Renames the camera, which touches no light.
fn edit_camera(mirror: &mut Mirror, count: usize) {
    let camera = mirror.document.cameras().keys().next().expect("the demo has a camera").0;
    let command = json!({"type": "setCamera", "camera": camera, "parameter": {"name": format!("seen {count} times")}});
    committed(&mirror.edited(serde_json::from_value(command).expect("a command")));
}

/// Calls `wait`. Returns the number of edits of `mirror` that are acknowledged meanwhile, and the result.
fn edits_during<T: Send>(mirror: &mut Mirror, wait: impl FnOnce() -> T + Send) -> (usize, T) {
    count_during(wait, |count| edit_camera(mirror, count))
}

fn begin(mirror: &mut Mirror) {
    mirror.begin("drag");
    state_of(mirror, |state| state.update == 0);
}

/// Waits for the answer to a ping: all messages sent before it have reached the session by then.
fn ping(mirror: &mut Mirror) {
    mirror.send(&ClientMessage::Ping { sent: 1.0 });
    mirror.wait_for("a pong", |message| matches!(message, ServerMessage::Pong { sent: 1.0, .. }).then_some(()));
}

/// Ada and Ben in a session, and a slow drag in it.
fn two_and_a_slow_drag() -> (Server, Mirror, Mirror, Command) {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let drag = slow_drag(&server, &mut ada);
    ben.catch_up(ada.seq);
    (server, ada, ben, drag)
}

/// Records of an actor, in order.
fn records_of(server: &Server, actor: &str) -> Vec<Record> {
    server.records(0).into_iter().filter(|record| record.actor.id == actor).collect()
}

/// Others edit meanwhile, and the client itself gets answers to messages that edit nothing. Its edits after the drag
/// keep their order.
///
/// Rules: GEST-8
#[test]
fn a_session_goes_on_while_a_drag_is_solved() {
    let (server, mut ada, mut ben, drag) = two_and_a_slow_drag();
    begin(&mut ada);
    ada.update("drag", 1, drag);
    ada.commit("drag");
    let renamed = ada.edit(rename(ada.light(), "after the drag"));
    let (count, (gesture, name)) = edits_during(&mut ben, || {
        ada.send(&ClientMessage::Ping { sent: 1.0 });
        ada.wait_for("a pong before the drag", |message| match message {
            ServerMessage::Pong { .. } => Some(()),
            ServerMessage::GestureState(state) => panic!("the drag was waited for: {state:?}"),
            _ => None,
        });
        state_of(&mut ada, |state| state.update == 1);
        (committed(&ada.result("commit")), committed(&ada.result(&renamed)))
    });
    assert!(count >= MANY, "{count} edits");
    assert!(gesture < name);
    let records = records_of(&server, "ada");
    assert!(matches!(&records[..], [drag, _] if matches!(drag.action, Action::Gesture { .. }) && drag.seq == gesture));
    assert_eq!(records[1].seq, name);
    ada.catch_up(ben.seq);
    assert_eq!(server.state(), (ada.seq, ada.document.hash().to_string()));
}

/// Rules: GEST-8, GEST-3
#[test]
fn a_commit_outlives_its_connection() {
    let (server, mut ada, mut ben, drag) = two_and_a_slow_drag();
    let mut eve = server.connect("eve");
    begin(&mut ada);
    ada.update("drag", 1, drag);
    ada.commit("drag");
    ping(&mut ada);
    drop(ada);
    let (count, ended) = edits_during(&mut ben, || state_of(&mut eve, has_ended));
    assert!(count >= MANY, "{count} edits");
    assert_eq!(ended.status, GestureStatus::Committed);
    assert_eq!(records_of(&server, "ada").len(), 1);
}

/// Rules: GEST-8, REC-4
#[test]
fn a_programs_edits_stay_in_order_around_a_drag() {
    let (server, ada, mut ben, drag) = two_and_a_slow_drag();
    let light = ada.light();
    // The second drag starts where the first one ended.
    let mut back = drag.clone();
    let [from, to] = drag_ends(&mut back);
    std::mem::swap(from, to);
    let commands = [rename(light, "before"), drag, rename(light, "after"), back, rename(light, "last")];
    let edit = |(n, command): (usize, &Command)| json!({"opId": format!("step {n}"), "command": command});
    let edits: Vec<Value> = commands.iter().enumerate().map(edit).collect();
    let edits = json!({"actor": {"id": "ci", "name": "CI"}, "edits": edits});
    let post = || -> EditResults { parse_body(&server.post("/sessions/main/edits", &edits).text()).expect("results") };
    let (count, results) = edits_during(&mut ben, post);
    assert!(count >= MANY, "{count} edits");
    let seqs: Vec<u64> = results.results.iter().filter_map(|result| result.outcome.seq()).collect();
    assert!(seqs.is_sorted_by(|a, b| a < b) && seqs.len() >= 4 && results.results.len() == 5, "{results:?}");
    let made = || records_of(&server, "ci").iter().map(|record| record.seq).collect::<Vec<u64>>();
    assert_eq!(made(), seqs);
    assert_eq!(post().results, results.results, "none is carried out twice");
    assert_eq!(made(), seqs);
    ben.catch_up(results.seq);
    assert_eq!(ben.name(), "last");
}

/// Nobody holds the light. Changes by others make the drag solve again, a limited number of times, and do not wait for
/// it. After they end, the same operation is carried out.
///
/// Rules: GEST-8, GEST-9, REC-4
#[test]
fn a_drag_is_refused_where_others_keep_changing_the_light() {
    let (_server, mut ada, mut ben, drag) = two_and_a_slow_drag();
    let op_id = ada.edit(drag.clone());
    let mut rename_by_ben = |count| drop(ben.edited(rename(ben.light(), &format!("name {count}"))));
    let (count, outcome) = count_during(|| ada.result(&op_id), &mut rename_by_ben);
    assert!(count >= MANY, "{count} edits");
    assert_eq!(rejected(&outcome).code, ErrorCode::KeepsChanging, "{outcome:?}");
    ada.send(&ClientMessage::Edit { op_id: op_id.clone(), base_seq: ada.seq, command: drag });
    // Ben's last edits may not have reached her yet.
    assert!(ada.result(&op_id).seq().is_some());
    // It undoes none of Ben's edits.
    ben.catch_up(ada.seq);
    assert!(ben.name().starts_with("name "));
    assert!(ada.undo(Scope::Mine).seq().is_some());
}

/// Number of solves that run or wait.
fn under_way(server: &Server) -> f64 {
    server.metric("solves_under_way", "")
}

/// Waits until a solve runs.
fn until_one_is_under_way(server: &Server) {
    while under_way(server) == 0.0 {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Number of edits of `mirror` that are acknowledged until no solve is left.
fn edits_until_none_is_under_way(server: &Server, mirror: &mut Mirror) -> usize {
    let mut count = 0;
    while under_way(server) > 0.0 {
        edit_camera(mirror, count);
        count += 1;
    }
    count
}

/// A solve without a waiting client ends, however it is abandoned: within a few edits of another client, while the
/// whole drag takes many.
///
/// Rules: GEST-10
#[test]
fn solves_without_a_waiting_client_end() {
    let (server, mut ada, mut ben, mut drag) = two_and_a_slow_drag();
    begin(&mut ada);
    ada.update("drag", 1, drag.clone());
    let (whole, _) = edits_during(&mut ben, || state_of(&mut ada, |state| state.update == 1));
    // The result of the same drag would be cached.
    drag_ends(&mut drag)[1][0] -= 1.0;
    ada.update("drag", 2, drag.clone());
    until_one_is_under_way(&server);
    ada.cancel("drag");
    state_of(&mut ada, has_ended);
    let cancelled = edits_until_none_is_under_way(&server, &mut ben);
    // The same with another edit after the update, which is carried out anyway.
    begin(&mut ada);
    ada.update("drag", 1, drag.clone());
    ada.edit(rename(ada.light(), "on leaving"));
    ping(&mut ada);
    until_one_is_under_way(&server);
    drop(ada);
    let left = edits_until_none_is_under_way(&server, &mut ben);
    let ended = |path: &str, body: Value| {
        let _stream = begin_request(&server.address, "POST", path, &body.to_string());
        until_one_is_under_way(&server);
    };
    ended("/sessions/main/edits", json!({"edits": [{"command": drag}, {"command": drag}]}));
    let edited = edits_until_none_is_under_way(&server, &mut ben);
    let Command::DragFeature(drag) = drag else { unreachable!("it is a drag") };
    let Drag { points, size, from, to, .. } = *drag;
    let query = json!({"light": 0, "kind": "shadow", "points": points, "radii": "solve", "size": size,
        "from": from, "to": to});
    ended("/sessions/main/drags", json!(vec![query; 20]));
    let queried = edits_until_none_is_under_way(&server, &mut ben);
    println!("{whole} edits in a drag; given up {cancelled}, {left}, {edited}, {queried}");
    let most = cancelled.max(left).max(edited).max(queried);
    assert!(4 * most < whole, "{most} of {whole}");
    assert!(server.get("/sessions/main/log").text().contains("on leaving"));
}

/// A client that fills the queue behind its drag blocks only itself.
///
/// Rules: GEST-8
#[test]
fn a_full_message_queue_blocks_only_its_client() {
    let (_server, mut ada, mut ben, drag) = two_and_a_slow_drag();
    let first = ada.edit(drag);
    let last = (0..200).map(|n| ada.edit(rename(ada.light(), &format!("name {n}")))).last().expect("an edit");
    let (count, _) = edits_during(&mut ben, || (committed(&ada.result(&first)), committed(&ada.result(&last))));
    assert!(count >= MANY, "{count} edits");
}

/// Rules: GEST-7
#[test]
fn a_drag_that_is_cancelled_is_not_waited_for() {
    let (_server, mut ada, mut ben, drag) = two_and_a_slow_drag();
    for update in 1..=3 {
        begin(&mut ada);
        ada.update("drag", update, drag.clone());
        ping(&mut ada);
        ada.update("drag", update + 10, drag.clone());
        ada.cancel("drag");
        let ended = state_of(&mut ada, |state| state.update > 0 || has_ended(state));
        assert_eq!((ended.update, ended.status), (0, GestureStatus::Cancelled { refused: None }));
    }
    committed(&ben.edited(rename(ben.light(), "free")));
    // Abandoned solves have no effect.
    ada.catch_up(ben.seq);
    assert_eq!(committed(&ada.edited(drag)), ben.seq + 1);
}

/// Updates that arrive during a solve, and not in one tick.
///
/// Rules: GEST-7
#[test]
fn later_updates_supersede_waiting_ones() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let drag = slow_drag(&server, &mut ada);
    begin(&mut ada);
    let last = 12;
    let (mut answers, mut pongs) = (Vec::new(), 0);
    for update in 1..=last {
        let mut command = drag.clone();
        drag_ends(&mut command)[1][0] -= (last - update) as f64;
        ada.update("drag", update, command);
        ada.send(&ClientMessage::Ping { sent: update as f64 });
        ada.wait_for("a pong", |message| match message {
            ServerMessage::GestureState(state) => {
                answers.push(state.update);
                None
            }
            ServerMessage::Pong { .. } => {
                pongs += 1;
                Some(())
            }
            _ => None,
        });
    }
    while answers.last() != Some(&last) {
        let state = state_of(&mut ada, |_| true);
        answers.push(state.update);
    }
    assert_eq!((pongs, answers[0]), (last, 1), "the first is shown though it is outrun: {answers:?}");
    assert!(answers.len() <= 6, "{answers:?}");
    ada.commit("drag");
    committed(&ada.result("commit"));
}

/// More edits than the queue holds: the client's messages are not read until the drag is solved.
///
/// Rules: GEST-8
#[test]
fn a_long_line_is_carried_out_in_order() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let drag = slow_drag(&server, &mut ada);
    let seq = ada.seq;
    let first = ada.edit(drag);
    let renamed: Vec<String> = (0..2_000).map(|n| ada.edit(rename(ada.light(), &format!("name {n}")))).collect();
    for (n, op_id) in std::iter::once(&first).chain(&renamed).enumerate() {
        assert_eq!(committed(&ada.result(op_id)), seq + 1 + n as u64);
    }
    assert_eq!(ada.name(), "name 1999");
}

/// Rules: GEST-8, SOCK-9
#[test]
fn a_server_that_is_stopped_finishes_what_it_solves() {
    let (server, [mut ada]) = Server::start_process().with(["ada"]);
    let drag = slow_drag(&server, &mut ada);
    let op_id = ada.edit(drag);
    let renamed = ada.edit(rename(ada.light(), "after the drag"));
    ping(&mut ada);
    let pid = server.pid().to_string();
    assert!(Program::new("kill").args(["-TERM", &pid]).status().expect("sent").success());
    let (drag, name) = (committed(&ada.result(&op_id)), committed(&ada.result(&renamed)));
    assert_eq!(name, drag + 1);
    assert_eq!(server.into_process().0.wait().expect("it ends"), Some(0));
}
