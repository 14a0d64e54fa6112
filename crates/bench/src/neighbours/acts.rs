//! What the other client does in each row.

use super::asks;
use super::drags;
use super::memory;
use super::messages;
use super::other::{Act, Other};
use super::row::Row;
use super::views;
use crate::BenchError;

/// Makes what a row needs; what it does then.
pub(super) fn prepare(row: Row, other: &Other) -> Result<Act, BenchError> {
    match row {
        Row::Nobody => Ok(Box::new(|_| Ok(()))),
        Row::Solves => drags::solves(other),
        Row::SolvesInSession => drags::in_session(other),
        Row::LargeViews | Row::SlowLink => views::large(other),
        Row::SilentViews => views::silent(other),
        Row::RestingViews => views::resting(other),
        Row::ClosingViews => views::closing(other),
        Row::Stills16000 | Row::Stills64000 | Row::StillsOfPrimitives => asks::stills(other),
        Row::Imports => asks::imports(other),
        Row::Asks => asks::all(other),
        Row::Actors => asks::actors(other),
        Row::Messages => messages::flood(other),
        Row::ReadsNothing => memory::reads_nothing(other),
        Row::CutBodies => memory::cut_bodies(other),
    }
}
