//! What only the scene can say of a command, worked out on threads that may take their time: where the drag of a feature leads,
//! and how far a light reaches that is bent.

use std::cell::RefCell;
use std::task::Poll;

use document::{Command, Document, EditError, SolvedDrag, fill_in_from_scene, solve_drag_budgeted};
use drag::WorkBudget;
use edit::{EditRefusal, EditRequest, GroupedEdit};
use light::SceneBounds;
use tokio::task::{AbortHandle, Id};

use super::grouping::resolve_group;
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::MAX_SOLVE_TRIES;
use crate::request::{RecordAction, RequestedEdit, needs_scene};
use crate::scenes::DecodedScene;
use crate::solver::{SolveTurn, Solver};

/// What the scene says of a command.
#[derive(Clone)]
pub(super) enum CommandSolution {
    /// Where the drag of a feature leads.
    Drag(SolvedDrag),
    /// How a light is bent: the command with nothing left out.
    Bend(Command),
    /// The edits of a group, in the document that those before leave.
    Group(Vec<GroupedEdit>),
}

/// What a command led to, and from where.
pub(super) struct SolvedCommand {
    command: Command,
    /// What it was solved for.
    document: Document,
    result: Result<CommandSolution, EditError>,
}

/// The solves of one who edits in order, a client or a program's request.
#[derive(Default)]
pub(super) struct SolveState {
    /// The one that is waited for.
    pending: Option<AbortHandle>,
    /// What was solved last, so that a commit need not solve again what the last update did; of a group one for each command that
    /// needs the scene.
    last: Vec<SolvedCommand>,
    /// Why the latest could not be solved, until the step that waited for it is told.
    failed: Option<ServerError>,
    /// How many were begun for the step that is next.
    attempts: u32,
}

/// The solution of what a request asks for; `None` where that needs none.
pub(super) type FoundSolution = Option<Result<CommandSolution, ServerError>>;

/// A command as it is carried out, and where the drag in it leads.
pub(super) fn with_solution(
    command: Command,
    found: FoundSolution,
) -> Result<(Command, Option<SolvedDrag>), ServerError> {
    Ok(match found.transpose()? {
        Some(CommandSolution::Drag(solved)) => (command, Some(solved)),
        Some(CommandSolution::Bend(command)) => (command, None),
        Some(CommandSolution::Group(_)) | None => (command, None),
    })
}

/// What is asked for as a request of a session with this document, and where the drag in it leads. Of a group what was found is the
/// request.
pub(super) fn into_edit_request(
    asked: RecordAction,
    found: FoundSolution,
    document: &Document,
) -> Result<(EditRequest, Option<SolvedDrag>), ServerError> {
    Ok(match (asked, found) {
        (RecordAction::Edit(RequestedEdit { base_seq, command }), found) => {
            let (command, solved) = with_solution(command.of(document)?, found)?;
            (EditRequest::Edit { base_seq, command }, solved)
        }
        (RecordAction::Group(_), Some(Ok(CommandSolution::Group(edits)))) => {
            (EditRequest::Group(edits), None)
        }
        (RecordAction::Group(_), Some(Err(error))) => return Err(error),
        (RecordAction::Group(_), _) => return Err(ServerError::Internal),
        // What stands in its way now is said where the gesture ends.
        (RecordAction::Commit(id), Some(Ok(CommandSolution::Drag(solved)))) => {
            (EditRequest::Commit(id), Some(solved))
        }
        (RecordAction::Commit(id), _) => (EditRequest::Commit(id), None),
        (RecordAction::Undo(scope), _) => (EditRequest::Undo(scope), None),
        (RecordAction::Redo(scope), _) => (EditRequest::Redo(scope), None),
    })
}

impl SolvedCommand {
    /// Whether the command would lead to the same from `document`.
    fn is_valid_for(&self, command: &Command, document: &Document) -> bool {
        let (Command::DragFeature { light, .. } | Command::BendLight { light, .. }) = command else {
            return false;
        };
        self.command == *command
            && self.document.scene() == document.scene()
            && self.document.lights().get(light) == document.lights().get(light)
            && self.document.pins_of(*light).eq(document.pins_of(*light))
    }

    pub fn solution(&self) -> Result<CommandSolution, ServerError> {
        self.result.clone().map_err(|refused| EditRefusal::from(refused).into())
    }
}

impl SolveState {
    /// Whether one is waited for.
    pub fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// What was found of the command last, if it would lead to the same from `document`.
    pub fn take_solution(&mut self, command: &Command, document: &Document) -> FoundSolution {
        let found = self.failed.take().map(Err).or_else(|| self.cached_solution(command, document));
        if found.is_some() {
            self.attempts = 0;
        }
        found
    }

    /// The same of a group; pending where something of it has to be solved.
    pub fn take_group_solution(
        &mut self,
        edits: &[RequestedEdit],
        document: &Document,
        reach: SceneBounds,
    ) -> Poll<FoundSolution> {
        if let Some(error) = self.failed.take() {
            self.attempts = 0;
            return Poll::Ready(Some(Err(error)));
        }
        let mut is_missing = false;
        let known = resolve_group(edits, document, reach, |command, draft| {
            let found = needs_scene(&command).then(|| {
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
        Poll::Ready(Some(known.map(CommandSolution::Group)))
    }

    fn cached_solution(&self, command: &Command, document: &Document) -> FoundSolution {
        Some(self.last.iter().find(|last| last.is_valid_for(command, document))?.solution())
    }

    /// Whether the step that is next may be solved once more.
    pub fn can_retry(&self) -> bool {
        self.attempts < MAX_SOLVE_TRIES
    }

    /// Waits for a solve from now on.
    pub fn begin(&mut self, task: AbortHandle) {
        self.attempts += 1;
        self.pending = Some(task);
    }

    /// Whether it is this one that is waited for.
    pub fn is_waiting_for(&self, task: Id) -> bool {
        self.pending.as_ref().is_some_and(|under_way| under_way.id() == task)
    }

    /// Keeps what the solve that was waited for has come to.
    pub fn end(&mut self, solved: Result<Vec<SolvedCommand>, ServerError>) {
        self.pending = None;
        match solved {
            Ok(solved) => self.last = solved,
            Err(error) => self.failed = Some(error),
        }
    }

    /// Waits for none any more, and what comes of one under way is of no use. The next step is another.
    pub fn cancel(&mut self) {
        (self.attempts, self.failed) = (0, None);
        if let Some(task) = self.pending.take() {
            task.abort();
        }
    }
}

/// What is to be solved: a command, or what needs it of a group.
pub(super) enum SolveTask {
    Command(Box<Command>),
    Group(Vec<RequestedEdit>),
}

/// Solves it from `document` on, on a thread of its own and in turns with others.
pub(super) async fn solve(
    what: SolveTask,
    document: Document,
    scene: DecodedScene,
    (solver, payer): (&Solver, Payer),
) -> Result<Vec<SolvedCommand>, ServerError> {
    let (bvh, reach) = (scene.bvh().await?, scene.posed.bounds());
    let solve = move |turn: &mut SolveTurn| {
        let turn = RefCell::new(turn);
        let goes_on = |steps| turn.borrow_mut().may_continue(steps);
        let solved = |command: &Command, document: &Document| {
            let result = match command {
                Command::DragFeature { light, drag } => {
                    let work = WorkBudget::new(&goes_on);
                    solve_drag_budgeted(document, *light, drag, &bvh, &work).map(CommandSolution::Drag)
                }
                other => Ok(CommandSolution::Bend(fill_in_from_scene(other.clone(), document, &bvh))),
            };
            SolvedCommand { command: command.clone(), document: document.clone(), result }
        };
        match what {
            SolveTask::Command(command) => vec![solved(&command, &document)],
            SolveTask::Group(edits) => {
                let mut all = Vec::new();
                // What is refused of it is found again where the group is carried out.
                let _ = resolve_group(&edits, &document, reach, |command, draft| {
                    let found = needs_scene(&command).then(|| {
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
