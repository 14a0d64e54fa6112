//! What only the scene can say of a command, worked out on threads that may take their time: where the drag of a feature leads,
//! and how far a light reaches that is bent.

use std::cell::RefCell;

use document::{Command, Document, EditError, SolvedDrag, resolved, solve_drag_within};
use drag::Work;
use tokio::task::{AbortHandle, Id};

use crate::ServerError;
use crate::limits::MAX_SOLVE_TRIES;
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
    /// What was solved last, so that a commit need not solve again what the last update did.
    last: Option<Box<Solved>>,
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
        None => (command, None),
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
        self.result.clone().map_err(|refused| edit::Refusal::from(refused).into())
    }
}

impl Solves {
    /// Whether one is waited for.
    pub fn are_under_way(&self) -> bool {
        self.under_way.is_some()
    }

    /// What was found of the command last, if it would lead to the same from `document`.
    pub fn found(&mut self, command: &Command, document: &Document) -> Found {
        if let Some(error) = self.failed.take() {
            self.begun = 0;
            return Some(Err(error));
        }
        let last = self.last.as_deref().filter(|last| last.answers(command, document))?;
        self.begun = 0;
        Some(last.answer())
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
    pub fn end(&mut self, solved: Result<Solved, ServerError>) {
        self.under_way = None;
        match solved {
            Ok(solved) => self.last = Some(Box::new(solved)),
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

/// Solves a command that needs it, on a thread of its own and in turns with others.
pub(super) async fn solve(
    command: Command,
    document: Document,
    scene: Decoded,
    (solver, payer): (&Solver, Payer),
) -> Result<Solved, ServerError> {
    let bvh = scene.bvh().await?;
    let solve = move |turn: &mut Turn| {
        let turn = RefCell::new(turn);
        let goes_on = |steps| turn.borrow_mut().goes_on(steps);
        let result = match &command {
            Command::DragFeature { light, drag } => {
                let work = Work::new(&goes_on);
                solve_drag_within(&document, *light, drag, &bvh, &work).map(Solution::Drag)
            }
            other => Ok(Solution::Bend(resolved(other.clone(), &document, &bvh))),
        };
        Solved { command, document, result }
    };
    solver.run(payer, solve).await
}
