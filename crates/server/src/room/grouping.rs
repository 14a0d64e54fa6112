//! Edits that are one step: each is read in the document that those before it leave, names and all.

use document::{Command, Context, Document, GroupedCommand, SolvedDrag, edited};
use edit::{GroupedEdit, Refusal};
use light::Reach;

use crate::ServerError;
use crate::request::AskedEdit;

/// The edits as they are carried out from `document` on. `solved` gives a command with what the scene says of it in a document, and
/// where the drag in it leads. Where one is refused the sentence says which.
pub(super) fn grouped(
    asked: &[AskedEdit],
    document: &Document,
    reach: Reach,
    mut solved: impl FnMut(Command, &Document) -> Result<(Command, Option<SolvedDrag>), ServerError>,
) -> Result<Vec<GroupedEdit>, ServerError> {
    let mut draft = document.clone();
    let mut edits = Vec::with_capacity(asked.len());
    for (index, AskedEdit { base_seq, command }) in asked.iter().enumerate() {
        let mut next = || {
            let (command, solved) = solved(command.of(&draft)?, &draft)?;
            let context = Context { reach, loaded: None, solved: solved.as_ref() };
            draft = edited(&draft, &command, context).map_err(Refusal::from)?.document;
            Ok(GroupedEdit { base_seq: *base_seq, grouped: GroupedCommand { command, solved } })
        };
        edits.push(next().map_err(|error| of_group(index, error))?);
    }
    Ok(edits)
}

/// Why a group is refused for one of its edits. What is only of the moment stays as it is.
pub fn of_group(index: usize, error: ServerError) -> ServerError {
    match error {
        ServerError::Refused(refusal) => Refusal::of_group(index, refusal).into(),
        error if error.is_of_the_moment() => error,
        error => ServerError::OfGroup { number: index + 1, reason: Box::new(error) },
    }
}
