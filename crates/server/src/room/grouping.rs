//! Groups of edits that make one step. Each edit is read in the document after the ones before it, including names.

use document::{Command, CommandContext, Document, GroupedCommand, SolvedDrag, execute_command};
use edit::{EditRefusal, GroupedEdit};
use light::SceneBounds;

use crate::ServerError;
use crate::request::RequestedEdit;

/// Returns the edits as they apply from `document` on. `solved` completes a command from the scene in a given document
/// and adds the solution of its drag. An error names the edit that it comes from.
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

/// Adds the number of the edit to the error of a group. Transient errors stay as they are.
pub fn in_group_error(index: usize, error: ServerError) -> ServerError {
    match error {
        ServerError::Refused(refusal) => EditRefusal::in_group(index, refusal).into(),
        error if error.is_transient() => error,
        error => ServerError::InGroup { number: index + 1, reason: Box::new(error) },
    }
}
