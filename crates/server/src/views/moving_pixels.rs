//! How many pixels each client has move, over all its sockets and sessions. What all of them together may have is bounded: past
//! that its pictures become smaller, so that no number of views takes more of the machine than one large one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use render::ViewSlot;

use crate::limits::{MAX_MOVING_PIXELS, MOVING_FOR};

/// How long after its last moving picture a view counts.
const COUNTED_FOR: Duration = Duration::from_secs(5);
/// Sides become shorter by steps of this share, so that a picture goes onto the one before for a while.
const STEPS: f64 = 16.0;

/// Of every actor that has a view that moves.
#[derive(Debug, Default)]
pub struct MovingPixels(Mutex<BTreeMap<Arc<str>, Vec<Moving>>>);

/// A view that moves.
#[derive(Clone, Copy, Debug)]
struct Moving {
    view: ViewSlot,
    pixels: u64,
    by_hand: bool,
    at: Instant,
}

/// By how much the sides of a moving picture are shorter than they would be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortened(f64);

impl Shortened {
    /// Not at all.
    pub const NOT: Self = Self(1.0);

    /// Width and height in pixels, of a picture that would have those.
    pub fn size(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| ((f64::from(side) * self.0) as u32).max(1))
    }
}

impl MovingPixels {
    /// A picture of an actor's view of `size` pixels is begun, which is moved `by_hand` by who sees it, or watched.
    pub fn note(
        &self,
        actor_id: &Arc<str>,
        (view, by_hand): (ViewSlot, bool),
        size: [u32; 2],
        now: Instant,
    ) -> Shortened {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let mut actors = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let views = actors.entry(Arc::clone(actor_id)).or_default();
        views.retain(|moving| moving.view != view && now.saturating_duration_since(moving.at) < COUNTED_FOR);
        views.push(Moving { view, pixels, by_hand, at: now });
        let all: u64 = views.iter().map(|moving| moving.pixels).sum();
        let rests = |of: &mut Vec<Moving>| {
            of.iter().all(|moving| now.saturating_duration_since(moving.at) >= COUNTED_FOR)
        };
        actors.retain(|_, views| !rests(views));
        if all <= MAX_MOVING_PIXELS {
            return Shortened::NOT;
        }
        let share = (MAX_MOVING_PIXELS as f64 / all as f64).sqrt();
        Shortened((share * STEPS).floor().max(1.0) / STEPS)
    }

    /// Whether several actors have views that moved lately.
    pub fn is_shared(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len() > 1
    }

    /// Whether a hand moves a view of any other actor than this one. Views that only show what this one moves do not count.
    pub fn move_for_another(&self, actor_id: Option<&Arc<str>>, now: Instant) -> bool {
        let actors = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut others = actors.iter().filter(|(id, _)| Some(*id) != actor_id);
        others.any(|(_, views)| {
            let lately = |moving: &&Moving| now.saturating_duration_since(moving.at) < MOVING_FOR;
            views.iter().filter(lately).any(|moving| moving.by_hand)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_views_of_an_actor_together_move_so_many_pixels_at_most() {
        let (account, ada, start) = (MovingPixels::default(), "ada".into(), Instant::now());
        let large = [3840, 2160];
        assert_eq!(account.note(&ada, (ViewSlot(1), true), large, start), Shortened::NOT);
        for _ in 0..2 {
            for view in 1..=8 {
                account.note(&ada, (ViewSlot(view), true), large, start);
            }
        }
        let sizes = (1..=8).map(|view| account.note(&ada, (ViewSlot(view), true), large, start).size(large));
        let all: u64 = sizes.map(|[width, height]| u64::from(width) * u64::from(height)).sum();
        assert!((MAX_MOVING_PIXELS / 2..=MAX_MOVING_PIXELS).contains(&all), "{all}");
        assert!(!account.move_for_another(Some(&ada), start) && account.move_for_another(None, start));
        assert!(!account.move_for_another(None, start + MOVING_FOR));
        // The planted fault: who watches a drag holds it up.
        let watched = MovingPixels::default();
        watched.note(&"ben".into(), (ViewSlot(1), false), large, start);
        assert!(!watched.move_for_another(Some(&ada), start));
        // Others are none of that, and what rests does not count. The planted fault: one account for all.
        assert_eq!(account.note(&"ben".into(), (ViewSlot(9), true), large, start), Shortened::NOT);
        assert_ne!(account.note(&ada, (ViewSlot(9), true), large, start), Shortened::NOT);
        let later = start + COUNTED_FOR;
        assert_eq!(account.note(&ada, (ViewSlot(1), true), large, later), Shortened::NOT);
        assert_eq!(account.0.lock().unwrap().len(), 1, "who rests is forgotten");
    }
}
