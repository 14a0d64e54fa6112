//! Which nodes of a scene count for a light.

/// Most nodes that links name.
pub const MAX_LINKS: usize = 1024;
/// Most bytes of all their paths.
pub const MAX_LINK_BYTES: usize = 1 << 16;

/// Some nodes of a scene, by their paths (`scene::NodeTree` has them): those that `include` names, or all where it names
/// none, without those that `exclude` names. A node stands for all that is under it. Of the entries that a node is or
/// stands under the deepest decides, and of two that name the same node `exclude`.
///
/// Lists are sets: sorted, and without duplicates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Links {
    include: Vec<String>,
    exclude: Vec<String>,
}

impl Links {
    /// `None` where both lists are empty, which leaves all nodes.
    pub fn new(mut include: Vec<String>, mut exclude: Vec<String>) -> Option<Self> {
        for paths in [&mut include, &mut exclude] {
            paths.sort_unstable();
            paths.dedup();
        }
        (!include.is_empty() || !exclude.is_empty()).then_some(Self { include, exclude })
    }

    /// Paths of nodes that count; where there are none, all do.
    pub fn include(&self) -> &[String] {
        &self.include
    }

    /// Paths of nodes that do not.
    pub fn exclude(&self) -> &[String] {
        &self.exclude
    }

    /// How many nodes they name, and by how many bytes.
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
