//! Triangles of a posed scene in f32, in draw order.

use std::ops::Range;

use glam::{Vec2, Vec3, Vec4};
use light::MAX_EXTENT;
use scene::{Material, PosedPrimitive, PosedScene};

use crate::RenderError;

/// Vertices and triangles of a posed scene, in f32, in draw order.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    pub positions: Vec<[f32; 3]>,
    pub attributes: Vec<Attributes>,
    /// Three per triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// One plane per triangle: the unit normal, and its dot product with any point of the triangle. All zeros if the
    /// area is 0.
    pub planes: Vec<[f32; 4]>,
    /// Ranges of triangles with one material, one per material in use. Those without an alpha test come first.
    pub draws: Vec<MaterialRange>,
    /// Ranges of triangles of each posed primitive, in the same order as the primitives.
    pub runs: Vec<DrawRun>,
}

/// Attributes of a vertex besides its position.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Attributes {
    pub normal: [f32; 3],
    pub uv: [f32; 2],
    pub color: [f32; 4],
}

/// Triangles of one posed primitive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DrawRun {
    pub node: usize,
    /// Index in [`PosedScene::primitives`].
    pub primitive: usize,
    pub first_vertex: u32,
    pub indices: Range<u32>,
}

/// A run of triangles with one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MaterialRange {
    pub material: usize,
    pub indices: Range<u32>,
}

impl Vertices {
    /// Converts `scene`. Returns an error if f32 cannot hold it.
    pub fn new(scene: &PosedScene) -> Result<Self, RenderError> {
        let reach = scene.half_extent.max_element();
        if !(reach <= MAX_EXTENT && scene.origin_in_world.is_finite()) {
            return Err(RenderError::TooLarge { what: "half the scene's size", size: reach, limit: MAX_EXTENT });
        }
        let mut vertices = Self::default();
        let mut primitives: Vec<_> = scene.primitives.iter().enumerate().collect();
        primitives.sort_by_key(|(_, posed)| draw_order(&scene.scene.materials, scene.geometry(posed).material));
        for (number, primitive) in primitives {
            vertices.add(scene, number, primitive)?;
        }
        Ok(vertices)
    }

    fn add(&mut self, scene: &PosedScene, number: usize, posed: &PosedPrimitive) -> Result<(), RenderError> {
        let primitive = scene.geometry(posed);
        let index = |count: usize| {
            RenderError::check_size("the number of vertices or indices", count as u64, u32::MAX.into())?;
            Ok::<_, RenderError>(count as u32)
        };
        let first_vertex = index(self.positions.len())?;
        let normal_matrix = posed.normal_matrix();
        let positions = &scene.positions[posed.first_vertex..][..primitive.positions.len()];
        self.positions.extend(positions.iter().map(|position| position.as_vec3().to_array()));
        for (i, normal) in primitive.normals.iter().enumerate() {
            self.attributes.push(Attributes {
                normal: (normal_matrix * normal.as_dvec3()).normalize_or_zero().as_vec3().to_array(),
                uv: primitive.uvs.get(i).map_or([0.0; 2], Vec2::to_array),
                color: primitive.colors.get(i).map_or([1.0; 4], Vec4::to_array),
            });
        }
        let first_index = index(self.indices.len())?;
        for triangle in scene.triangles(posed) {
            let corners = triangle.map(|k| first_vertex + k);
            self.indices.extend(corners);
            self.planes.push(plane(corners.map(|k| self.positions[k as usize])));
        }
        let end = index(self.indices.len())?;
        let indices = first_index..end;
        self.runs.push(DrawRun { node: posed.node, primitive: number, first_vertex, indices });
        match self.draws.last_mut() {
            Some(draw) if draw.material == primitive.material => draw.indices.end = end,
            _ => self.draws.push(MaterialRange { material: primitive.material, indices: first_index..end }),
        }
        Ok(())
    }
}

/// Returns the sort key of draws. Those without an alpha test come first, in one run that a shadow pass draws with one
/// call.
fn draw_order(materials: &[Material], index: usize) -> (bool, usize) {
    (materials[index].alpha_cutoff.is_some(), index)
}

/// Returns the unit normal of the counter-clockwise side, and its dot product with the corners.
///
/// Computed from the rounded corners, the product with the rounded normal. Only the rounding of the product remains,
/// one ulp of the distance from the scene's center.
fn plane(corners: [[f32; 3]; 3]) -> [f32; 4] {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
    let offset = normal.as_dvec3().dot((a + b + c) / 3.0);
    [normal.x, normal.y, normal.z, offset as f32]
}

/// Converts triangles in the order of the scene's primitives to their places in the draw order.
pub(crate) fn in_draw_order(scene: &PosedScene, runs: &[DrawRun], triangles: &[u32]) -> Vec<u32> {
    let mut by_primitive: Vec<_> = runs.iter().collect();
    by_primitive.sort_by_key(|run| run.primitive);
    let mut in_draws = Vec::with_capacity(scene.triangle_count());
    for run in by_primitive {
        in_draws.extend(run.indices.start / 3..run.indices.end / 3);
    }
    triangles.iter().map(|triangle| in_draws[*triangle as usize]).collect()
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use scene::{Primitive, Scene};

    use super::*;
    use crate::wgpu::bendy_light::tests::add_mesh;

    /// Returns a triangle in the plane z = 0 that faces +z, transformed by `world_from_local`.
    fn scene_with(world_from_local: DAffine3) -> Scene {
        let primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            indices: vec![0, 1, 2],
            ..Primitive::default()
        };
        let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
        add_mesh(&mut scene, primitive, world_from_local);
        scene
    }

    fn of(scene: Scene) -> Result<Vertices, RenderError> {
        Vertices::new(&scene::pose(scene, 0.0))
    }

    #[test]
    fn mirrored_nodes_keep_their_front() {
        for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(2.0, -0.5, 3.0)] {
            let posed = of(scene_with(DAffine3::from_scale(scale))).unwrap();
            assert_eq!(posed.attributes[0].normal, [0.0, 0.0, 1.0]);
            assert_eq!(posed.planes[0][..3], [0.0, 0.0, 1.0], "scale {scale}");
        }
        // Mirrored along z, the front faces the other way. The fault would be an unchanged winding.
        let posed = of(scene_with(DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)))).unwrap();
        assert_eq!((posed.attributes[0].normal, posed.planes[0][2]), ([0.0, 0.0, -1.0], -1.0));
    }

    #[test]
    fn singular_nodes_have_no_nan() {
        for scale in [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::ZERO] {
            let posed = of(scene_with(DAffine3::from_scale(scale))).unwrap();
            assert!(posed.planes.iter().flatten().all(|x| x.is_finite()));
            assert!(posed.attributes.iter().all(|a| a.normal.iter().all(|x| x.is_finite())));
        }
        let flat = of(scene_with(DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)))).unwrap();
        assert_eq!(flat.attributes[0].normal, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn far_from_the_world_origin_nothing_is_lost() {
        let offset = DVec3::new(1e6, -2e6, 3e6);
        let (near, far) =
            (of(scene_with(DAffine3::IDENTITY)).unwrap(), of(scene_with(DAffine3::from_translation(offset))).unwrap());
        assert_eq!(near.positions, far.positions);
    }

    #[test]
    fn scenes_beyond_f32_are_refused() {
        let refused = of(scene_with(DAffine3::from_scale(DVec3::splat(1e16)))).unwrap_err();
        assert!(matches!(refused, RenderError::TooLarge { .. }));
    }

    #[test]
    fn alpha_tested_draws_come_last_and_equal_materials_merge() {
        let mut scene = scene_with(DAffine3::IDENTITY);
        scene.materials = vec![Material { alpha_cutoff: Some(0.5), ..Material::default() }, Material::default()];
        let alpha_tested = scene.meshes[0].primitives[0].clone();
        let opaque = Primitive { material: 1, ..alpha_tested.clone() };
        scene.meshes[0].primitives = vec![opaque.clone(), alpha_tested, opaque];
        let draws = of(scene).unwrap().draws;
        assert_eq!(draws, [MaterialRange { material: 1, indices: 0..6 }, MaterialRange { material: 0, indices: 6..9 }]);
    }
}
