//! Groups of edits that make one step. Each edit is read in the document after the ones before it, including names.

use document::{Command, CommandSolution, Document, GroupedCommand, execute_command};
use edit::{EditRefusal, GroupedEdit};

use crate::ServerError;
use crate::request::RequestedEdit;
use crate::scenes::DecodedScene;

/// A command, completed from the scene, with its solution if it needs one.
#[derive(Clone)]
pub(super) struct CompletedCommand {
    pub command: Command,
    pub solved: Option<CommandSolution>,
}

/// Returns the edits as they apply from `document` on, in `scene`. `complete` completes a command from the scene in a
/// given document. An error names the edit that it comes from.
pub(super) fn resolve_group(
    requested: &[RequestedEdit],
    document: &Document,
    scene: &DecodedScene,
    mut complete: impl FnMut(Command, &Document) -> Result<CompletedCommand, ServerError>,
) -> Result<Vec<GroupedEdit>, ServerError> {
    let mut draft = document.clone();
    let mut edits = Vec::with_capacity(requested.len());
    for (index, RequestedEdit { base_seq, command }) in requested.iter().enumerate() {
        let mut next = || {
            let CompletedCommand { command, solved } = complete(command.of(&draft)?, &draft)?;
            draft = execute_command(&draft, &command, scene.context(None, solved.as_ref()))?.document;
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
