//! Dragged control points slide along the fold limit.

use document::{Change, Command, Document, EditError, describe_changes};
use glam::DVec3;
use light::parameters::{POSITION, RADIUS};
use light::{ControlPoint, LightError};

use crate::support::{BENDY, SPOT, content, done, light_of, refused, sample, set_point, take_back};

/// Position that control point 3 of the sample's light cannot have.
const PAST_THE_WALL: DVec3 = DVec3::new(-3.0, 0.0, -1.0);

fn drag(point: usize, position: DVec3, radii_follow: bool) -> Command {
    Command::DragPoint { light: BENDY, point, position, radii_follow, ignore_pins: false }
}

fn points(document: &Document) -> Vec<ControlPoint> {
    light_of(document, BENDY).points().to_vec()
}

/// Returns the largest `R kappa`. At 1 the tube folds.
fn fold(document: &Document) -> f64 {
    let segments = document.lights()[&BENDY].light.tube().expect("a BendyLight").r_kappa_max();
    segments.into_iter().fold(0.0, f64::max)
}

/// Rules: CMD-14
#[test]
fn a_dragged_point_is_where_it_is_put_if_it_can_be() {
    let (mut dragged, mut set) = (sample(), sample());
    let position = DVec3::new(0.1, 0.2, -2.1);
    let by_setting = done(&mut set, &set_point(2, POSITION.to(position)));
    let by_dragging = done(&mut dragged, &drag(2, position, false));
    assert_eq!(by_dragging, by_setting);
    assert_eq!(describe_changes(&by_dragging, &dragged), "the position of control point 2 of “key”");
    assert_eq!(done(&mut dragged, &drag(2, position, false)), [], "it is there already");
}

/// Setting that position is refused: it lies past the fold limit.
///
/// Rules: CMD-14, CMD-2, REC-2
#[test]
fn a_dragged_point_slides_along_the_fold_limit() {
    let mut document = sample();
    let (hash, content_before, before) = (document.hash(), content(&document), points(&document));
    let set = refused(&document, &set_point(3, POSITION.to(PAST_THE_WALL)));
    assert!(matches!(set, EditError::InvalidLight { reason: LightError::Fold { .. }, .. }));
    let changes = done(&mut document, &drag(3, PAST_THE_WALL, false));
    let [Change::Point { point: 3, parameter, .. }] = &changes[..] else { panic!("{changes:?}") };
    assert_eq!(*parameter, POSITION.row());
    let after = points(&document);
    let [was, is] = [&before, &after].map(|points| points[3].position.distance(PAST_THE_WALL));
    assert!(is < was && is > 0.0, "as near as it can: {is} after {was}");
    assert!(fold(&document) < 1.0);
    take_back(&mut document, &changes);
    assert_eq!((document.hash(), content(&document)), (hash, content_before), "to the last bit");
}

/// Rules: CMD-14, REC-2
#[test]
fn radii_follow_and_come_back() {
    let mut document = sample();
    let (hash, before) = (document.hash(), points(&document));
    let changes = done(&mut document, &drag(3, PAST_THE_WALL, true));
    let after = points(&document);
    assert_eq!(after[3].position, PAST_THE_WALL, "nothing is in the way");
    assert!(after.iter().zip(&before).all(|(now, was)| now.radius <= was.radius));
    assert!(after[3].radius < before[3].radius && fold(&document) < 1.0);
    let said = describe_changes(&changes, &document);
    assert!(said.starts_with("the position of control point 3 of “key” and "), "{said}");
    // A drag is computed from its start, so a drag back restores the points.
    let mut back = sample();
    done(&mut back, &drag(3, before[3].position, true));
    assert_eq!(points(&back), before);
    take_back(&mut document, &changes);
    assert_eq!(document.hash(), hash);
}

/// Rules: CMD-14, CMD-3, CMD-5, CMD-9
#[test]
fn drags_are_refused_like_settings() {
    let mut document = sample();
    for radii_follow in [false, true] {
        for (point, position) in
            [(0, DVec3::X), (5, DVec3::X), (2, DVec3::new(f64::NAN, 0.0, 0.0)), (2, DVec3::splat(f64::INFINITY))]
        {
            let set = refused(&document, &set_point(point, POSITION.to(position)));
            let dragged = refused(&document, &drag(point, position, radii_follow));
            assert_eq!(dragged.to_string(), set.to_string(), "{point}, {position}");
        }
        let of_spot =
            Command::DragPoint { light: SPOT, point: 1, position: DVec3::X, radii_follow, ignore_pins: false };
        assert!(matches!(refused(&document, &of_spot), EditError::WrongKind { kind: "spotlight", .. }));
    }
    done(&mut document, &Command::RemoveLight(BENDY));
    assert_eq!(refused(&document, &drag(2, DVec3::X, false)), EditError::NoLight(BENDY));
}

/// Only radii that fold shrink. A thin light keeps its radii.
///
/// Rules: CMD-14
#[test]
fn radii_that_fold_nothing_stay() {
    let mut document = sample();
    for point in 0..5 {
        done(&mut document, &set_point(point, RADIUS.to(0.001)));
    }
    let before = points(&document);
    let changes = done(&mut document, &drag(2, DVec3::new(0.5, 0.0, -2.0), true));
    assert_eq!(changes.len(), 1, "{changes:?}");
    assert!(points(&document).iter().zip(&before).all(|(now, was)| now.radius == was.radius));
}

/// Radii of a light near a fold stay if the light is straightened, whatever it was when the drag began.
///
/// Rules: CMD-14
#[test]
fn radii_stay_where_the_bend_opens() {
    let mut document = sample();
    done(&mut document, &drag(3, PAST_THE_WALL, false));
    let (before, tight) = (points(&document), fold(&document));
    assert!(tight > 0.9, "it is at the wall: {tight}");
    let changes = done(&mut document, &drag(3, before[3].position + DVec3::X, true));
    assert!(fold(&document) < 0.5, "the bend is open: {}", fold(&document));
    assert_eq!(changes.len(), 1, "{changes:?}");
}
