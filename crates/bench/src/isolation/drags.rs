//! Actions that drag features with slow solves.

use std::time::Duration;

use protocol::{ClientMessage, Command, ServerMessage};

use super::other::{ClientAction, OtherClient, POLL_INTERVAL};
use super::setup::{add_light, edit, first_light, make_session, pin, rebend, rename};
use super::victim;
use crate::{BenchError, Client, Incoming};

/// Segments of the light whose drags are cancelled. The next constant is the number of its pins. Both are the most that
/// a document allows.
const SEGMENTS: usize = 256;
const PINS: usize = 256;
/// Segments of the light in the victim's session. The next constant is the number of its pins, which count towards the
/// document's limit.
const SEGMENTS_IN_SESSION: usize = 64;
const PINS_IN_SESSION: usize = 64;
/// Time after which a drag is cancelled. By then its solve has begun.
const GIVEN_UP_AFTER: Duration = Duration::from_millis(50);

/// Begins drags of features in a session of its own, and cancels each.
pub(super) fn cancel_slow_drags(other: &OtherClient) -> Result<ClientAction, BenchError> {
    let (address, session, actor) = (&other.address, other.session(0), other.actor(0));
    make_session(address, &session, "demo:vases")?;
    let light = first_light(address, &session)?;
    edit(address, &session, &actor, &rebend(light, SEGMENTS))?;
    let draggable = pin(address, &session, &actor, light, PINS)?;
    Ok(Box::new(move |other| {
        other.spawn(move |other| {
            let mut client = other.connect(0)?;
            for n in 0.. {
                if other.is_over() {
                    break;
                }
                give_up(&mut client, light, n, draggable.command(n)?)?;
                other.count_done(1);
            }
            Ok(())
        });
        Ok(())
    }))
}

fn give_up(client: &mut Client, light: u64, n: usize, command: Command) -> Result<(), BenchError> {
    let gesture = format!("given-up-{n}");
    client.begin_gesture(&gesture, light)?;
    client.update_gesture(&gesture, 1, command)?;
    std::thread::sleep(GIVEN_UP_AFTER);
    client.cancel_gesture(&gesture)?;
    while let Some(incoming) = client.receive(Duration::from_millis(1))? {
        if let Some(ServerMessage::GestureState(state)) = incoming.into_message() {
            BenchError::check(state.status.problem())?;
        }
    }
    Ok(())
}

/// Drags a feature in the victim's session, and edits its light meanwhile, so that each solve is of a light that has
/// changed.
pub(super) fn drag_in_victims_session(other: &OtherClient) -> Result<ClientAction, BenchError> {
    let (address, session, actor) = (&other.address, victim::SESSION, other.actor(0));
    let light = add_light(address, session, &actor, Some(SEGMENTS_IN_SESSION))?;
    let draggable = pin(address, session, &actor, light, PINS_IN_SESSION)?;
    Ok(Box::new(move |other| {
        other.spawn(move |other| {
            let mut client = other.connect_to(victim::SESSION, 0)?;
            repeat_edits(other, &mut client, "drag", |n| draggable.command(n))
        });
        other.spawn(move |other| {
            let mut client = other.connect_to(victim::SESSION, 1)?;
            repeat_edits(other, &mut client, "rename", |n| Ok(rename(light, n as u64)))
        });
        Ok(())
    }))
}

/// Sends edits one after the other, each after the answer to the one before.
fn repeat_edits(
    other: &OtherClient,
    client: &mut Client,
    what: &str,
    command: impl Fn(usize) -> Result<Command, BenchError>,
) -> Result<(), BenchError> {
    for n in 0.. {
        let (op_id, base_seq) = (format!("{what}-{n}"), client.welcome.seq);
        client.send(&ClientMessage::Edit { op_id: op_id.clone(), base_seq, command: command(n)? })?;
        other.count_done(1);
        loop {
            if other.is_over() {
                return Ok(());
            }
            let message = client.receive(POLL_INTERVAL)?.and_then(Incoming::into_message);
            let Some(ServerMessage::EditResult(result)) = message else { continue };
            if result.op_id == op_id {
                match BenchError::check(result.outcome.problem()) {
                    Ok(()) => other.count_answered(1),
                    refused => other.count_refusal(refused),
                }
                break;
            }
        }
    }
    Ok(())
}
