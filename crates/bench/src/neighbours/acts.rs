//! Actions of the other client in each row.

use super::asks;
use super::drags;
use super::memory;
use super::messages;
use super::other::{ClientAction, OtherClient};
use super::row::NeighbourRow;
use super::views;
use crate::BenchError;

/// Makes sessions and scenes that a row needs. Returns its action.
pub(super) fn prepare(row: NeighbourRow, other: &OtherClient) -> Result<ClientAction, BenchError> {
    match row {
        NeighbourRow::Nobody => Ok(Box::new(|_| Ok(()))),
        NeighbourRow::Solves => drags::cancel_slow_drags(other),
        NeighbourRow::SolvesInSession => drags::drag_in_victims_session(other),
        NeighbourRow::LargeViews | NeighbourRow::SlowLink => views::large(other),
        NeighbourRow::SilentViews => views::silent(other),
        NeighbourRow::RestingViews => views::resting(other),
        NeighbourRow::ClosingViews => views::closing(other),
        NeighbourRow::Stills16000 | NeighbourRow::Stills64000 | NeighbourRow::StillsOfPrimitives => {
            asks::stills(other)
        }
        NeighbourRow::Imports => asks::imports(other),
        NeighbourRow::Asks => asks::ask_without_pictures(other),
        NeighbourRow::Actors => asks::edit_as_many_actors(other),
        NeighbourRow::Messages => messages::flood(other),
        NeighbourRow::ReadsNothing => memory::reads_nothing(other),
        NeighbourRow::CutBodies => memory::cut_bodies(other),
    }
}
