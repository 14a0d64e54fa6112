//! Poses, bounds, cameras and paths of nodes.

mod node_tree;
mod scene;
