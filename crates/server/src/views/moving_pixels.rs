//! Pixels of moving views per actor, over all sockets and sessions. Their sum is limited. Above the limit the actor's
//! pictures become smaller, so many views take no more of the machine than one large view.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use render::ViewSlot;

use crate::limits::{MAX_MOVING_PIXELS, MOVING_FOR};

/// Time after its last moving picture during which a view counts.
const MOVING_VIEW_LIFETIME: Duration = Duration::from_secs(5);
/// Steps per side in which pictures become smaller, so that several consecutive ones have the same size and can share
/// tiles.
const SIZE_STEPS: f64 = 16.0;

/// The moving views of each actor.
#[derive(Debug, Default)]
pub struct MovingPixels(Mutex<BTreeMap<Arc<str>, Vec<MovingView>>>);

#[derive(Clone, Copy, Debug)]
struct MovingView {
    view: ViewSlot,
    pixels: u64,
    is_interactive: bool,
    at: Instant,
}

/// Scale of a moving picture's sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureScale(f64);

impl PictureScale {
    /// Scale of a picture that is not reduced.
    pub const FULL: Self = Self(1.0);

    /// Scales a width and height in pixels.
    pub fn size(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| ((f64::from(side) * self.0) as u32).max(1))
    }
}

impl MovingPixels {
    /// Notes the start of a picture of an actor's view of `size` pixels, and returns its scale. `is_interactive` is
    /// true if the viewer moves the view, and false if it only watches.
    pub fn record_picture(
        &self,
        actor_id: &Arc<str>,
        view: ViewSlot,
        is_interactive: bool,
        size: [u32; 2],
        now: Instant,
    ) -> PictureScale {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let counts = |moving: &MovingView| now.saturating_duration_since(moving.at) < MOVING_VIEW_LIFETIME;
        let mut actors = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let views = actors.entry(Arc::clone(actor_id)).or_default();
        views.retain(|moving| moving.view != view && counts(moving));
        views.push(MovingView { view, pixels, is_interactive, at: now });
        let all: u64 = views.iter().map(|moving| moving.pixels).sum();
        actors.retain(|_, views| views.iter().any(counts));
        if all <= MAX_MOVING_PIXELS {
            return PictureScale::FULL;
        }
        let share = (MAX_MOVING_PIXELS as f64 / all as f64).sqrt();
        PictureScale((share * SIZE_STEPS).floor().max(1.0) / SIZE_STEPS)
    }

    /// True if several actors have views that moved lately.
    pub fn is_shared(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len() > 1
    }

    /// True if another actor moves a view of its own. Views that only watch this actor do not count.
    pub fn is_another_interacting(&self, actor_id: Option<&Arc<str>>, now: Instant) -> bool {
        let actors = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut others = actors.iter().filter(|(id, _)| Some(*id) != actor_id);
        others.any(|(_, views)| {
            let lately = |moving: &&MovingView| now.saturating_duration_since(moving.at) < MOVING_FOR;
            views.iter().filter(lately).any(|moving| moving.is_interactive)
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
        assert_eq!(account.record_picture(&ada, ViewSlot(1), true, large, start), PictureScale::FULL);
        for _ in 0..2 {
            for view in 1..=8 {
                account.record_picture(&ada, ViewSlot(view), true, large, start);
            }
        }
        let sizes = (1..=8).map(|view| account.record_picture(&ada, ViewSlot(view), true, large, start).size(large));
        let all: u64 = sizes.map(|[width, height]| u64::from(width) * u64::from(height)).sum();
        assert!((MAX_MOVING_PIXELS / 2..=MAX_MOVING_PIXELS).contains(&all), "{all}");
        assert!(!account.is_another_interacting(Some(&ada), start) && account.is_another_interacting(None, start));
        assert!(!account.is_another_interacting(None, start + MOVING_FOR));
        // Deliberate fault that the check must detect: a watching client counts as interacting.
        let watched = MovingPixels::default();
        watched.record_picture(&"ben".into(), ViewSlot(1), false, large, start);
        assert!(!watched.is_another_interacting(Some(&ada), start));
        // The pixels of each actor are counted separately, and views at rest do not count. Deliberate fault that the
        // check must detect: one count for all actors.
        assert_eq!(account.record_picture(&"ben".into(), ViewSlot(9), true, large, start), PictureScale::FULL);
        assert_ne!(account.record_picture(&ada, ViewSlot(9), true, large, start), PictureScale::FULL);
        let later = start + MOVING_VIEW_LIFETIME;
        assert_eq!(account.record_picture(&ada, ViewSlot(1), true, large, later), PictureScale::FULL);
        assert_eq!(account.0.lock().unwrap().len(), 1, "an actor at rest is removed");
    }
}
