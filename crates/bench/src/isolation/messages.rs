//! Action that sends as many messages on sockets as a server accepts.

use protocol::{ClientMessage, ServerMessage};
use serde_json::json;

use super::other::{ClientAction, OtherClient, POLL_INTERVAL};
use super::setup::{make_session, rename};
use crate::dragged::DragCircle;
use crate::{BenchError, Client, Incoming};

/// Number of messages that are sent at once, followed by a ping. The answer to the ping shows that all of them are
/// done.
const AT_ONCE: u64 = 64;
/// Radians between updates of a drag.
const TURN: f64 = 0.01;
/// Number of sockets that ping, and of sockets that edit.
const SOCKETS: usize = 2;

/// Sends pings, edits and updates of a drag, in a session of its own.
pub(super) fn flood(other: &OtherClient) -> Result<ClientAction, BenchError> {
    make_session(&other.address, &other.session(0), "demo:vases")?;
    Ok(Box::new(move |other| {
        for socket in 0..SOCKETS {
            other.spawn(move |other| {
                let mut client = other.connect(socket)?;
                repeat(other, &mut client, |n| ClientMessage::Ping { sent: n as f64 })
            });
        }
        let light = DragCircle::of(&*other.connect(0)?)?.light;
        for socket in SOCKETS..2 * SOCKETS {
            other.spawn(move |other| {
                let mut client = other.connect(socket)?;
                let (base_seq, run) = (client.welcome.seq, fastrand::u64(..));
                repeat(other, &mut client, |n| {
                    let op_id = format!("{run:x}-{n}");
                    ClientMessage::Edit { op_id, base_seq, command: rename(light, n) }
                })
            });
        }
        other.spawn(|other| drag(other, &mut *other.connect(2 * SOCKETS)?));
        Ok(())
    }))
}

/// Drags a control point of the session's light.
fn drag(other: &OtherClient, client: &mut Client) -> Result<(), BenchError> {
    let circle = DragCircle::of(client)?;
    let gesture = format!("flood-{:x}", fastrand::u64(..));
    client.begin_gesture(&gesture, circle.light)?;
    repeat(other, client, |update| {
        let command = circle.command(TURN * update as f64);
        ClientMessage::GestureUpdate { gesture: gesture.clone(), update, command }
    })
}

/// Sends messages in batches of `AT_ONCE`, each batch after the one before is done.
fn repeat(other: &OtherClient, client: &mut Client, message: impl Fn(u64) -> ClientMessage) -> Result<(), BenchError> {
    for round in 1.. {
        for n in 1..=AT_ONCE {
            client.send(&message(AT_ONCE * (round - 1) + n))?;
        }
        other.count_done(AT_ONCE);
        // Negative, to differ from the pings among the messages.
        let last = -(round as f64);
        client.send(&ClientMessage::Ping { sent: last })?;
        loop {
            if other.is_over() {
                return Ok(());
            }
            let answer = client.receive(POLL_INTERVAL)?.and_then(Incoming::into_message);
            match answer {
                Some(ServerMessage::Pong { sent, .. }) if sent == last => break,
                Some(ServerMessage::Error { .. }) => return Err(BenchError::Refused(json!(answer).to_string())),
                _ => {}
            }
        }
        other.count_answered(AT_ONCE);
    }
    Ok(())
}
