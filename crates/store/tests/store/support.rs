//! Temporary folders, and logs to store there.

use std::path::PathBuf;
use std::sync::Arc;

use document::{AssetHash, Command, CommandContext, Document, DocumentHash, SceneContents, was_in_format_2};
use edit::{Actor, EditRequest, EditSources, Record, Session, UndoScope};
use glam::DVec3;
use light::parameters::{NAME, POINT_INTENSITY, TRANSLATION};
use light::{CheckedLight, Light, LightId, ParameterOwner};
use rusqlite::Connection;
use serde_json::Value;
use store::{CommitBatch, Store};
use tempfile::TempDir;

/// A scene for which [`is_here`] is true. It is empty.
pub const SCENE: AssetHash = AssetHash([7; 32]);

pub fn is_here(asset: &AssetHash) -> bool {
    *asset == SCENE
}

pub const DATABASE: &str = "bendylights.sqlite";

/// A folder for the data of one test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(TempDir::new().expect("a temporary folder"))
    }

    /// Returns the data folder, which may be missing.
    pub fn data(&self) -> PathBuf {
        self.0.path().join("data")
    }

    pub fn store(&self) -> Store {
        Store::create(&self.data()).expect("a store")
    }

    /// Returns a store with the empty session `main`.
    pub fn store_of_main(&self) -> Store {
        let mut store = self.store();
        store.create_session("main").expect("a new name");
        store
    }

    pub fn database(&self) -> Connection {
        Connection::open(self.data().join(DATABASE)).expect("a database")
    }

    /// Plants a fault in the database.
    pub fn plant(&self, fault: &str) {
        self.database().execute_batch(fault).expect(fault);
    }
}

fn bent_light() -> Light {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.5, 0.0, -2.0)];
    Light::bendy(points, vec![0.1, 0.4, 0.8]).with(NAME, "key".into())
}

fn checked(light: Light) -> Arc<CheckedLight> {
    Arc::new(CheckedLight::new(light).expect("a valid light"))
}

/// A log in the making: its records, and the session after them.
#[derive(Default)]
pub struct Log {
    pub session: Session,
    pub records: Vec<Record>,
}

impl Log {
    /// Makes a scene, a light, and `edits` more steps on it. Every seventh step is an undo.
    pub fn of(edits: u64) -> Self {
        let mut log = Self::default();
        log.edit(Command::LoadScene { asset: SCENE, name: "empty".into() });
        log.edit(Command::AddLight(checked(bent_light())));
        let light = LightId(1);
        for step in 0..edits {
            let value = step as f64;
            match step % 7 {
                3 => {
                    let setting = POINT_INTENSITY.to(value + 1.5);
                    log.edit(Command::SetPoint { light, point: 1, setting, ignore_pins: false });
                }
                6 => log.undo(),
                _ => {
                    let setting = TRANSLATION.to(DVec3::splat(value));
                    log.edit(Command::SetLight { light, setting, ignore_pins: false });
                }
            }
        }
        log
    }

    pub fn edit(&mut self, command: Command) {
        self.take(EditRequest::Edit { base_seq: None, command });
    }

    pub fn undo(&mut self) {
        self.take(EditRequest::Undo(UndoScope::Mine));
    }

    /// Adds a light of 64 control points, different in each call.
    pub fn add_long_light(&mut self) {
        let seq = self.session.seq() as f64;
        let points = (0..64).map(|i| DVec3::new(0.0, 0.0, -0.1 * f64::from(i))).collect();
        let light = Light::bendy(points, vec![0.01 + 1e-5 * seq; 64]);
        self.edit(Command::AddLight(checked(light.with(NAME, "long".into()))));
    }

    fn take(&mut self, request: EditRequest) {
        let actor = Actor { id: "a".into(), name: "Ada".into() };
        let op_id = format!("op {}", self.session.seq() + 1);
        let record = |seq: u64| self.records.get(seq as usize - 1).cloned();
        let reverted = self.session.find_revert(&request, &actor.id, &record);
        let contents = SceneContents::default();
        let context = CommandContext { loaded: Some(&contents), ..CommandContext::default() };
        let sources = EditSources { context, reverted: reverted.expect("something to revert") };
        let record = self.session.execute_request(request, &actor, &op_id, 1_790_000_000_000, sources);
        self.records.push(record.expect("a valid request"));
    }

    /// Returns all records as one batch of `session`.
    pub fn batch<'a>(&'a self, session: &'a str) -> CommitBatch<'a> {
        CommitBatch { session, records: &self.records, rejections: &[], hash: self.hash() }
    }

    pub fn hash(&self) -> DocumentHash {
        self.session.document().hash()
    }

    pub fn hash_after(&self, seq: u64) -> DocumentHash {
        self.document_after(seq).hash()
    }

    pub fn document_after(&self, seq: u64) -> Document {
        let mut session = Session::default();
        for record in self.records.iter().filter(|record| record.seq <= seq) {
            session.replay(record).expect("it goes on");
        }
        session.document().clone()
    }
}

/// Returns a record as format 1 wrote it, in full: without the properties that lights got later.
pub fn of_format_1(record: &Record) -> String {
    fn strip(value: &mut Value) {
        if let Value::Object(fields) = value {
            let owner = match fields.get("type").and_then(Value::as_str) {
                Some("spot") => Some(ParameterOwner::Spot),
                Some("bendy") => Some(ParameterOwner::Bendy),
                _ => None,
            };
            let groups = ["type", "transform", "points", "radii", "colors", "intensities"];
            let had = |name: &str| owner.is_none_or(|owner| was_in_format_2(owner, name));
            fields.retain(|name, _| groups.contains(&name.as_str()) || had(name));
            fields.values_mut().for_each(strip);
        } else if let Value::Array(items) = value {
            items.iter_mut().for_each(strip);
        }
    }
    let mut json = serde_json::to_value(protocol::Record { format: 1, ..record.into() }).expect("plain data");
    strip(&mut json);
    json.to_string()
}

pub fn empty_hash() -> String {
    Document::default().hash().to_string()
}

/// Returns the log of a session as a file.
pub fn exported(store: &Store, session: &str) -> String {
    let mut text = Vec::new();
    store.export(session, &mut text).expect("a log");
    String::from_utf8(text).expect("JSON")
}

/// Stores the log of [`Log::of`] as a session `name`, in batches of ten records.
pub fn stored_log(store: &mut Store, name: &str, edits: u64) -> Log {
    let log = Log::of(edits);
    store.create_session(name).expect("a new name");
    let mut replayed = Session::default();
    for records in log.records.chunks(10) {
        for record in records {
            replayed.replay(record).expect("it goes on");
        }
        let hash = replayed.document().hash();
        store.append(&[CommitBatch { session: name, records, rejections: &[], hash }]).expect("a commit");
    }
    log
}
