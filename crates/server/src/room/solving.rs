//! What only the scene can say of a command, worked out on threads that may take their time: where the drag of a feature leads,
//! and how far a light reaches that is bent.

use document::{Command, Document, EditError, SolvedDrag, resolved, solve_drag};
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::{AbortHandle, Id, spawn_blocking};

use crate::ServerError;
use crate::limits::SOLVES_BESIDE;
use crate::scenes::Decoded;

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
        let last = self.last.as_deref().filter(|last| last.answers(command, document))?;
        self.begun = 0;
        Some(last.answer())
    }

    /// Whether the step that is next may be solved beside the session once more.
    pub fn may_begin(&self) -> bool {
        self.begun < SOLVES_BESIDE
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

    /// Keeps what the solve that was waited for has come to. Where it failed the session itself solves next: there it fails
    /// again, or leads somewhere.
    pub fn end(&mut self, solved: Option<Solved>) {
        self.under_way = None;
        match solved {
            Some(solved) => self.last = Some(Box::new(solved)),
            None => self.begun = SOLVES_BESIDE,
        }
    }

    /// Waits for none any more, and what comes of one under way is of no use. The next step is another.
    pub fn stop_waiting(&mut self) {
        self.begun = 0;
        if let Some(task) = self.under_way.take() {
            task.abort();
        }
    }
}

/// Solves a command that needs it, on a thread that may take its time.
pub(super) async fn solve(
    command: Command,
    document: Document,
    scene: Decoded,
    turn: Option<OwnedSemaphorePermit>,
) -> Result<Solved, ServerError> {
    let bvh = scene.bvh().await?;
    let solving = spawn_blocking(move || {
        let _turn = turn;
        let result = match &command {
            Command::DragFeature { light, drag } => {
                solve_drag(&document, *light, drag, &bvh).map(Solution::Drag)
            }
            other => Ok(Solution::Bend(resolved(other.clone(), &document, &bvh))),
        };
        Solved { command, document, result }
    });
    solving.await.map_err(|_| ServerError::Fault)
}
