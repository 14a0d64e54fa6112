//! Drags of features as they are solved, on threads that may take their time.

use document::{Command, Document, EditError, SolvedDrag, solve_drag};
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::{AbortHandle, Id, spawn_blocking};

use crate::ServerError;
use crate::limits::SOLVES_BESIDE;
use crate::scenes::Decoded;

/// What a drag led to, and from where.
pub(super) struct Solved {
    command: Command,
    /// What it was solved for.
    document: Document,
    result: Result<SolvedDrag, EditError>,
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

/// Where the drag in a request leads; `None` where there is none in it.
pub(super) type FoundDrag = Option<Result<SolvedDrag, ServerError>>;

impl Solved {
    /// Whether the command would lead to the same from `document`.
    fn answers(&self, command: &Command, document: &Document) -> bool {
        let Command::DragFeature { light, .. } = command else { return false };
        self.command == *command
            && self.document.scene() == document.scene()
            && self.document.lights().get(light) == document.lights().get(light)
            && self.document.pins_of(*light).eq(document.pins_of(*light))
    }

    pub fn answer(&self) -> Result<SolvedDrag, ServerError> {
        self.result.clone().map_err(|refused| edit::Refusal::from(refused).into())
    }
}

impl Solves {
    /// Whether one is waited for.
    pub fn are_under_way(&self) -> bool {
        self.under_way.is_some()
    }

    /// What was found of the command last, if it would lead to the same from `document`.
    pub fn found(
        &mut self,
        command: &Command,
        document: &Document,
    ) -> Option<Result<SolvedDrag, ServerError>> {
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

/// Solves a drag, on a thread that may take its time.
pub(super) async fn solve(
    command: Command,
    document: Document,
    scene: Decoded,
    turn: Option<OwnedSemaphorePermit>,
) -> Result<Solved, ServerError> {
    let Command::DragFeature { light, drag } = &command else { return Err(ServerError::Fault) };
    let (light, drag, bvh) = (*light, drag.clone(), scene.bvh().await?);
    let solving = spawn_blocking(move || {
        let _turn = turn;
        let result = solve_drag(&document, light, &drag, &bvh);
        Solved { command, document, result }
    });
    solving.await.map_err(|_| ServerError::Fault)
}
