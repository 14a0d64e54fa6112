//! Edits that are one step: each is read in the document that those before it leave, names and all.

use document::{Command, CommandContext, Document, GroupedCommand, SolvedDrag, execute_command};
use edit::{EditRefusal, GroupedEdit};
use light::SceneBounds;

use crate::ServerError;
use crate::request::RequestedEdit;

/// The edits as they are carried out from `document` on. `solved` gives a command with what the scene says of it in a document, and
/// where the drag in it leads. Where one is refused the sentence says which.
pub(super) fn resolve_group(
    asked: &[RequestedEdit],
    document: &Document,
    reach: SceneBounds,
    mut solved: impl FnMut(Command, &Document) -> Result<(Command, Option<SolvedDrag>), ServerError>,
) -> Result<Vec<GroupedEdit>, ServerError> {
    let mut draft = document.clone();
    let mut edits = Vec::with_capacity(asked.len());
    for (index, RequestedEdit { base_seq, command }) in asked.iter().enumerate() {
        let mut next = || {
            let (command, solved) = solved(command.of(&draft)?, &draft)?;
            let context = CommandContext { scene_bounds: reach, loaded: None, solved: solved.as_ref() };
            draft = execute_command(&draft, &command, context).map_err(EditRefusal::from)?.document;
            Ok(GroupedEdit { base_seq: *base_seq, grouped: GroupedCommand { command, solved } })
        };
        edits.push(next().map_err(|error| in_group_error(index, error))?);
    }
    Ok(edits)
}

/// Why a group is refused for one of its edits. What is only of the moment stays as it is.
pub fn in_group_error(index: usize, error: ServerError) -> ServerError {
    match error {
        ServerError::Refused(refusal) => EditRefusal::in_group(index, refusal).into(),
        error if error.is_transient() => error,
        error => ServerError::InGroup { number: index + 1, reason: Box::new(error) },
    }
}
