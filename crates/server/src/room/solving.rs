//! Parts of commands that only the scene determines, solved on threads outside the session's task: the result of a
//! feature drag, the range of a light that is bent, and the hard pins that an edit keeps.

use std::cell::RefCell;
use std::task::Poll;

use document::{Command, CommandSolution, Document, EditError, fill_in_from_scene, needs_solution, solve_command};
use drag::WorkBudget;
use edit::{EditRequest, GroupedEdit};
use tokio::task::{AbortHandle, Id};

use super::grouping::{CompletedCommand, resolve_group};
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::MAX_SOLVE_TRIES;
use crate::request::{RecordAction, RequestedEdit, needs_scene};
use crate::scenes::DecodedScene;
use crate::solver::{SolveTurn, Solver};

/// Part of a step's result that depends on the scene.
#[derive(Clone)]
pub(super) enum StepSolution {
    /// The completed command, with its solution.
    Command(CompletedCommand),
    /// The edits of a group, each in the document after the ones before it.
    Group(Vec<GroupedEdit>),
}

/// A command with its result and the document that it was solved for.
pub(super) struct SolvedCommand {
    command: Command,
    document: Document,
    result: Result<CompletedCommand, EditError>,
}

/// Solves of one sequence of edits: of a client, or of a program's request.
#[derive(Default)]
pub(super) struct SolveState {
    /// Handle that aborts the running solve.
    pending: Option<AbortHandle>,
    /// The latest results, so that a commit need not repeat the solve of its last update. A group has one for each
    /// command that needs the scene.
    last: Vec<SolvedCommand>,
    /// Error of the latest solve, until the step that waits for the solve gets it.
    failed: Option<ServerError>,
    /// Number of solves that were started for the next step.
    attempts: u32,
}

/// The solution of a request. `None` if the request needs none.
pub(super) type FoundSolution = Option<Result<StepSolution, ServerError>>;

/// Completes a command with its solution.
pub(super) fn with_solution(command: Command, found: FoundSolution) -> Result<CompletedCommand, ServerError> {
    Ok(match found.transpose()? {
        Some(StepSolution::Command(completed)) => completed,
        Some(StepSolution::Group(_)) | None => CompletedCommand { command, solved: None },
    })
}

/// Builds the session's request for an action in this document, with the solution of its command. The solution of a
/// group is the request itself.
pub(super) fn into_edit_request(
    action: RecordAction,
    found: FoundSolution,
    document: &Document,
) -> Result<(EditRequest, Option<CommandSolution>), ServerError> {
    Ok(match (action, found) {
        (RecordAction::Edit(RequestedEdit { base_seq, command }), found) => {
            let CompletedCommand { command, solved } = with_solution(command.of(document)?, found)?;
            (EditRequest::Edit { base_seq, command }, solved)
        }
        (RecordAction::Group(_), Some(Ok(StepSolution::Group(edits)))) => (EditRequest::Group(edits), None),
        (RecordAction::Group(_), Some(Err(error))) => return Err(error),
        (RecordAction::Group(_), _) => return Err(ServerError::Internal),
        // A failed solve of a commit is reported at the end of the gesture.
        (RecordAction::Commit(id), Some(Ok(StepSolution::Command(completed)))) => {
            (EditRequest::Commit(id), completed.solved)
        }
        (RecordAction::Commit(id), _) => (EditRequest::Commit(id), None),
        (RecordAction::Undo(scope), _) => (EditRequest::Undo(scope), None),
        (RecordAction::Redo(scope), _) => (EditRequest::Redo(scope), None),
    })
}

impl SolvedCommand {
    /// True if the solve would give the same result for `document`.
    fn is_valid_for(&self, command: &Command, document: &Document) -> bool {
        let Some(light) = &command.light() else { return false };
        let is_same = self.command == *command || self.result.as_ref().is_ok_and(|done| done.command == *command);
        is_same
            && self.document.scene() == document.scene()
            && self.document.lights().get(light) == document.lights().get(light)
            && self.document.pins_of(*light).eq(document.pins_of(*light))
    }

    pub fn solution(&self) -> Result<StepSolution, ServerError> {
        Ok(StepSolution::Command(self.result.clone()?))
    }
}

impl SolveState {
    pub fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Takes the latest result for the command if it is valid for `document`.
    pub fn take_solution(&mut self, command: &Command, document: &Document) -> FoundSolution {
        let found = self.failed.take().map(Err).or_else(|| self.cached_solution(command, document));
        if found.is_some() {
            self.attempts = 0;
        }
        found
    }

    /// Takes the results for all commands of a group. Pending if a command has no valid result.
    pub fn take_group_solution(
        &mut self,
        edits: &[RequestedEdit],
        document: &Document,
        scene: &DecodedScene,
    ) -> Poll<FoundSolution> {
        if let Some(error) = self.failed.take() {
            self.attempts = 0;
            return Poll::Ready(Some(Err(error)));
        }
        let mut is_missing = false;
        let known = resolve_group(edits, document, scene, |command, draft| {
            let found = needs_scene(&command, draft).then(|| {
                self.cached_solution(&command, draft).unwrap_or_else(|| {
                    is_missing = true;
                    Err(ServerError::Internal)
                })
            });
            with_solution(command, found)
        });
        if is_missing {
            return Poll::Pending;
        }
        self.attempts = 0;
        Poll::Ready(Some(known.map(StepSolution::Group)))
    }

    fn cached_solution(&self, command: &Command, document: &Document) -> FoundSolution {
        Some(self.last.iter().find(|last| last.is_valid_for(command, document))?.solution())
    }

    /// True if the next step may start another solve.
    pub fn can_retry(&self) -> bool {
        self.attempts < MAX_SOLVE_TRIES
    }

    /// Notes a running solve.
    pub fn begin(&mut self, task: AbortHandle) {
        self.attempts += 1;
        self.pending = Some(task);
    }

    pub fn is_waiting_for(&self, task: Id) -> bool {
        self.pending.as_ref().is_some_and(|under_way| under_way.id() == task)
    }

    /// Stores the result of the running solve.
    pub fn end(&mut self, solved: Result<Vec<SolvedCommand>, ServerError>) {
        self.pending = None;
        match solved {
            Ok(solved) => self.last = solved,
            Err(error) => self.failed = Some(error),
        }
    }

    /// Drops the running solve and its result. The next step starts anew.
    pub fn cancel(&mut self) {
        (self.attempts, self.failed) = (0, None);
        if let Some(task) = self.pending.take() {
            task.abort();
        }
    }
}

pub(super) enum SolveTask {
    Command(Box<Command>),
    Group(Vec<RequestedEdit>),
}

/// Solves a command or group, starting from `document`, on a thread of the solver.
pub(super) async fn solve(
    task: SolveTask,
    document: Document,
    scene: DecodedScene,
    solver: &Solver,
    payer: Payer,
) -> Result<Vec<SolvedCommand>, ServerError> {
    let bvh = scene.bvh().await?;
    let solve = move |turn: &mut SolveTurn| {
        let turn = RefCell::new(turn);
        let may_continue = |steps| turn.borrow_mut().may_continue(steps);
        let solved = |command: &Command, document: &Document| {
            let completed = fill_in_from_scene(command.clone(), document, &bvh);
            let solution = needs_solution(document, &completed).then(|| {
                let work = WorkBudget::new(&may_continue);
                solve_command(document, &completed, bvh.posed.bounds(), &bvh, &work)
            });
            let result = solution.transpose().map(|solved| CompletedCommand { command: completed, solved });
            SolvedCommand { command: command.clone(), document: document.clone(), result }
        };
        match task {
            SolveTask::Command(command) => vec![solved(&command, &document)],
            SolveTask::Group(edits) => {
                let mut all = Vec::new();
                // The error is found again when the group is carried out.
                let _ = resolve_group(&edits, &document, &scene, |command, draft| {
                    let found = needs_scene(&command, draft).then(|| {
                        let solved = solved(&command, draft);
                        let answer = solved.solution();
                        all.push(solved);
                        answer
                    });
                    with_solution(command, found)
                });
                all
            }
        }
    };
    solver.run(payer, solve).await
}
