//! Rows of the table, one per kind of other client.

use serde::{Serialize, Serializer};

/// Kind of other client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NeighbourRow {
    Nobody,
    Solves,
    SolvesInSession,
    LargeViews,
    SilentViews,
    Stills16000,
    Stills64000,
    StillsOfPrimitives,
    Imports,
    Asks,
    RestingViews,
    ClosingViews,
    ReadsNothing,
    CutBodies,
    Actors,
    Messages,
    SlowLink,
}

/// All rows, in the order in which they are measured.
pub const ROWS: [NeighbourRow; 17] = [
    NeighbourRow::Nobody,
    NeighbourRow::Solves,
    NeighbourRow::SolvesInSession,
    NeighbourRow::LargeViews,
    NeighbourRow::SilentViews,
    NeighbourRow::Stills16000,
    NeighbourRow::Stills64000,
    NeighbourRow::StillsOfPrimitives,
    NeighbourRow::Imports,
    NeighbourRow::Asks,
    NeighbourRow::RestingViews,
    NeighbourRow::ClosingViews,
    NeighbourRow::ReadsNothing,
    NeighbourRow::CutBodies,
    NeighbourRow::Actors,
    NeighbourRow::Messages,
    NeighbourRow::SlowLink,
];

impl NeighbourRow {
    /// Returns the name of the row on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Solves => "solves",
            Self::SolvesInSession => "solves-in-session",
            Self::LargeViews => "large-views",
            Self::SilentViews => "silent-views",
            Self::Stills16000 => "stills-16000",
            Self::Stills64000 => "stills-64000",
            Self::StillsOfPrimitives => "stills-primitives",
            Self::Imports => "imports",
            Self::Asks => "asks",
            Self::RestingViews => "resting-views",
            Self::ClosingViews => "closing-views",
            Self::ReadsNothing => "reads-nothing",
            Self::CutBodies => "cut-bodies",
            Self::Actors => "actors",
            Self::Messages => "messages",
            Self::SlowLink => "slow-link",
        }
    }

    /// Returns the description of the other client's action.
    pub fn what(self) -> &'static str {
        match self {
            Self::Nobody => "is not there: what the machine itself takes from a victim",
            Self::Solves => {
                "begins drags of features by 128 control points of a light of 258 with 256 pins, gives each up"
            }
            Self::SolvesInSession => {
                "in the victim's session: drags a feature of a light of 64 segments and 64 pins, and edits that light"
            }
            Self::LargeViews => "moves 8 views of 3840x2160",
            Self::SilentViews => "opens 250 views of 1280x720 that it never reads, and drags what they show",
            Self::Stills16000 => "asks for stills of 64x36 of 16,000 triangles in one place",
            Self::Stills64000 => "asks for stills of 64x36 of 64,000 triangles in one place",
            Self::StillsOfPrimitives => "asks for stills of 64x36 of 100,000 primitives in one place",
            Self::Imports => "uploads such scenes",
            Self::Asks => "probes, picks, solves drags, asks for the session and openapi.json",
            Self::RestingViews => "rests with 30 views of 1280x720",
            Self::ClosingViews => "opens 30 views of 1280x720 and closes them, again and again",
            Self::ReadsNothing => "reads nothing of a document of 16 MiB, on 64 sockets and 64 requests",
            Self::CutBodies => "sends 200 bodies of 8 MiB, cuts each off at its end",
            Self::Actors => "edits, first as one actor, then as another for each edit",
            Self::Messages => {
                "sends pings, edits and updates of a drag on 5 sockets, as fast as they are taken"
            }
            Self::SlowLink => "moves 8 views of 3840x2160, and the victim's link takes 2 Mbit/s",
        }
    }

    /// True if the other client's views are opened before anything is measured.
    pub(super) fn has_views_open(self) -> bool {
        matches!(self, Self::LargeViews | Self::RestingViews | Self::SlowLink)
    }

    /// True if the other client draws so much that the victim has to share the renderer with it.
    pub fn uses_renderer(self) -> bool {
        match self {
            Self::LargeViews
            | Self::SilentViews
            | Self::Stills16000
            | Self::Stills64000
            | Self::StillsOfPrimitives
            | Self::ClosingViews
            | Self::SlowLink => true,
            Self::Nobody
            | Self::Solves
            | Self::SolvesInSession
            | Self::Imports
            | Self::Asks
            | Self::RestingViews
            | Self::ReadsNothing
            | Self::CutBodies
            | Self::Actors
            | Self::Messages => false,
        }
    }

    /// True if the server answers some of the other client's requests within the measured period. A still can take
    /// longer.
    pub(super) fn expects_answers(self) -> bool {
        match self {
            Self::SolvesInSession
            | Self::LargeViews
            | Self::Imports
            | Self::Asks
            | Self::ClosingViews
            | Self::Actors
            | Self::Messages
            | Self::SlowLink => true,
            Self::Nobody
            | Self::Solves
            | Self::SilentViews
            | Self::Stills16000
            | Self::Stills64000
            | Self::StillsOfPrimitives
            | Self::RestingViews
            | Self::ReadsNothing
            | Self::CutBodies => false,
        }
    }
}

impl Serialize for NeighbourRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
