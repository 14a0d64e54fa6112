//! Ids and point numberings.

use std::collections::BTreeMap;

use document::{Change, Command, Document, PointNumbering};
use glam::DVec3;
use light::LightId;
use light::parameters::RADIUS;

use crate::support::{BENDY, bendy, checked, content, done, edit, eye, insert, place, sample, set_point, take_back};

/// Rules: DOC-1
#[test]
fn an_id_is_never_used_again() {
    let mut document = sample();
    let added = done(&mut document, &Command::AddLight(checked(bendy())));
    take_back(&mut document, &added);
    done(&mut document, &Command::AddCamera(eye()));
    done(&mut document, &Command::AddLight(checked(bendy())));
    let lights: Vec<_> = document.lights().keys().map(|id| id.0).collect();
    let cameras: Vec<_> = document.cameras().keys().map(|id| id.0).collect();
    assert_eq!((lights, cameras), (vec![1, 2, 7], vec![3, 4, 6]), "5 was used once");
    assert_eq!(document.last_number(), 7);
}

/// Rules: DOC-1
#[test]
fn a_restored_document_counts_on() {
    let mut document = sample();
    done(&mut document, &Command::RemoveLight(LightId(2)));
    let restored =
        |last| Document::restore(None, document.lights().clone(), document.cameras().clone(), BTreeMap::new(), last);
    assert_eq!((restored(0).last_number(), restored(9).last_number()), (4, 9));
    assert_eq!((content(&restored(0)), restored(0).hash()), (content(&document), document.hash()));
    let mut later = restored(9);
    done(&mut later, &Command::AddLight(checked(bendy())));
    assert!(later.lights().contains_key(&LightId(10)));
}

/// Rules: DOC-2
#[test]
fn a_layout_changes_with_the_numbering_and_comes_back_with_it() {
    let mut document = sample();
    let layout = |document: &Document| document.lights()[&BENDY].layout;
    let first = layout(&document);
    done(&mut document, &set_point(1, RADIUS.to(0.3)));
    done(&mut document, &place(BENDY, DVec3::ONE));
    assert_eq!(layout(&document), first, "nothing was renumbered");

    let inserted = done(&mut document, &insert(2));
    let second = layout(&document);
    assert_ne!(second, first);
    take_back(&mut document, &inserted);
    assert_eq!(layout(&document), first);
    done(&mut document, &insert(2));
    let third = layout(&document);
    assert!(third != first && third != second, "another insertion, another numbering");
    done(&mut document, &Command::RemovePoint { light: BENDY, point: 2, ignore_pins: false });
    assert!(![first, second, third].contains(&layout(&document)), "not by its look the same");
}

/// A forged log could use the largest number. Counting on must not overflow.
///
/// Rules: DOC-1, REC-3
#[test]
fn numbers_past_what_json_keeps_are_refused() {
    let mut document = sample();
    let add = |number: u64| {
        let placed = document::NumberedLight { layout: PointNumbering(number), light: checked(bendy()) };
        Change::Light { light: LightId(number), old: None, new: Some(placed) }
    };
    let largest = (1 << 53) - 1;
    for number in [largest + 1, u64::MAX] {
        document.apply(&[add(number)]).expect_err("too large");
    }
    document.apply(&[add(largest)]).expect("the largest");
    edit(&document, &Command::AddCamera(eye())).expect_err("no number is left");
    let none_left =
        Document::restore(None, document.lights().clone(), document.cameras().clone(), BTreeMap::new(), u64::MAX);
    edit(&none_left, &Command::AddCamera(eye())).expect_err("no number is left");
}
