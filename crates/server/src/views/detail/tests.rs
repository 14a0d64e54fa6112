//! Simulated drags with random loads against the choice of detail.

use proptest::prelude::*;

use super::*;

const MS: fn(u64) -> Duration = Duration::from_millis;

/// Time of a view's pictures at each detail.
#[derive(Clone, Copy, Debug)]
struct Load {
    /// Milliseconds: a constant part, a part for the texels of maps, and a part for pixels.
    parts: [f64; 3],
    /// Greatest relative deviation of single pictures.
    noise: f64,
    drew_map: bool,
}

impl Load {
    fn at(&self, detail: Detail, chance: f64) -> Duration {
        let [stays, maps, pixels] = self.parts;
        let maps = if self.drew_map { maps * detail.texel_ratio() } else { 0.0 };
        let ms = stays + maps + pixels * detail.pixel_ratio();
        Duration::from_secs_f64(ms * (1.0 + self.noise * (2.0 * chance - 1.0)) / 1000.0)
    }
}

/// Times of changes, and the new detail.
type Changes = Vec<(Instant, Detail)>;

/// Simulates a drag of that length under a load. The next picture is requested when the last is there, or at the next
/// repaint.
fn drag(choice: &mut DetailChoice, load: Load, from: Instant, seconds: u64, seed: u64) -> Changes {
    let (mut now, mut changes, mut state) = (from, Changes::new(), seed | 1);
    while now < from + Duration::from_secs(seconds) {
        // The random numbers need not be good, only the same each time.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let detail = choice.detail();
        let took = load.at(detail, (state >> 11) as f64 / (1_u64 << 53) as f64);
        now += took.max(MS(16));
        choice.record_picture(TimedPicture { detail, took, drew_map: load.drew_map }, now);
        if choice.detail() != detail {
            changes.push((now, choice.detail()));
        }
    }
    changes
}

fn interactions() -> impl Strategy<Value = Interaction> {
    let reduction = || prop_oneof![Just(Reduction::Auto), Just(Reduction::Full)];
    (reduction(), reduction()).prop_map(|(shadow_map, resolution)| Interaction { shadow_map, resolution })
}

fn loads() -> impl Strategy<Value = Load> {
    let parts = [0.1..60.0, 0.1..120.0, 0.1..120.0];
    (parts, 0.0..0.05, any::<bool>()).prop_map(|(parts, noise, drew_map)| Load { parts, noise, drew_map })
}

/// Finds a fault in the changes of a drag.
fn wrong(interaction: Interaction, changes: &Changes) -> Option<String> {
    let too_soon = changes.windows(2).find(|pair| pair[1].0 - pair[0].0 < MIN_CHANGE_INTERVAL);
    let forbidden = changes.iter().find(|(_, detail)| !detail.is_allowed_by(interaction));
    too_soon.map(|pair| format!("too soon: {pair:?}")).or(forbidden.map(|f| format!("forbidden: {f:?}")))
}

proptest! {
    /// Under any change of the load: no two changes within a second, and no forbidden reduction.
    #[test]
    fn changes_are_rare_and_keep_to_what_is_allowed(
        interaction in interactions(),
        phases in proptest::collection::vec((loads(), 1_u64..6, 0_u64..3), 1..6),
        seed in any::<u64>(),
    ) {
        let mut choice = DetailChoice::new(interaction);
        let (mut now, mut changes) = (Instant::now(), Changes::new());
        for (load, seconds, rest) in phases {
            changes.extend(drag(&mut choice, load, now, seconds, seed));
            now += Duration::from_secs(seconds + rest);
        }
        prop_assert_eq!(wrong(interaction, &changes), None);
    }

    /// Under a steady load the detail settles within as many seconds as there are details. Then pictures are fast
    /// enough, or no allowed and useful detail would be faster by more than the noise.
    #[test]
    fn a_steady_load_comes_to_rest(interaction in interactions(), load in loads(), seed in any::<u64>()) {
        // A median is off by at most the noise, and a ratio of two medians by twice that. Closer to a limit than that,
        // chance decides on which side of it a picture is.
        let near = |took: Duration, limit: Duration| {
            took.as_secs_f64() * (1.0 - 3.0 * load.noise) < limit.as_secs_f64()
                && limit.as_secs_f64() < took.as_secs_f64() * (1.0 + 3.0 * load.noise)
        };
        for detail in Detail::ALL.into_iter().filter(|detail| detail.is_allowed_by(interaction)) {
            let took = load.at(detail, 0.5);
            prop_assume!(!near(took, TARGET_TIME) && !near(took, TARGET_TIME.mul_f64(HEADROOM)));
        }
        let (mut choice, start) = (DetailChoice::new(interaction), Instant::now());
        let settle = Detail::ALL.len() as u64 + 4;
        drag(&mut choice, load, start, settle, seed);
        let changes = drag(&mut choice, load, start + Duration::from_secs(settle), 30, !seed);
        prop_assert_eq!(&changes, &Changes::new());
        let (rests_at, typical) = (choice.detail(), |detail| load.at(detail, 0.5));
        let slow = typical(rests_at) > TARGET_TIME.mul_f64(1.0 + load.noise);
        let quickest = Detail::ALL.into_iter().filter(|d| d.is_allowed_by(interaction)).map(typical).min();
        let quickest = quickest.unwrap_or_default().mul_f64(1.0 + 3.0 * load.noise);
        prop_assert!(!slow || typical(rests_at) <= quickest, "{rests_at:?}");
    }

    /// A load that is light enough in full stays in full.
    #[test]
    fn a_light_load_stays_full(interaction in interactions(), load in loads(), seed in any::<u64>()) {
        let most: f64 = load.parts.iter().sum::<f64>() * (1.0 + load.noise);
        let parts = load.parts.map(|part| part * 32.0 / most.max(32.0));
        let load = Load { parts, ..load };
        let mut choice = DetailChoice::new(interaction);
        prop_assert_eq!(drag(&mut choice, load, Instant::now(), 20, seed), Changes::new());
    }
}

/// After a load ends, the detail becomes full again. A new load is answered within a second, the least time between
/// changes.
#[test]
fn it_follows_the_load_down_and_up() {
    let all = Interaction { shadow_map: Reduction::Auto, resolution: Reduction::Auto };
    let (mut choice, start) = (DetailChoice::new(all), Instant::now());
    let heavy = Load { parts: [10.0, 40.0, 70.0], noise: 0.05, drew_map: true };
    let light = Load { parts: [2.0, 4.0, 7.0], ..heavy };
    let changes = drag(&mut choice, heavy, start, 10, 1);
    assert_eq!(choice.detail(), Detail::ALL[5]);
    assert!(changes[0].0 - start < Duration::from_secs(1), "three pictures are enough");
    drag(&mut choice, light, start + Duration::from_secs(10), 10, 2);
    assert_eq!(choice.detail(), Detail::FULL);
    // A moving camera draws no map, so coarser maps gain nothing.
    let orbit = Load { parts: [5.0, 0.0, 60.0], drew_map: false, ..heavy };
    let mut choice = DetailChoice::new(all);
    let changes = drag(&mut choice, orbit, start, 10, 3);
    assert!(!changes.is_empty());
    assert!(changes.iter().all(|(_, detail)| detail.shadow_map == MapScale::Full), "{changes:?}");
}

/// Deliberate faults that the check must detect: a change with each picture, and a forbidden reduction.
#[test]
fn faults_are_seen() {
    let (now, none) = (Instant::now(), Interaction { shadow_map: Reduction::Full, resolution: Reduction::Full });
    let hasty: Changes = (0..4).map(|k| (now + MS(300 * k), Detail::FULL)).collect();
    assert!(wrong(none, &hasty).is_some());
    assert!(wrong(none, &vec![(now, Detail::ALL[2])]).is_some());
    assert!(wrong(none, &vec![(now, Detail::FULL), (now + MIN_CHANGE_INTERVAL, Detail::FULL)]).is_none());
}

#[test]
fn pictures_have_their_share_of_the_sides_and_at_least_a_pixel() {
    assert_eq!(Resolution::Full.of([686, 382]), [686, 382]);
    assert_eq!(Resolution::ThreeQuarters.of([686, 382]), [515, 287]);
    assert_eq!(Resolution::Half.of([686, 382]), [343, 191]);
    assert_eq!(Resolution::Half.of([1, 1]), [1, 1]);
}
