//! Links: the nodes of a scene that a light affects.

/// Maximum number of nodes that links name.
pub const MAX_LINKS: usize = 1024;
/// Maximum number of bytes of all paths in links together.
pub const MAX_LINK_BYTES: usize = 1 << 16;

/// Selection of nodes of a scene by their paths (`scene::NodeTree` resolves them).
///
/// The nodes in `include` are selected, or all nodes if it is empty, without those in `exclude`. An entry covers a node
/// and all its descendants. For each node the deepest entry decides. If both lists name the same node, `exclude`
/// decides.
///
/// Lists are sets: sorted, and without duplicates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Links {
    include: Vec<String>,
    exclude: Vec<String>,
}

impl Links {
    /// Makes links; `None` if both lists are empty, which selects all nodes.
    pub fn new(mut include: Vec<String>, mut exclude: Vec<String>) -> Option<Self> {
        for paths in [&mut include, &mut exclude] {
            paths.sort_unstable();
            paths.dedup();
        }
        (!include.is_empty() || !exclude.is_empty()).then_some(Self { include, exclude })
    }

    /// Returns the paths of selected nodes; if empty, all are selected.
    pub fn include(&self) -> &[String] {
        &self.include
    }

    /// Returns the paths of nodes that are not selected.
    pub fn exclude(&self) -> &[String] {
        &self.exclude
    }

    /// Returns the number of paths and their total length in bytes.
    pub(crate) fn size(&self) -> (usize, usize) {
        let paths = || self.include.iter().chain(&self.exclude);
        (paths().count(), paths().map(String::len).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sets() {
        let list = |names: &[&str]| names.iter().map(|name| String::from(*name)).collect::<Vec<_>>();
        let links = Links::new(list(&["b", "a", "b"]), list(&["c"]));
        assert_eq!(links, Links::new(list(&["a", "b"]), list(&["c", "c"])));
        assert_ne!(links, Links::new(list(&["c"]), list(&["a", "b"])));
        assert_eq!(Links::new(list(&[]), list(&[])), None);
    }
}
