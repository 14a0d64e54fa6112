//! Tests a log of many drags of features: on any machine, on one thread or several, it is the same to the last bit, and
//! replay gives the same document.

use std::sync::Arc;
use std::thread;

use document::{AssetHash, Command, CommandContext, CommandSolution, Document, solve_drag};
use drag::{Drag, Feature, RadiusMode, Viewport};
use edit::{Actor, EditRequest, EditSources, Session, UndoScope};
use glam::DVec2;
use light::LightId;
use raycast::Bvh;

const DRAGS: usize = 500;

/// SHA-256 of the log's lines, by optimized and unoptimized builds, with version 9 of the solver. If results of the
/// solver change, this hash changes too, and `drag::SOLVER` gets a new version.
const HASH: &str = "2fdddb94f1805e6e0af26c8b0002098d08ad4c01a841c7951c66eb44c26373e9";

const SIZE: [u32; 2] = [320, 180];

/// [xorshift64*](https://en.wikipedia.org/wiki/Xorshift) generator of numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.share() * count as f64) as usize
    }
}

/// The demo with its first light.
fn demo() -> (Bvh, Viewport, Document) {
    let demo = assets::demo("vases").expect("it is one of the demos");
    let view = Viewport { camera: demo.contents.cameras[0].clone(), size: SIZE };
    let mut document = Document::default();
    let light = Command::AddLight(Arc::clone(&demo.contents.lights[0]));
    let added = document::execute_command(&document, &light, CommandContext::default()).expect("a light is added");
    document.apply(&added.changes).expect("it is new");
    (Bvh::new(scene::pose(demo.scene, 0.0)), view, document)
}

/// A drag of a random feature between random pixels, of the whole light or of some control points.
fn any_drag(random: &mut Random, view: &Viewport) -> Drag {
    let features = [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse];
    let radii = [RadiusMode::Keep, RadiusMode::Solve, RadiusMode::Follow];
    let subsets = [None, Some(vec![4]), Some(vec![2, 3]), Some(vec![1, 2, 3, 4])];
    let from = DVec2::new(random.share() * f64::from(SIZE[0]), random.share() * f64::from(SIZE[1]));
    let offset = DVec2::new(random.share() - 0.5, random.share() - 0.5) * 20.0;
    Drag {
        feature: features[random.below(4)],
        points: subsets[random.below(4)].clone(),
        radii: radii[random.below(3)],
        view: view.clone(),
        from,
        to: from + offset,
        pins: None,
        choice: None,
        source_outside: false,
    }
}

/// The log with one record per line, and the session that made it. It keeps every 200th drag and undoes the others.
fn made() -> (Vec<String>, Session) {
    let (bvh, view, document) = demo();
    let mut session = Session::restore(document, 0, &edit::SessionHistory::default());
    let (mut random, mut lines, mut drags) = (Random(20), Vec::new(), 0);
    let ada = Actor { id: "ada".into(), name: "Ada".into() };
    let light = LightId(1);
    let mut tried = 0;
    while drags < DRAGS {
        tried += 1;
        assert!(tried < 20 * DRAGS, "{drags} of {tried} are carried out");
        let drag = any_drag(&mut random, &view);
        let solved = solve_drag(session.document(), light, &drag, &bvh).expect("a picture and a light");
        let context =
            CommandContext { solved: Some(&CommandSolution::Drag(Box::new(solved))), ..CommandContext::default() };
        let command = Command::DragFeature { light, drag: Box::new(drag) };
        let request = EditRequest::Edit { base_seq: None, command };
        let sources = EditSources { context, reverted: None };
        let Ok(record) = session.execute_request(request, &ada, &format!("drag-{drags}"), 0, sources) else {
            continue;
        };
        drags += 1;
        lines.push(protocol::Record::from(&record).to_json());
        if drags % 200 > 0 && !record.changes.is_empty() {
            let undo = EditRequest::Undo(UndoScope::Mine);
            let taken_back = session.find_revert(&undo, &ada.id, &|_| Some(record.clone())).expect("it can be");
            let sources = EditSources { reverted: taken_back, ..EditSources::default() };
            let undone = session.execute_request(undo, &ada, &format!("undo-{drags}"), 0, sources).expect("it can be");
            lines.push(protocol::Record::from(&undone).to_json());
        }
    }
    (lines, session)
}

/// Rules: CMD-15, REC-2, REC-7, DRAG-2
#[test]
fn a_log_of_many_drags_is_the_same_everywhere() {
    let (lines, session) = made();
    let hash = AssetHash::of(lines.concat().as_bytes()).hex();
    let beside: Vec<_> = (0..3).map(|_| thread::spawn(made)).collect();
    for other in beside {
        let (other, _) = other.join().expect("it ends");
        assert!(other == lines, "made beside others it is another log");
    }

    let (_, _, document) = demo();
    let mut replayed = Session::restore(document.clone(), 0, &edit::SessionHistory::default());
    for line in &lines {
        let record = protocol::Record::parse(line).expect("a record");
        replayed.replay(&edit::Record::try_from(record).expect("a record")).expect("it goes on");
    }
    assert_eq!(replayed.document().hash(), session.document().hash());
    assert_ne!(replayed.document().hash(), document.hash(), "the planted fault: a log that does nothing");
    assert_eq!(hash, HASH, "the solver gives other lights: raise `drag::SOLVER`'s version, and note the hash");
}
