//! Depth complexity: number of surfaces that overlap in a pixel of a picture or in a texel of a shadow map.

use glam::DVec3;

use crate::PosedScene;

/// Number of cells along each side of the grids on which triangles are counted.
const CELLS: usize = 16;

impl PosedScene {
    /// Returns the upper bound of the depth complexity along the three axes, at least 1.
    ///
    /// Triangles are counted on a coarse grid across each axis. A triangle adds to each cell the share of it that its
    /// bounding box covers. The result is the largest sum. It is too large where triangles do not fill their boxes.
    ///
    /// The first call visits every triangle. Later calls return the stored value.
    pub fn depth_complexity(&self) -> f64 {
        *self.depth_complexity.get_or_init(|| depth_complexity(self))
    }
}

fn depth_complexity(posed: &PosedScene) -> f64 {
    let mut grids = [0; 3].map(|_: usize| vec![0.0_f64; CELLS * CELLS]);
    // In cells, from a corner of the bounds. A flat scene has one row.
    let cells_per_unit = posed.half_extent.map(|half| if half > 0.0 { CELLS as f64 / (2.0 * half) } else { 0.0 });
    let in_cells = |position: DVec3| (position + posed.half_extent) * cells_per_unit;
    for primitive in &posed.primitives {
        let positions = &posed.positions[primitive.first_vertex..];
        for triangle in posed.triangles(primitive) {
            let [a, b, c] = triangle.map(|corner| in_cells(positions[corner as usize]));
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            for (axis, grid) in grids.iter_mut().enumerate() {
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|across| [low[across], high[across]]);
                add(grid, u, v);
            }
        }
    }
    grids.iter().flatten().fold(1.0, |most, cell| most.max(*cell))
}

/// Adds to each cell the share of its area that the box `u` by `v` covers.
fn add(grid: &mut [f64], u: [f64; 2], v: [f64; 2]) {
    let cells = |[low, high]: [f64; 2]| {
        let [first, last] = [low, high].map(|at| (at as usize).min(CELLS - 1));
        (first..=last).map(move |cell| (cell, (high.min(cell as f64 + 1.0) - low.max(cell as f64)).max(0.0)))
    };
    for (row, of_row) in cells(v) {
        for (column, of_column) in cells(u) {
            grid[row * CELLS + column] += of_row * of_column;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, Vec3};

    use crate::{Mesh, Node, Primitive, Scene, pose};

    /// Makes `count` triangles, each `apart` from the one before along x, each over half of the unit square.
    fn scene(count: usize, apart: f32) -> Scene {
        let at = |k: usize| Vec3::X * (k as f32 * apart);
        let positions: Vec<Vec3> =
            (0..count).flat_map(|k| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + at(k))).collect();
        let indices = (0..3 * count as u32).collect();
        let normals = vec![Vec3::Z; positions.len()];
        let primitive = Primitive { positions, normals, indices, ..Primitive::default() };
        let node = Node { name: "node".into(), parent: None, parent_from_local: DAffine3::IDENTITY, mesh: Some(0) };
        Scene {
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            nodes: vec![node],
            ..Scene::default()
        }
    }

    #[test]
    fn overlapping_triangles_count_and_separate_ones_do_not() {
        assert_eq!(pose(Scene::default(), 0.0).depth_complexity(), 1.0);
        assert_eq!(pose(scene(1_000, 0.0), 0.0).depth_complexity(), 1_000.0);
        // Each cell is wider than a triangle and holds about 60 side by side.
        let beside = pose(scene(1_000, 1.0), 0.0).depth_complexity();
        assert!((1.0..=2.0).contains(&beside), "{beside}");
    }
}
