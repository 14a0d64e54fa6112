//! Stopping.

use protocol::{ClientMessage, Command, EditStatus, LightParameter, ServerMessage};
use tokio::task::spawn_blocking;

use crate::client::{Came, Client, get};
use crate::server::Own;

/// Rules: SOCK-9, HTTP-9
#[tokio::test]
async fn a_server_that_stops_finishes_what_it_has_accepted() {
    let own = Own::start().await;
    let (mut client, welcome) = Client::join(&own.door, "main", "Ada").await;
    for step in 0..10 {
        let parameter = LightParameter::ConeAngle(20.0 + f64::from(step));
        let command = Command::SetLight { light: 1, parameter };
        client
            .say(&ClientMessage::Edit { op_id: format!("edit {step}"), base_seq: welcome.seq, command })
            .await;
    }
    let answered = |came| matches!(came, Came::Control(ServerMessage::EditResult(_))).then_some(());
    client.until(answered).await;
    let token = own.door.token.clone();
    let (folder, served) = own.stop();

    let (mut committed, mut told) = (1, false);
    loop {
        match client.next().await {
            Came::Control(ServerMessage::EditResult(result)) if result.status == EditStatus::Committed => {
                committed += 1;
            }
            Came::Control(ServerMessage::Draining { retry_after_ms }) => {
                told = retry_after_ms > 0;
            }
            Came::Control(_) | Came::Frame(_) => {}
            Came::End => break,
        }
    }
    assert!(told, "the client was not told");
    served.await.unwrap().unwrap();

    // The folder is free again, pages stay signed in, and what was acknowledged is there.
    let again = Own::start_in(folder).await;
    assert_eq!(again.door.token, token);
    let (again, session) = spawn_blocking(move || {
        let session = get(&again.door, "/sessions/main").json();
        (again, session)
    })
    .await
    .unwrap();
    assert!(session["seq"].as_u64().unwrap() >= welcome.seq + committed, "{committed} and {session}");
    drop(again);
}
