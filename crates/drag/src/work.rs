//! What a drag may cost: counted in steps, so that the same drag ends at the same place on every machine.

use std::cell::Cell;
use std::fmt;

/// Steps that a drag takes at most to find a light. One takes from half of a nanosecond to three of one core, mostly one: so some
/// three seconds. `bendylights-studies work` measures what drags take, and searches for those that take most.
pub const MAX_DRAG_STEPS: u64 = 3_000_000_000;

/// The share of a drag's steps in which what was found by then is looked at.
const JUDGING_FRACTION: u64 = 8;

/// Steps between two questions whether a drag goes on.
pub const STEPS_BETWEEN_CHECKS: u64 = 2_000_000;

/// Steps of a box of the scene that a ray comes near to, in which [`raycast`] counts.
const STEPS_OF_BOX: u64 = 10;

/// Counts the steps of one drag and ends it: where it has taken as many as it may, and where whoever asked for it has given it up.
///
/// Once it is over nothing can be evaluated any more, so that every search comes to its end at once.
pub struct WorkBudget<'a> {
    spent: Cell<u64>,
    limit_steps: Cell<u64>,
    /// As many more may be taken to look at what was found.
    judging: u64,
    /// When it is asked next whether the drag goes on.
    next_check_at: Cell<u64>,
    should_continue: &'a dyn Fn(u64) -> bool,
    is_given_up: Cell<bool>,
}

impl fmt::Debug for WorkBudget<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Work({} of {} steps)", self.spent.get(), self.limit_steps.get())
    }
}

impl<'a> WorkBudget<'a> {
    /// Nothing yet. `should_continue` is asked every [`STEPS_BETWEEN_CHECKS`], with the number of steps until then, whether the drag
    /// goes on; it may take its time.
    pub fn new(goes_on: &'a dyn Fn(u64) -> bool) -> Self {
        Self::with_limit(MAX_DRAG_STEPS, goes_on)
    }

    /// The same with another bound than [`MAX_DRAG_STEPS`].
    pub fn with_limit(most: u64, should_continue: &'a dyn Fn(u64) -> bool) -> Self {
        Self {
            spent: Cell::new(0),
            limit_steps: Cell::new(most),
            judging: most / JUDGING_FRACTION,
            next_check_at: Cell::new(STEPS_BETWEEN_CHECKS),
            should_continue,
            is_given_up: Cell::new(false),
        }
    }

    /// Takes steps, and says whether there may be more.
    pub(crate) fn spend(&self, steps: u64) -> bool {
        let spent = self.spent.get() + steps;
        if spent > self.limit_steps.get() || self.is_given_up.get() {
            self.limit_steps.set(0);
            return false;
        }
        self.spent.set(spent);
        if spent >= self.next_check_at.get() {
            self.next_check_at.set(spent + STEPS_BETWEEN_CHECKS);
            if !(self.should_continue)(spent) {
                self.is_given_up.set(true);
                self.limit_steps.set(0);
                return false;
            }
        }
        true
    }

    /// Takes steps along rays, as [`raycast`] counts them.
    pub(crate) fn spend_on_rays(&self, boxes: u64) -> bool {
        self.spend(STEPS_OF_BOX * boxes)
    }

    /// Whether nothing can be evaluated any more, and what came of the latest evaluations means nothing.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.limit_steps.get() == 0
    }

    /// Goes on for as long as it takes to look at what was found, unless the drag was given up.
    pub(crate) fn allow_judging(&self) {
        if !self.is_given_up.get() {
            self.limit_steps.set(self.spent.get() + self.judging);
        }
    }

    /// Whether whoever asked for the drag has given it up.
    pub fn is_cancelled(&self) -> bool {
        self.is_given_up.get()
    }

    /// Steps until now.
    pub fn spent_steps(&self) -> u64 {
        self.spent.get()
    }
}
