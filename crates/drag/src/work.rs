//! What a drag may cost: counted in steps, so that the same drag ends at the same place on every machine.

use std::cell::Cell;
use std::fmt;

/// Steps that a drag takes at most to find a light. One takes from half of a nanosecond to three of one core, mostly one: so some
/// three seconds. `bendylights-studies work` measures what drags take, and searches for those that take most.
pub const MOST_STEPS: u64 = 3_000_000_000;

/// The share of a drag's steps in which what was found by then is looked at.
const SHARE_OF_JUDGING: u64 = 8;

/// Steps between two questions whether a drag goes on.
pub const STEPS_BETWEEN_QUESTIONS: u64 = 2_000_000;

/// Steps of a box of the scene that a ray comes near to, in which [`raycast`] counts.
const STEPS_OF_BOX: u64 = 10;

/// Counts the steps of one drag and ends it: where it has taken as many as it may, and where whoever asked for it has given it up.
///
/// Once it is over nothing can be evaluated any more, so that every search comes to its end at once.
pub struct Work<'a> {
    spent: Cell<u64>,
    most: Cell<u64>,
    /// As many more may be taken to look at what was found.
    judging: u64,
    /// When it is asked next whether the drag goes on.
    question_at: Cell<u64>,
    goes_on: &'a dyn Fn(u64) -> bool,
    is_given_up: Cell<bool>,
}

impl fmt::Debug for Work<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Work({} of {} steps)", self.spent.get(), self.most.get())
    }
}

impl<'a> Work<'a> {
    /// Nothing yet. `goes_on` is asked every [`STEPS_BETWEEN_QUESTIONS`], with the number of steps until then, whether the drag
    /// goes on; it may take its time.
    pub fn new(goes_on: &'a dyn Fn(u64) -> bool) -> Self {
        Self::within(MOST_STEPS, goes_on)
    }

    /// The same with another bound than [`MOST_STEPS`].
    pub fn within(most: u64, goes_on: &'a dyn Fn(u64) -> bool) -> Self {
        Self {
            spent: Cell::new(0),
            most: Cell::new(most),
            judging: most / SHARE_OF_JUDGING,
            question_at: Cell::new(STEPS_BETWEEN_QUESTIONS),
            goes_on,
            is_given_up: Cell::new(false),
        }
    }

    /// Takes steps, and says whether there may be more.
    pub(crate) fn spend(&self, steps: u64) -> bool {
        let spent = self.spent.get() + steps;
        if spent > self.most.get() || self.is_given_up.get() {
            self.most.set(0);
            return false;
        }
        self.spent.set(spent);
        if spent >= self.question_at.get() {
            self.question_at.set(spent + STEPS_BETWEEN_QUESTIONS);
            if !(self.goes_on)(spent) {
                self.is_given_up.set(true);
                self.most.set(0);
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
    pub(crate) fn is_over(&self) -> bool {
        self.most.get() == 0
    }

    /// Goes on for as long as it takes to look at what was found, unless the drag was given up.
    pub(crate) fn allow_judging(&self) {
        if !self.is_given_up.get() {
            self.most.set(self.spent.get() + self.judging);
        }
    }

    /// Whether whoever asked for the drag has given it up.
    pub fn is_given_up(&self) -> bool {
        self.is_given_up.get()
    }

    /// Steps until now.
    pub fn spent(&self) -> u64 {
        self.spent.get()
    }
}
