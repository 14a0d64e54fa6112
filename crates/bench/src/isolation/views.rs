//! Actions with views that move, rest, or whose frames are not read.

use std::time::{Duration, Instant};

use glam::DQuat;
use protocol::{Camera, ClientMessage};
use stream::FrameHeader;

use super::other::{CLIENTS, ClientAction, OtherClient, POLL_INTERVAL, TrackedClient};
use super::setup::make_session;
use crate::circle::time_until;
use crate::dragged::DragCircle;
use crate::{BenchError, Client, Incoming};

/// Number of views that move, and their size in pixels: the largest that a server accepts.
const LARGE_VIEWS: usize = 8;
const LARGE_VIEW_SIZE: [u32; 2] = [3840, 2160];
/// Number of sockets with a view whose frames are not acknowledged: those that remain of 256 after the victim's two and
/// the sockets that drag.
const SILENT_VIEWS: usize = 250;
/// Number of sessions in which these views are. One socket of each session drags.
const SILENT_SESSIONS: usize = 4;
const MEDIUM_VIEW_SIZE: [u32; 2] = [1280, 720];
/// Number of views that stay at rest, and of views that are opened and closed.
const RESTING_VIEWS: usize = 30;
/// Time after which a view moves again if no frame has arrived.
const MOVES_EVERY: Duration = Duration::from_millis(50);
/// Longest wait for views that must be open before anything is measured.
const OPENS_WITHIN: Duration = Duration::from_mins(2);
/// Time for which views are open before they are closed again.
const CLOSES_AFTER: Duration = Duration::from_secs(1);
/// Radians by which a view turns for each frame. The next constant is the number of updates after which it turns back.
const TURN: f64 = 0.01;
const TURNS: u32 = 40;

const SCENE: &str = "demo:vases";

/// Opens views and waits for a first frame of each. They then move as fast as their frames arrive.
pub(super) fn large(other: &OtherClient) -> Result<ClientAction, BenchError> {
    make_session(&other.address, &other.session(0), SCENE)?;
    Ok(Box::new(|other| {
        let mut views = Vec::new();
        for socket in 0..LARGE_VIEWS {
            let mut client = other.connect(socket)?;
            client.open_view(LARGE_VIEW_SIZE, None)?;
            views.push(client);
        }
        wait_for_all(&mut views, OPENS_WITHIN, |_| true)?;
        for mut client in views {
            let camera = client.welcome.camera.clone();
            let mut camera_revision = 1;
            other.spawn(move |other| move_view(other, &mut client, &camera, &mut camera_revision));
        }
        Ok(())
    }))
}

/// Moves a view once, and waits for its next frame, for at most `MOVES_EVERY`.
fn move_view(
    other: &OtherClient,
    client: &mut Client,
    camera: &Camera,
    camera_revision: &mut u32,
) -> Result<(), BenchError> {
    *camera_revision += 1;
    let (camera, camera_revision) = (turned(camera, *camera_revision), *camera_revision);
    client.send(&ClientMessage::SetCamera { camera, camera_revision })?;
    other.count_done(1);
    let until = Instant::now() + MOVES_EVERY;
    while let Some(left) = time_until(until) {
        if let Some(Incoming::Frame(header, _)) = client.receive(left)? {
            client.ack(&header)?;
            other.count_answered(1);
            break;
        }
    }
    Ok(())
}

/// Returns the camera, turned to one side and back again as `revision` grows.
fn turned(camera: &Camera, revision: u32) -> Camera {
    let place = revision % (2 * TURNS);
    let steps = if place < TURNS { place } else { 2 * TURNS - place };
    let turn = DQuat::from_rotation_y(TURN * f64::from(steps));
    let rotation = (turn * DQuat::from_array(camera.rotation)).normalize().to_array();
    Camera { rotation, ..camera.clone() }
}

/// Opens views that read nothing, in sessions whose light is dragged.
pub(super) fn silent(other: &OtherClient) -> Result<ClientAction, BenchError> {
    for session in 0..SILENT_SESSIONS {
        make_session(&other.address, &other.session(session * CLIENTS), SCENE)?;
    }
    Ok(Box::new(|other| {
        for session in 0..SILENT_SESSIONS {
            let drags = session * CLIENTS;
            other.spawn(move |other| drag(other, drags));
            let silent = drags + 1..(drags + CLIENTS).min(SILENT_VIEWS + SILENT_SESSIONS);
            other.spawn(move |other| {
                let mut views = Vec::new();
                for socket in silent.clone().take_while(|_| !other.is_over()) {
                    let opened = other.connect(socket).and_then(|mut client| {
                        client.open_view(MEDIUM_VIEW_SIZE, None)?;
                        views.push(client);
                        other.count_done(1);
                        Ok(())
                    });
                    other.count_refusal(opened);
                }
                other.wait_until_over();
                Ok(())
            });
        }
        Ok(())
    }))
}

/// Drags a control point without a view of its own.
fn drag(other: &OtherClient, socket: usize) -> Result<(), BenchError> {
    let mut client = other.connect(socket)?;
    let circle = DragCircle::of(&client)?;
    client.begin_gesture("other", circle.light)?;
    for update in 1.. {
        if other.is_over() {
            break;
        }
        client.update_gesture("other", update, circle.command(0.05 * update as f64))?;
        while client.receive(Duration::from_millis(16))?.is_some() {}
    }
    Ok(())
}

/// Opens views and waits for the lossless picture of each. They then rest.
pub(super) fn resting(other: &OtherClient) -> Result<ClientAction, BenchError> {
    make_session(&other.address, &other.session(0), SCENE)?;
    Ok(Box::new(|other| {
        let mut views = open_many(other)?;
        wait_for_all(&mut views, OPENS_WITHIN, |header| header.flags.is_settled)?;
        other.spawn(move |other| {
            while !other.is_over() {
                for client in &mut views {
                    client.receive(Duration::from_millis(1))?;
                }
                std::thread::sleep(POLL_INTERVAL);
            }
            views.clear();
            Ok(())
        });
        Ok(())
    }))
}

/// Opens views and closes them a moment later.
pub(super) fn closing(other: &OtherClient) -> Result<ClientAction, BenchError> {
    make_session(&other.address, &other.session(0), SCENE)?;
    Ok(Box::new(|other| {
        other.spawn(|other| {
            let mut views = open_many(other)?;
            wait_for_all(&mut views, CLOSES_AFTER, |_| {
                other.count_answered(1);
                true
            })
        });
        Ok(())
    }))
}

fn open_many(other: &OtherClient) -> Result<Vec<TrackedClient>, BenchError> {
    let open = |socket| {
        let mut client = other.connect(socket)?;
        client.open_view(MEDIUM_VIEW_SIZE, None)?;
        other.count_done(1);
        Ok(client)
    };
    (0..RESTING_VIEWS).map(open).collect()
}

/// Waits until each view has had a frame that `is_wanted` accepts, for at most `within`. Acknowledges all frames.
fn wait_for_all(
    views: &mut [TrackedClient],
    within: Duration,
    is_wanted: impl Fn(&FrameHeader) -> bool,
) -> Result<(), BenchError> {
    let (until, mut has_come) = (Instant::now() + within, vec![false; views.len()]);
    while Instant::now() < until && has_come.contains(&false) {
        for (client, has_come) in views.iter_mut().zip(&mut has_come) {
            if let Some(Incoming::Frame(header, _)) = client.receive(Duration::from_millis(1))? {
                client.ack(&header)?;
                *has_come |= !*has_come && is_wanted(&header);
            }
        }
    }
    Ok(())
}
