//! Finds triangles of closed components. Light from outside such a component hits only its front faces.

use glam::{DVec3, Vec3};

use crate::bounds::BoundsF32;

/// Kind of component that a triangle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleComponent {
    /// A surface with an edge, or with inconsistent winding.
    Open,
    /// A closed surface, counter-clockwise from outside.
    Closed,
    /// A closed surface, counter-clockwise from inside.
    InsideOut,
}

/// The connected components of a list of triangles.
#[derive(Debug)]
pub(crate) struct ClosedComponents {
    /// Component of each triangle.
    part_of: Vec<u32>,
    parts: Vec<(TriangleComponent, BoundsF32)>,
}

/// Component to which triangles are still being added.
#[derive(Debug)]
struct ComponentBuilder {
    first: DVec3,
    bounds: BoundsF32,
    is_closed: bool,
    /// Six times the volume that the component's triangles enclose.
    volume: f64,
    volume_at_most: f64,
}

/// Volume, as a share of the sum of the absolute volumes of its triangles' tetrahedra, below which a component encloses
/// nothing: the volume is rounding error.
const MIN_VOLUME_RATIO: f64 = 1e-6;

impl ComponentBuilder {
    fn at(first: Vec3) -> Self {
        let bounds = BoundsF32 { min: first, max: first };
        Self { first: first.as_dvec3(), bounds, is_closed: true, volume: 0.0, volume_at_most: 0.0 }
    }

    fn add(&mut self, corners: [Vec3; 3]) {
        self.bounds = BoundsF32::union([self.bounds, BoundsF32::of(corners.into_iter())].into_iter());
        // Relative to a point of the component, since far from it rounding would dominate.
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - self.first);
        let volume = a.dot(b.cross(c));
        self.volume += volume;
        self.volume_at_most += volume.abs();
    }

    fn component(&self) -> TriangleComponent {
        if !self.is_closed || self.volume.abs() <= MIN_VOLUME_RATIO * self.volume_at_most {
            TriangleComponent::Open
        } else if self.volume > 0.0 {
            TriangleComponent::Closed
        } else {
            TriangleComponent::InsideOut
        }
    }
}

impl TriangleComponent {
    /// All kinds, in the order of their numbers in `bent_map.wgsl`.
    pub const ALL: [Self; 3] = [Self::Open, Self::Closed, Self::InsideOut];

    /// Returns the kind of the component after a reflection.
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Open => Self::Open,
            Self::Closed => Self::InsideOut,
            Self::InsideOut => Self::Closed,
        }
    }
}

impl ClosedComponents {
    /// Welds vertices by position.
    ///
    /// A component is closed if each edge is passed equally often in both directions. A path that begins and ends
    /// outside then enters as often as it leaves.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let first_at = meshopt::generate_position_remap_decoder(positions);
        let welded: Vec<[u32; 3]> = triangles.iter().map(|triangle| triangle.map(|k| first_at[k as usize])).collect();
        let root_of = connected(positions.len(), &welded);
        let mut number_of = vec![u32::MAX; positions.len()];
        let mut parts: Vec<ComponentBuilder> = Vec::new();
        let mut part_of = Vec::with_capacity(welded.len());
        for corners in &welded {
            let number = &mut number_of[root_of[corners[0] as usize] as usize];
            if *number == u32::MAX {
                *number = parts.len() as u32;
                parts.push(ComponentBuilder::at(Vec3::from(positions[corners[0] as usize])));
            }
            part_of.push(*number);
            parts[*number as usize].add(corners.map(|k| Vec3::from(positions[k as usize])));
        }
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * welded.len());
        for (&[a, b, c], &part) in welded.iter().zip(&part_of) {
            for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
                edges.push((from.min(to), from.max(to), from < to, part));
            }
        }
        edges.sort_unstable();
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if 2 * edge.iter().filter(|edge| edge.2).count() != edge.len() {
                parts[edge[0].3 as usize].is_closed = false;
            }
        }
        let parts = parts.into_iter().map(|part| (part.component(), part.bounds)).collect();
        Self { part_of, parts }
    }

    pub fn component_of(&self, triangle: u32) -> TriangleComponent {
        self.part(triangle).0
    }

    /// Returns the bounds of the component to which the triangle belongs.
    pub fn bounds(&self, triangle: u32) -> BoundsF32 {
        self.part(triangle).1
    }

    fn part(&self, triangle: u32) -> (TriangleComponent, BoundsF32) {
        self.parts[self.part_of[triangle as usize] as usize]
    }
}

/// Labels vertices; vertices that triangles connect have the same label.
pub(crate) fn connected(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..vertex_count as u32).collect();
    let root = |parents: &mut Vec<u32>, mut vertex: u32| {
        while parents[vertex as usize] != vertex {
            let above = parents[vertex as usize];
            parents[vertex as usize] = parents[above as usize];
            vertex = above;
        }
        vertex
    };
    for &[a, b, c] in triangles {
        let to = root(&mut parents, a);
        for vertex in [b, c] {
            let from = root(&mut parents, vertex);
            parents[from as usize] = to;
        }
    }
    (0..vertex_count as u32).map(|vertex| root(&mut parents, vertex)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a box whose faces have separate corners, as normals require.
    fn cube(at: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let corner = |k: usize| [at + (k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32];
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let positions = faces.iter().flatten().map(|&k| corner(k)).collect();
        let triangles = (0..6).flat_map(|face| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| 4 * face + k)));
        (positions, triangles.collect())
    }

    fn shells_of((positions, triangles): &(Vec<[f32; 3]>, Vec<[u32; 3]>)) -> Vec<TriangleComponent> {
        let shells = ClosedComponents::new(positions, triangles);
        (0..triangles.len() as u32).map(|triangle| shells.component_of(triangle)).collect()
    }

    #[test]
    fn a_box_is_closed_with_every_face_and_open_without_one() {
        let whole = cube(0.0);
        assert_eq!(shells_of(&whole), [TriangleComponent::Closed; 12]);
        let inside_out = (whole.0.clone(), whole.1.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>());
        assert_eq!(shells_of(&inside_out), [TriangleComponent::InsideOut; 12]);
        for missing in 0..12 {
            let mut open = whole.clone();
            open.1.remove(missing);
            assert_eq!(shells_of(&open), [TriangleComponent::Open; 11], "without triangle {missing}");
        }
        for turned in 0..12 {
            let mut mixed = whole.clone();
            mixed.1[turned].swap(0, 1);
            assert_eq!(shells_of(&mixed), [TriangleComponent::Open; 12], "triangle {turned} is turned round");
        }
    }

    #[test]
    fn parts_are_told_apart() {
        let (near, far) = (cube(0.0), cube(10.0));
        let positions = [near.0, far.0].concat();
        let triangles: Vec<_> = near.1.into_iter().chain(far.1[1..].iter().map(|t| t.map(|k| k + 24))).collect();
        let shells = ClosedComponents::new(&positions, &triangles);
        assert_eq!(
            [shells.component_of(0), shells.component_of(12)],
            [TriangleComponent::Closed, TriangleComponent::Open]
        );
        let BoundsF32 { min, max } = shells.bounds(3);
        assert_eq!([min, max], [Vec3::ZERO, Vec3::ONE]);
    }

    /// A two-sided card has no inside, and neither do triangles without area.
    #[test]
    fn what_encloses_nothing_is_open() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.5], [0.0, 1.0, 0.3]];
        assert_eq!(shells_of(&(positions.to_vec(), vec![[0, 1, 2], [0, 2, 1]])), [TriangleComponent::Open; 2]);
        assert_eq!(shells_of(&(positions.to_vec(), vec![[0, 0, 1], [2, 2, 2]])), [TriangleComponent::Open; 2]);
        assert_eq!(shells_of(&(Vec::new(), Vec::new())), []);
    }
}
