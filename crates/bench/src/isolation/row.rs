//! Rows of the table, one per kind of other client.

use serde::{Serialize, Serializer};

use super::other::{ClientAction, OtherClient};
use super::{asks, drags, memory, messages, scenes, views};
use crate::BenchError;

/// Kind of other client.
#[derive(Clone, Copy, Debug)]
pub struct IsolationRow {
    /// Name on the command line and in reports.
    pub name: &'static str,
    /// Description of the other client's action.
    pub what: &'static str,
    /// Makes sessions and scenes that the row needs. Returns its action.
    pub(super) prepare: Prepare,
    /// True if the other client draws so much that the victim has to share the renderer with it.
    pub(super) uses_renderer: bool,
    /// True if the server answers some of the other client's requests within the measured period. A still can take
    /// longer.
    pub(super) expects_answers: bool,
    /// True if the other client's views are opened before anything is measured.
    pub(super) has_views_open: bool,
}

type Prepare = fn(&OtherClient) -> Result<ClientAction, BenchError>;

/// Row without another client.
pub(super) const NOBODY: IsolationRow =
    row("nobody", "is not there: what the machine itself takes from a victim", |_| Ok(Box::new(|_| Ok(()))));

/// Row in which the victim is connected over a slow link.
pub(super) const SLOW_LINK: IsolationRow =
    row("slow-link", "moves 8 views of 3840x2160, and the victim's link takes 2 Mbit/s", views::large)
        .drawing()
        .answered()
        .with_views_open();

/// All rows, in the order in which they are measured.
pub const ROWS: [IsolationRow; 17] = [
    NOBODY,
    row(
        "solves",
        "begins drags of features by 128 control points of a light of 258 with 256 pins, gives each up",
        drags::cancel_slow_drags,
    ),
    row(
        "solves-in-session",
        "in the victim's session: drags a feature of a light of 64 segments and 64 pins, and edits that light",
        drags::drag_in_victims_session,
    )
    .answered(),
    row("large-views", "moves 8 views of 3840x2160", views::large).drawing().answered().with_views_open(),
    row("silent-views", "opens 250 views of 1280x720 that it never reads, and drags what they show", views::silent)
        .drawing(),
    row("stills-16000", "asks for stills of 64x36 of 16,000 triangles in one place", |other| {
        asks::stills(other, &scenes::triangles(16_000, "still"))
    })
    .drawing(),
    row("stills-64000", "asks for stills of 64x36 of 64,000 triangles in one place", |other| {
        asks::stills(other, &scenes::triangles(64_000, "still"))
    })
    .drawing(),
    row("stills-primitives", "asks for stills of 64x36 of 100,000 primitives in one place", |other| {
        asks::stills(other, &scenes::primitives(100_000, "still"))
    })
    .drawing(),
    row("imports", "uploads such scenes", asks::imports).answered(),
    row("asks", "probes, picks, solves drags, asks for the session and openapi.json", asks::ask_without_pictures)
        .answered(),
    row("resting-views", "rests with 30 views of 1280x720", views::resting).with_views_open(),
    row("closing-views", "opens 30 views of 1280x720 and closes them, again and again", views::closing)
        .drawing()
        .answered(),
    row("reads-nothing", "reads nothing of a document of 16 MiB, on 64 sockets and 64 requests", memory::reads_nothing),
    row("cut-bodies", "sends 200 bodies of 8 MiB, cuts each off at its end", memory::cut_bodies),
    row("actors", "edits, first as one actor, then as another for each edit", asks::edit_as_many_actors).answered(),
    row(
        "messages",
        "sends pings, edits and updates of a drag on 5 sockets, as fast as they are taken",
        messages::flood,
    )
    .answered(),
    SLOW_LINK,
];

const fn row(name: &'static str, what: &'static str, prepare: Prepare) -> IsolationRow {
    IsolationRow { name, what, prepare, uses_renderer: false, expects_answers: false, has_views_open: false }
}

impl IsolationRow {
    const fn drawing(self) -> Self {
        Self { uses_renderer: true, ..self }
    }

    const fn answered(self) -> Self {
        Self { expects_answers: true, ..self }
    }

    const fn with_views_open(self) -> Self {
        Self { has_views_open: true, ..self }
    }
}

impl Serialize for IsolationRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}
