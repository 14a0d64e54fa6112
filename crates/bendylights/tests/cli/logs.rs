//! Tests of `sessions`, `export`, `import` and `replay` with the logs in tests/logs.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Cursor, Read, Write};

use document::AssetHash;
use image::GenericImageView;
use serde_json::{Value, json};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::program::{Folder, TRIANGLE, json_of, printed, refused, run};
use crate::serve::serve;

const LOG: &str = include_str!("../../../../tests/logs/format-1.jsonl");
const NEWEST_LOG: &str = include_str!("../../../../tests/logs/format-6.jsonl");
/// Hash of the document after the log's last record.
const HASH: &str = "1e2b7352aea306abf0967cf120f9030ced8ac4272d09995b46a7b002941708a7";

/// Returns a folder with the log as a file and as the session `main`.
fn imported() -> (Folder, String, String) {
    let folder = Folder::new();
    let (log, data) = (folder.file("log.jsonl", LOG), folder.path("data"));
    assert_eq!(printed(&["import", &log, "--data", &data]), "main: 43 records\n");
    (folder, log, data)
}

#[test]
fn a_log_goes_in_and_comes_out_as_it_was() {
    let (folder, log, data) = imported();
    let exported = |name: &str| {
        let out = folder.path("out.jsonl");
        assert_eq!(printed(&["export", name, "--data", &data, "-o", &out]), "");
        std::fs::read_to_string(&out).expect("a log")
    };
    let newest = folder.file("newest.jsonl", NEWEST_LOG);
    assert_eq!(printed(&["import", &newest, "--data", &data]), "old: 73 records\n");
    assert_eq!(exported("old"), NEWEST_LOG);
    // A log of an earlier format is exported in the current format.
    let upgraded = folder.file("upgraded.jsonl", exported("main"));
    assert!(exported("main").starts_with("{\"format\":6,"));
    let replayed = json_of(&["replay", &upgraded]);
    assert_eq!((&replayed["checkpoints_ok"], &replayed["hash"]), (&json!(true), &json!(HASH)));
    assert_eq!(printed(&["import", &log, "--data", &data, "--name", "b.2"]), "b.2: 43 records\n");
    refused(&["import", &log, "--data", &data], "", &["`main`", &log]);

    let table = printed(&["sessions", "--data", &data]);
    let lines: Vec<_> = table.lines().collect();
    assert_eq!(lines[0].split_whitespace().collect::<Vec<_>>(), ["session", "records", "document"]);
    assert_eq!(lines[1].split_whitespace().collect::<Vec<_>>(), ["b.2", "43", HASH]);
    assert_eq!(lines[2].split_whitespace().collect::<Vec<_>>(), ["main", "43", HASH]);
    let rows = json_of(&["sessions", "--data", &data, "--json"]);
    assert_eq!((&rows[1]["name"], &rows[1]["seq"], &rows[1]["hash"]), (&json!("main"), &json!(43), &json!(HASH)));
    assert_ne!(rows[0]["epoch"], rows[1]["epoch"], "two histories");
    // The list has the data of the page's list: titles, and archived sessions if requested.
    let mut store = store::Store::open(std::path::Path::new(&data)).expect("a store");
    let change = store::SessionChange { title: Some("Shot 10".into()), archived: Some(true) };
    store.change_session("b.2", &change).expect("archived");
    drop(store);
    assert!(!printed(&["sessions", "--data", &data]).contains("b.2"), "it is left out");
    let table = printed(&["sessions", "--data", &data, "--archived"]);
    assert!(table.lines().nth(1).is_some_and(|line| line.ends_with("  Shot 10")), "{table}");
    let rows = json_of(&["sessions", "--data", &data, "--archived", "--json"]);
    let said = |row: usize| [&rows[row]["title"], &rows[row]["archived"]].map(Clone::clone);
    assert_eq!([said(0), said(1)], [[json!("Shot 10"), json!(true)], [json!("main"), json!(false)]]);
    assert!(rows[0]["madeMs"].is_u64() && rows[0]["changedMs"].is_u64(), "{rows}");
    let names = ["data", "log.jsonl", "newest.jsonl", "out.jsonl", "upgraded.jsonl"];
    assert_eq!(folder.names(), names, "and nothing else");
}

#[test]
fn replay_prints_what_it_came_to() {
    let folder = Folder::new();
    let log = folder.file("log.jsonl", LOG);
    let replayed = |to: &[&str]| json_of(&[&["replay", &log], to].concat());
    let whole = replayed(&[]);
    let keys: Vec<_> = whole.as_object().expect("an object").keys().collect();
    assert_eq!(keys, ["checkpoints_ok", "hash", "records", "seconds"], "these and no others");
    assert_eq!((&whole["records"], &whole["hash"]), (&json!(43), &json!(HASH)));
    assert_eq!(whole["checkpoints_ok"], json!(true));
    assert!(whole["seconds"].is_f64());
    let part = replayed(&["--to", "36"]);
    assert_eq!(part["records"], json!(36));
    assert_ne!(part["hash"], whole["hash"]);
    refused(&["replay", &log, "--to", "44"], "", &["record 43", "record 44"]);
}

#[test]
fn a_checkpoint_that_differs_is_reported() {
    let folder = Folder::new();
    let planted = LOG.replace(r#""seq":24,"hash":""#, r#""seq":24,"hash":"0"#);
    let log = folder.file("log.jsonl", planted);
    let done = refused(&["replay", &log], "", &["record 24 ", &log]);
    let result: Value = serde_json::from_str(&done.stdout).expect("JSON");
    assert_eq!((&result["checkpoints_ok"], &result["hash"]), (&json!(false), &json!(HASH)));
    refused(&["import", &log, "--data", &folder.path("data")], "", &["record 24 "]);
    assert_eq!(folder.names(), ["log.jsonl"], "a refused log makes no folder");
}

/// Returns the log with another asset in place of the demo scene. Its checkpoints then differ, the first after
/// record 12.
fn log_of(scene: &str) -> String {
    let demo = AssetHash::of(&assets::demo_bytes("vases").expect("the demo scene")).to_string();
    assert!(LOG.contains(&demo));
    LOG.replace(&demo, &AssetHash::of(scene.as_bytes()).to_string())
}

#[test]
fn a_missing_scene_is_named_with_the_way_out() {
    let (folder, _, data) = imported();
    let log = folder.file("triangle.jsonl", log_of(TRIANGLE));
    let asset = AssetHash::of(TRIANGLE.as_bytes());
    let picture = folder.path("out.png");
    for args in [
        &["replay", &log, "--to", "11", "--render", &picture][..],
        &["replay", &log, "--to", "11", "--render", &picture, "--data", &data],
        &["import", &log, "--data", &data, "--name", "other"],
    ] {
        refused(args, "", &["record 1", &asset.to_string(), "--data", &format!("assets/{}", asset.hex())]);
    }
    std::fs::write(format!("{data}/assets/{}", asset.hex()), TRIANGLE).expect("a file");
    let render = ["replay", &log, "--data", &data, "--to", "11", "--render", &picture];
    printed(&render);
    // Edits need no geometry.
    printed(&["replay", &log, "--to", "11"]);

    std::fs::write(format!("{data}/assets/{}", asset.hex()), "another").expect("a file");
    let damaged = run(&render);
    assert_eq!(damaged.code, 2);
    assert!(damaged.stderr.starts_with("note: ") && damaged.stderr.contains("damaged"), "{}", damaged.stderr);
}

#[test]
fn replay_draws_the_document() {
    let folder = Folder::new();
    let log = folder.file("log.jsonl", LOG);
    let drawn = |to: &str| {
        let picture = folder.path("out.png");
        printed(&["replay", &log, "--to", to, "--render", &picture]);
        image::open(picture).expect("a picture").into_rgb8()
    };
    let (first, last) = (drawn("1"), drawn("43"));
    assert_eq!(first.dimensions(), (640, 360));
    assert_ne!(first, last, "the edits show");
    assert_ne!(first.view(0, 0, 640, 180).to_image(), first.view(0, 180, 640, 180).to_image(), "it shows something");
    let done = refused(&["replay", &log, "--render", &folder.path("out.jpg")], "", &[".png"]);
    assert_eq!(done.stdout, "", "before the work is done");
}

#[test]
fn wrong_input_is_refused_and_leaves_nothing() {
    let (folder, log, data) = imported();
    let nowhere = folder.path("nowhere");
    let out = folder.path("out.jsonl");
    let cut = folder.file("cut.jsonl", &LOG[..LOG.len() - 120]);
    let gap = folder.file("gap.jsonl", LOG.replacen("\"seq\":7,", "\"seq\":8,", 1));
    let empty = folder.file("empty.jsonl", "");
    for (args, words) in [
        (&["sessions", "--data", &nowhere][..], &*nowhere),
        (&["export", "main", "--data", &nowhere, "-o", &out], &nowhere),
        (&["export", "other", "--data", &data, "-o", &out], "`other`"),
        (&["export", "main", "--data", &data, "-o", &folder.path("no/out.jsonl")], "no/out.jsonl"),
        (&["export", "main", "--data", &data, "-o", &data], &data),
        (&["import", &nowhere, "--data", &data], &nowhere),
        (&["import", &data, "--data", &data], &data),
        (&["import", &cut, "--data", &data, "--name", "x"], "cut.jsonl"),
        (&["import", &gap, "--data", &data, "--name", "x"], "record 8 follows record 6"),
        (&["import", &empty, "--data", &data, "--name", "x"], "empty.jsonl"),
        (&["import", &log, "--data", &data, "--name", "a b"], "`a b`"),
        (&["replay", &log, "--data", &nowhere], &nowhere),
        (&["replay", &gap], "record 8 follows record 6"),
    ] {
        assert_eq!(refused(args, "", &[words]).stdout, "", "{args:?}");
    }
    assert_eq!(folder.names(), ["cut.jsonl", "data", "empty.jsonl", "gap.jsonl", "log.jsonl"]);
    assert_eq!(printed(&["sessions", "--data", &data]).lines().count(), 2, "`main` alone");
}

/// Returns the files of a bundle by name.
fn unzipped(bundle: &str) -> BTreeMap<String, Vec<u8>> {
    let mut zip = ZipArchive::new(File::open(bundle).expect("a file")).expect("a .zip");
    let mut files = BTreeMap::new();
    for index in 0..zip.len() {
        let mut file = zip.by_index(index).expect("a file");
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).expect("whole");
        files.insert(file.name().expect("a name").into_owned(), bytes);
    }
    files
}

fn zipped(files: &BTreeMap<String, Vec<u8>>) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name.as_str(), SimpleFileOptions::default()).expect("to memory");
        zip.write_all(bytes).expect("to memory");
    }
    zip.finish().expect("to memory").into_inner()
}

#[test]
fn a_bundle_takes_its_scenes_along() {
    let folder = Folder::new();
    let scene = folder.file("room.gltf", TRIANGLE);
    let [data, other, log, bundle] = ["data", "other", "main.jsonl", "main.zip"].map(|name| folder.path(name));
    drop(serve(&["--data", &data, "--scene", &scene]));
    for output in [&log, &bundle] {
        printed(&["export", "main", "--data", &data, "-o", output]);
    }
    let exported = std::fs::read(&log).expect("a log");
    let hex = AssetHash::of(TRIANGLE.as_bytes()).hex();
    let (file, name) = (format!("assets/{hex}"), format!("assets/{hex}.name"));
    let expected = BTreeMap::from([
        ("log.jsonl".into(), exported.clone()),
        (file.clone(), TRIANGLE.into()),
        (name.clone(), b"room.gltf".to_vec()),
    ]);
    assert_eq!(unzipped(&bundle), expected);
    // The log alone lacks the scene.
    refused(&["import", &log, "--data", &other], "", &[&hex]);

    // A damaged or incomplete bundle is refused and leaves nothing.
    let changed = |name: &str, bytes: Option<&[u8]>| {
        let mut files = expected.clone();
        files.remove(name);
        files.extend(bytes.map(|bytes| (name.to_owned(), bytes.to_vec())));
        files
    };
    let planted = [
        (changed(&file, None), hex.as_str()),
        (changed("log.jsonl", None), "damaged.zip"),
        (changed(&file, Some(b"another")), "damaged"),
    ];
    for (files, word) in planted {
        let damaged = folder.file("damaged.zip", zipped(&files));
        refused(&["import", &damaged, "--data", &other], "", &[word, &damaged]);
        assert!(!std::fs::exists(&other).expect("a folder"), "{word}");
    }

    assert_eq!(printed(&["import", &bundle, "--data", &other]), "main: 1 records\n");
    assert_eq!(printed(&["import", &bundle, "--data", &other, "--name", "twice"]), "twice: 1 records\n");
    let again = folder.path("again.jsonl");
    printed(&["export", "main", "--data", &other, "-o", &again]);
    assert_eq!(std::fs::read(&again).expect("a log"), exported);
    assert_eq!(std::fs::read(format!("{other}/{name}")).expect("a name"), b"room.gltf");
}

#[test]
fn replay_draws_the_picture_that_is_asked_for() {
    let (folder, log, data) = imported();
    let picture = folder.path("out.png");
    let replay = ["replay", &log, "--data", &data, "--render", &picture];
    let draw = |more: &[&str]| {
        printed(&[&replay[..], more].concat());
        image::open(&picture).expect("a picture").into_rgb8()
    };
    let depth = draw(&["--size", "64x40", "--aov", "depth"]);
    assert_eq!(depth.dimensions(), (64, 40));
    let beauty = draw(&["--size", "64x40"]);
    assert_ne!(depth, beauty);
    assert_ne!(draw(&["--size", "64x40", "--samples", "16"]), beauty, "edges are smooth");
    assert_ne!(draw(&["--size", "64x40", "--exposure", "2"]), beauty);
    refused(&[&replay[..], &["--camera", "nobody"]].concat(), "", &["`nobody`", "choose one of"]);
    refused(&["replay", &log, "--size", "64x40"], "", &["--render"]);
}
