//! What only the scene can say of a command, worked out on threads that may take their time: where the drag of a feature leads,
//! and how far a light reaches that is bent.

use std::cell::RefCell;
use std::task::Poll;

use document::{Command, Document, EditError, SolvedDrag, resolved, solve_drag_within};
use drag::Work;
use edit::{GroupedEdit, Refusal, Request};
use light::Reach;
use tokio::task::{AbortHandle, Id};

use super::grouping::grouped;
use crate::ServerError;
use crate::limits::MAX_SOLVE_TRIES;
use crate::request::{Asked, AskedEdit, needs_scene};
use crate::scenes::Decoded;
use crate::solver::{Solver, Turn};
use crate::turns::Payer;

/// What the scene says of a command.
#[derive(Clone)]
pub(super) enum Solution {
    /// Where the drag of a feature leads.
    Drag(SolvedDrag),
    /// How a light is bent: the command with nothing left out.
    Bend(Command),
    /// The edits of a group, in the document that those before leave.
    Group(Vec<GroupedEdit>),
}

/// What a command led to, and from where.
pub(super) struct Solved {
    command: Command,
    /// What it was solved for.
    document: Document,
    result: Result<Solution, EditError>,
}

/// The solves of one who edits in order, a client or a program's request.
#[derive(Default)]
pub(super) struct Solves {
    /// The one that is waited for.
    under_way: Option<AbortHandle>,
    /// What was solved last, so that a commit need not solve again what the last update did; of a group one for each command that
    /// needs the scene.
    last: Vec<Solved>,
    /// Why the latest could not be solved, until the step that waited for it is told.
    failed: Option<ServerError>,
    /// How many were begun for the step that is next.
    begun: u32,
}

/// The solution of what a request asks for; `None` where that needs none.
pub(super) type Found = Option<Result<Solution, ServerError>>;

/// A command as it is carried out, and where the drag in it leads.
pub(super) fn with_solution(
    command: Command,
    found: Found,
) -> Result<(Command, Option<SolvedDrag>), ServerError> {
    Ok(match found.transpose()? {
        Some(Solution::Drag(solved)) => (command, Some(solved)),
        Some(Solution::Bend(command)) => (command, None),
        Some(Solution::Group(_)) | None => (command, None),
    })
}

/// What is asked for as a request of a session with this document, and where the drag in it leads. Of a group what was found is the
/// request.
pub(super) fn request_of(
    asked: Asked,
    found: Found,
    document: &Document,
) -> Result<(Request, Option<SolvedDrag>), ServerError> {
    Ok(match (asked, found) {
        (Asked::Edit(AskedEdit { base_seq, command }), found) => {
            let (command, solved) = with_solution(command.of(document)?, found)?;
            (Request::Edit { base_seq, command }, solved)
        }
        (Asked::Group(_), Some(Ok(Solution::Group(edits)))) => (Request::Group(edits), None),
        (Asked::Group(_), Some(Err(error))) => return Err(error),
        (Asked::Group(_), _) => return Err(ServerError::Fault),
        // What stands in its way now is said where the gesture ends.
        (Asked::Commit(id), Some(Ok(Solution::Drag(solved)))) => (Request::Commit(id), Some(solved)),
        (Asked::Commit(id), _) => (Request::Commit(id), None),
        (Asked::Undo(scope), _) => (Request::Undo(scope), None),
        (Asked::Redo(scope), _) => (Request::Redo(scope), None),
    })
}

impl Solved {
    /// Whether the command would lead to the same from `document`.
    fn answers(&self, command: &Command, document: &Document) -> bool {
        let (Command::DragFeature { light, .. } | Command::BendLight { light, .. }) = command else {
            return false;
        };
        self.command == *command
            && self.document.scene() == document.scene()
            && self.document.lights().get(light) == document.lights().get(light)
            && self.document.pins_of(*light).eq(document.pins_of(*light))
    }

    pub fn answer(&self) -> Result<Solution, ServerError> {
        self.result.clone().map_err(|refused| Refusal::from(refused).into())
    }
}

impl Solves {
    /// Whether one is waited for.
    pub fn are_under_way(&self) -> bool {
        self.under_way.is_some()
    }

    /// What was found of the command last, if it would lead to the same from `document`.
    pub fn found(&mut self, command: &Command, document: &Document) -> Found {
        let found = self.failed.take().map(Err).or_else(|| self.known(command, document));
        if found.is_some() {
            self.begun = 0;
        }
        found
    }

    /// The same of a group; pending where something of it has to be solved.
    pub fn found_of_group(&mut self, edits: &[AskedEdit], document: &Document, reach: Reach) -> Poll<Found> {
        if let Some(error) = self.failed.take() {
            self.begun = 0;
            return Poll::Ready(Some(Err(error)));
        }
        let mut is_missing = false;
        let known = grouped(edits, document, reach, |command, draft| {
            let found = needs_scene(&command).then(|| {
                self.known(&command, draft).unwrap_or_else(|| {
                    is_missing = true;
                    Err(ServerError::Fault)
                })
            });
            with_solution(command, found)
        });
        if is_missing {
            return Poll::Pending;
        }
        self.begun = 0;
        Poll::Ready(Some(known.map(Solution::Group)))
    }

    fn known(&self, command: &Command, document: &Document) -> Found {
        Some(self.last.iter().find(|last| last.answers(command, document))?.answer())
    }

    /// Whether the step that is next may be solved once more.
    pub fn may_begin(&self) -> bool {
        self.begun < MAX_SOLVE_TRIES
    }

    /// Waits for a solve from now on.
    pub fn begin(&mut self, task: AbortHandle) {
        self.begun += 1;
        self.under_way = Some(task);
    }

    /// Whether it is this one that is waited for.
    pub fn wait_for(&self, task: Id) -> bool {
        self.under_way.as_ref().is_some_and(|under_way| under_way.id() == task)
    }

    /// Keeps what the solve that was waited for has come to.
    pub fn end(&mut self, solved: Result<Vec<Solved>, ServerError>) {
        self.under_way = None;
        match solved {
            Ok(solved) => self.last = solved,
            Err(error) => self.failed = Some(error),
        }
    }

    /// Waits for none any more, and what comes of one under way is of no use. The next step is another.
    pub fn stop_waiting(&mut self) {
        (self.begun, self.failed) = (0, None);
        if let Some(task) = self.under_way.take() {
            task.abort();
        }
    }
}

/// What is to be solved: a command, or what needs it of a group.
pub(super) enum ToSolve {
    Command(Box<Command>),
    Group(Vec<AskedEdit>),
}

/// Solves it from `document` on, on a thread of its own and in turns with others.
pub(super) async fn solve(
    what: ToSolve,
    document: Document,
    scene: Decoded,
    (solver, payer): (&Solver, Payer),
) -> Result<Vec<Solved>, ServerError> {
    let (bvh, reach) = (scene.bvh().await?, scene.posed.reach());
    let solve = move |turn: &mut Turn| {
        let turn = RefCell::new(turn);
        let goes_on = |steps| turn.borrow_mut().goes_on(steps);
        let solved = |command: &Command, document: &Document| {
            let result = match command {
                Command::DragFeature { light, drag } => {
                    let work = Work::new(&goes_on);
                    solve_drag_within(document, *light, drag, &bvh, &work).map(Solution::Drag)
                }
                other => Ok(Solution::Bend(resolved(other.clone(), document, &bvh))),
            };
            Solved { command: command.clone(), document: document.clone(), result }
        };
        match what {
            ToSolve::Command(command) => vec![solved(&command, &document)],
            ToSolve::Group(edits) => {
                let mut all = Vec::new();
                // What is refused of it is found again where the group is carried out.
                let _ = grouped(&edits, &document, reach, |command, draft| {
                    let found = needs_scene(&command).then(|| {
                        let solved = solved(&command, draft);
                        let answer = solved.answer();
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
