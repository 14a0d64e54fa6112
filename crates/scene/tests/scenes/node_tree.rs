//! Paths of nodes, and the nodes that links select.

use glam::DAffine3;
use light::Links;
use scene::{Node, NodeTree, Scene};

/// Makes nodes from names and parents. All have a mesh except those named `empty`.
fn tree(nodes: &[(&str, Option<usize>)]) -> NodeTree {
    let node = |&(name, parent): &(&str, Option<usize>)| Node {
        name: name.into(),
        parent,
        parent_from_local: DAffine3::IDENTITY,
        mesh: (name != "empty").then_some(0),
    };
    NodeTree::new(&Scene { nodes: nodes.iter().map(node).collect(), ..Scene::default() })
}

fn links(include: &[&str], exclude: &[&str]) -> Links {
    let list = |paths: &[&str]| paths.iter().map(|path| String::from(*path)).collect();
    Links::new(list(include), list(exclude)).expect("some")
}

/// Rules: LINK-1
#[test]
fn every_node_has_its_own_path() {
    let tree = tree(&[
        ("room", None),
        ("vase", Some(0)),
        ("vase", Some(0)),
        ("room", None),
        ("vase", Some(3)),
        ("", Some(3)),
        ("", Some(3)),
        ("vase#2", Some(0)),
        ("a/b~c", None),
    ]);
    let paths = [
        "room",
        "room/vase",
        "room/vase#2",
        "room#2",
        "room#2/vase",
        "room#2/node",
        "room#2/node#2",
        "room/vase~22",
        "a~1b~0c",
    ];
    for (node, path) in paths.into_iter().enumerate() {
        assert_eq!((tree.path(node).as_str(), tree.find(path)), (path, Some(node)));
    }
    for invalid in ["", "/", "room/", "/room", "room/vase#1", "room/vase#3", "vase", "room//vase", "a/b~c"] {
        assert_eq!(tree.find(invalid), None, "{invalid}");
    }
}

/// Rules: LINK-2
#[test]
fn the_deepest_entry_decides() {
    let tree = tree(&[("room", None), ("table", Some(0)), ("vase", Some(1)), ("vase", Some(1)), ("sky", None)]);
    let left = |include: &[&str], exclude: &[&str]| {
        tree.selected_nodes(&links(include, exclude)).into_iter().map(u8::from).collect::<Vec<_>>()
    };
    assert_eq!(left(&[], &["room/table"]), [1, 0, 0, 0, 1]);
    assert_eq!(left(&["room/table"], &[]), [0, 1, 1, 1, 0]);
    assert_eq!(left(&["room"], &["room/table"]), [1, 0, 0, 0, 0]);
    assert_eq!(left(&["room", "room/table/vase#2"], &["room/table"]), [1, 0, 0, 1, 0]);
    assert_eq!(left(&["room/table"], &["room"]), [0, 1, 1, 1, 0], "whichever list it stands in");
    assert_eq!(left(&["room/table"], &["room/table"]), [0; 5], "of two exclude counts");
    // Unknown paths have no effect, but a list of unknown includes still includes nothing.
    assert_eq!(left(&[], &["room/chair"]), [1; 5]);
    assert_eq!(left(&["room/chair"], &[]), [0; 5]);
}

/// Lists stay within their limits however deep a scene is.
#[test]
fn drawn_paths_stay_within_limits() {
    let tree = tree(&[("empty", None), ("lid", Some(0)), ("empty", None), ("empty", Some(2)), ("pot", None)]);
    let all = ["empty", "empty/lid", "pot"].map(String::from).to_vec();
    assert_eq!(tree.drawn_paths(9, 99), (all.clone(), 0));
    assert_eq!(tree.drawn_paths(2, 99), (all[..2].to_vec(), 1));
    assert_eq!(tree.drawn_paths(9, 5), (vec![all[0].clone(), all[2].clone()], 1));
    let chain: Vec<_> = (0..100_000_usize).map(|node| ("link", node.checked_sub(1))).collect();
    let (paths, more) = self::tree(&chain).drawn_paths(1000, 1024);
    assert_eq!((paths.len(), paths.len() + more), (205, 100_000), "five bytes a link");
}
