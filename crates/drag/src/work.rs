//! Budget of a drag, counted in steps, so that the same drag ends at the same light on every machine.

use std::cell::Cell;
use std::fmt;

/// Most steps that a drag takes to find a light. A step takes half a nanosecond to three of one core, mostly one, so
/// all take about three seconds. `bendylights-studies work` measures the steps of drags, and searches for the drags
/// that take most.
pub const MAX_DRAG_STEPS: u64 = 3_000_000_000;

/// Steps between two checks if a drag should continue.
pub const STEPS_BETWEEN_CHECKS: u64 = 2_000_000;

/// Cost of one unit of ray work, in steps: a box or triangle near a ray, as [`raycast`] counts them.
const STEPS_OF_BOX: u64 = 10;

/// Counts the steps of one drag, and ends the drag at the step limit or if the caller cancels it.
///
/// Once the budget is spent, no light can be evaluated any more. So every search ends at once.
pub struct WorkBudget<'a> {
    spent: Cell<u64>,
    limit_steps: Cell<u64>,
    /// Step count of the next check.
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
    /// Makes a budget of `MAX_DRAG_STEPS`. Every [`STEPS_BETWEEN_CHECKS`] steps it calls `goes_on` with the number of
    /// steps so far, and ends the drag if that returns false. The callback may block.
    pub fn new(goes_on: &'a dyn Fn(u64) -> bool) -> Self {
        Self::with_limit(MAX_DRAG_STEPS, goes_on)
    }

    /// Makes a budget with another limit than [`MAX_DRAG_STEPS`].
    pub fn with_limit(most: u64, should_continue: &'a dyn Fn(u64) -> bool) -> Self {
        Self {
            spent: Cell::new(0),
            limit_steps: Cell::new(most),
            next_check_at: Cell::new(STEPS_BETWEEN_CHECKS),
            should_continue,
            is_given_up: Cell::new(false),
        }
    }

    /// Spends steps, and returns false if the budget is spent.
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

    /// Spends steps for ray work, as [`raycast`] counts it.
    pub(crate) fn spend_on_rays(&self, boxes: u64) -> bool {
        self.spend(STEPS_OF_BOX * boxes)
    }

    /// True if nothing can be evaluated any more. The latest evaluations then have no meaning.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.limit_steps.get() == 0
    }

    /// True if the caller cancelled the drag.
    pub fn is_cancelled(&self) -> bool {
        self.is_given_up.get()
    }

    /// Returns the number of steps so far.
    pub fn spent_steps(&self) -> u64 {
        self.spent.get()
    }
}
