//! Reconnects: with the missed records, or with the whole document.

use bench::{Client, KnownHistory};
use protocol::State;

use crate::sessions::support::{Server, rename};

/// Rules: SOCK-2
#[test]
fn a_client_that_comes_back_gets_what_it_missed() {
    let (server, [ada, mut ben]) = Server::start_process().with(["ada", "ben"]);
    let known = KnownHistory { epoch: ada.client.welcome.epoch.clone(), last_seq: ada.seq };
    let mut document = ada.document.clone();
    drop(ada);
    for step in 0..5 {
        ben.edited(rename(ben.light(), &format!("name {step}")));
    }

    // A restart keeps the history.
    let server = server.restart();
    let back = Client::connect(&server.address, "main", "ada", Some(known.clone())).expect("welcome");
    let State::Tail(records) = back.welcome.state else { panic!("a tail") };
    let seqs: Vec<u64> = records.iter().map(|record| record.seq).collect();
    assert_eq!(seqs, (known.last_seq + 1..=known.last_seq + 5).collect::<Vec<_>>());
    for record in records {
        let record = edit::Record::try_from(record).expect("a valid record");
        document.apply(&record.changes).expect("it fits");
    }
    assert_eq!(document.hash().to_string(), back.welcome.hash);

    // Sequence numbers of another history are not valid here, and neither are future ones.
    let other = KnownHistory { epoch: "another".into(), ..known };
    let future = KnownHistory { epoch: back.welcome.epoch, last_seq: 1_000_000 };
    for known in [other, future] {
        let back = Client::connect(&server.address, "main", "ada", Some(known.clone())).expect("welcome");
        assert!(matches!(back.welcome.state, State::Snapshot(_)), "{known:?}");
    }
}
