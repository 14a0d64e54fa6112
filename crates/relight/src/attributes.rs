//! Surfaces that pixels show, from the triangles of a visibility buffer: attributes of the vertices are fetched and
//! interpolated, sixteen pixels at once. Like `gbuffer.wgsl`.

use glam::Vec2;
use light::Lanes;

use crate::CasterScene;
use crate::encoding::{material_to_bits, unit_to_bits};
use crate::lanes::{F32s, LANES, Masks, U32s, Vec3s};
use crate::pixel_block::{BLOCK_SIDE, CameraRays, PixelBlock, rays};
use crate::raster::VisibilityBuffer;
use crate::simd::{self, SimdTask};
use crate::texture::{SampledTexture, Texture};

/// Scene as pixels show it.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceScene<'a> {
    pub triangles: &'a CasterScene<'a>,
    pub materials: &'a SurfaceMaterials,
}

/// Materials of a scene's triangles.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMaterials {
    /// Runs of triangles with one material, in the order of the triangles.
    pub runs: Vec<MaterialRun>,
    pub textures: Vec<Texture>,
}

/// Consecutive triangles with one material.
#[derive(Clone, Copy, Debug)]
pub struct MaterialRun {
    /// Index after the run's last triangle.
    pub end: u32,
    /// True if one of its vertices is not white.
    pub has_colors: bool,
    pub material: SurfaceMaterial,
}

/// glTF's metallic-roughness material.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceMaterial {
    /// Linear RGBA.
    pub base_color: [f32; 4],
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Linear colors that multiply the base color.
    pub base_color_texture: Option<SampledTexture>,
    /// Roughness in green and metallic in blue, which multiply the factors.
    pub metallic_roughness_texture: Option<SampledTexture>,
}

impl SurfaceMaterial {
    fn has_textures(&self) -> bool {
        self.base_color_texture.is_some() || self.metallic_roughness_texture.is_some()
    }
}

impl SurfaceMaterials {
    /// Returns the size in bytes.
    pub fn bytes(&self) -> u64 {
        self.textures.iter().map(Texture::bytes).sum::<u64>() + size_of_val(&self.runs[..]) as u64
    }

    /// Returns the index of the run of a triangle. `guess` is tried first.
    #[inline(always)]
    fn run_of(&self, triangle: u32, guess: usize) -> usize {
        let starts_before = guess == 0 || self.runs[guess - 1].end <= triangle;
        if starts_before && triangle < self.runs[guess].end {
            return guess;
        }
        self.runs.partition_point(|run| run.end <= triangle)
    }
}

/// Vertex attributes of the triangles of sixteen pixels. Lanes without a triangle have zeros.
struct Corners {
    positions: [Vec3s; 3],
    normals: [Vec3s; 3],
    /// `None` if no pixel has a texture.
    uvs: Option<[[F32s; 2]; 3]>,
    /// RGB; `None` if all are white.
    colors: Option<[[F32s; 3]; 3]>,
}

/// Fetches values of the vertices of the triangles of sixteen pixels. It has no arithmetic, so one copy serves every
/// processor.
#[inline(always)]
fn fetch<const N: usize>(indices: &[u32], triangles: &U32s, of_vertex: impl Fn(usize) -> [f32; N]) -> [[F32s; N]; 3] {
    let (indices, mut values) = (indices.as_chunks::<3>().0, [[F32s::ZERO; N]; 3]);
    let first = triangles.0[0];
    if first != 0 && triangles.0.iter().all(|triangle| *triangle == first) {
        let corners = indices[first as usize - 1];
        return corners.map(|vertex| of_vertex(vertex as usize).map(F32s::splat));
    }
    for lane in 0..LANES {
        let Some(triangle) = triangles.0[lane].checked_sub(1) else { continue };
        for (corner, vertex) in values.iter_mut().zip(indices[triangle as usize]) {
            for (values, value) in corner.iter_mut().zip(of_vertex(vertex as usize)) {
                values.0[lane] = value;
            }
        }
    }
    values
}

impl Corners {
    #[inline(never)]
    fn fetch(scene: &CasterScene, triangles: &U32s) -> Self {
        let corners = fetch(scene.indices, triangles, |vertex| {
            let ([x, y, z], [n_x, n_y, n_z, ..]) = (scene.positions[vertex], scene.attributes[vertex]);
            [x, y, z, n_x, n_y, n_z]
        });
        Self {
            positions: corners.map(|[x, y, z, ..]| Vec3s { x, y, z }),
            normals: corners.map(|[.., x, y, z]| Vec3s { x, y, z }),
            uvs: None,
            colors: None,
        }
    }

    #[inline(never)]
    fn fetch_uvs(&mut self, scene: &CasterScene, triangles: &U32s) {
        self.uvs = Some(fetch(scene.indices, triangles, |vertex| {
            let [_, _, _, u, v, ..] = scene.attributes[vertex];
            [u, v]
        }));
    }

    #[inline(never)]
    fn fetch_colors(&mut self, scene: &CasterScene, triangles: &U32s) {
        self.colors = Some(fetch(scene.indices, triangles, |vertex| {
            let [_, _, _, _, _, r, g, b, _] = scene.attributes[vertex];
            [r, g, b]
        }));
    }

    /// Returns the barycentrics of points of the triangles' planes, one of them negative outside of a triangle; 0 for a
    /// triangle without area.
    #[inline(always)]
    fn weights_at(&self, points: Vec3s) -> [F32s; 3] {
        let (zero, one, least) = (F32s::ZERO, F32s::splat(1.0), F32s::splat(1e-37));
        let [a, b, c] = self.positions;
        let (ab, ac, at) = (b - a, c - a, points - a);
        let normal = F32s::cross(ab, ac);
        let area2 = F32s::dot(normal, normal);
        let has_area = area2.gt(least);
        let per_area2 = one / area2.most(least);
        let beta = F32s::dot(F32s::cross(at, ac), normal) * per_area2;
        let gamma = F32s::dot(F32s::cross(ab, at), normal) * per_area2;
        [one - beta - gamma, beta, gamma].map(|weight| F32s::select(has_area, weight, zero))
    }
}

/// Returns uv by these weights.
#[inline(always)]
fn uv_by([a, b, c]: &[[F32s; 2]; 3], weights: [F32s; 3]) -> [F32s; 2] {
    [0, 1].map(|axis| a[axis] * weights[0] + b[axis] * weights[1] + c[axis] * weights[2])
}

/// Planes of the triangles of sixteen pixels: `normal . p = offset`.
#[derive(Clone, Copy)]
struct Planes {
    normal: Vec3s,
    offset: F32s,
}

/// Returns the surfaces of a block of pixels; `None` if it shows none.
///
/// Each step is a task of its own: LLVM takes minutes for all of them in one function.
pub(crate) fn block_of(
    scene: &SurfaceScene,
    camera: &CameraRays,
    visible: &VisibilityBuffer,
    corner: [u16; 2],
) -> Option<PixelBlock> {
    let (triangles, z) = load(visible, corner)?;
    let planes = &fetch_planes(scene.triangles, &triangles);
    let runs = scene.materials.runs_of(&triangles);
    let mut corners = Corners::fetch(scene.triangles, &triangles);
    if runs.have_textures {
        corners.fetch_uvs(scene.triangles, &triangles);
    }
    if runs.have_colors {
        corners.fetch_colors(scene.triangles, &triangles);
    }
    let corners = &corners;
    let met = &simd::run(Meet { planes, camera, z: &z, corner });
    let shape = &simd::run(Interpolate { corners, planes, met });
    let uvs = corners.uvs.as_ref();
    let footprint = uvs.map(|uvs| simd::run(FindFootprint { camera, corner, corners, uvs, planes, shape }));
    let factors = &scene.materials.factors(&runs, footprint.as_ref());
    Some(simd::run(Pack { corners, planes, met, shape, factors, triangles: &triangles, corner }))
}

/// Task that intersects the rays of pixels with the planes of the triangles that were rasterized there at depths `z`, like
/// `depth_on` of `view.wgsl`.
struct Meet<'a> {
    planes: &'a Planes,
    camera: &'a CameraRays,
    z: &'a F32s,
    corner: [u16; 2],
}

/// Points at which the rays of pixels meet their triangles.
struct Met {
    /// Distance along the view axis.
    depth: F32s,
    position: Vec3s,
    /// True for a triangle that is seen from behind.
    is_back: Masks,
}

impl SimdTask for Meet<'_> {
    type Output = Met;

    #[inline(always)]
    fn run(self) -> Met {
        let Self { planes, camera, z, corner } = self;
        let (origin, direction) = rays(camera, corner, [0.0; 2]);
        let [a, b, c, d] = camera.depth_from_z.map(F32s::splat);
        let rough = (a + b * *z) / (c + d * *z);
        let closing = F32s::dot(planes.normal, direction);
        let is_edge_on = closing.equals(F32s::ZERO);
        let exact =
            (planes.offset - F32s::dot(planes.normal, origin)) / F32s::select(is_edge_on, F32s::splat(1.0), closing);
        let held = exact.within(F32s::splat(0.5) * rough, F32s::splat(2.0) * rough);
        let depth = F32s::select(is_edge_on, rough, held);
        Met { depth, position: origin + direction * depth, is_back: closing.gt(F32s::ZERO) }
    }
}

/// Task that interpolates normals and finds the weights of other attributes.
struct Interpolate<'a> {
    corners: &'a Corners,
    planes: &'a Planes,
    met: &'a Met,
}

/// Shapes of the triangles at the pixels' points.
struct Shape {
    /// Barycentrics within the triangles.
    weights: [F32s; 3],
    /// Barycentrics on the triangles' planes.
    on_plane: [F32s; 3],
    /// Unit shading normal, towards the viewer.
    normal: Vec3s,
    terminator_offset: F32s,
}

impl SimdTask for Interpolate<'_> {
    type Output = Shape;

    #[inline(always)]
    fn run(self) -> Shape {
        let Self { corners, planes, met } = self;
        let on_plane = corners.weights_at(met.position);
        let (zero, third) = (F32s::ZERO, F32s::splat(1.0 / 3.0));
        let inside = on_plane.map(|weight| weight.most(zero));
        let sum = inside[0] + inside[1] + inside[2];
        let per_sum = F32s::splat(1.0) / sum.most(F32s::splat(1e-37));
        // A triangle too small to resolve gets equal weights.
        let weights = inside.map(|weight| F32s::select(sum.gt(zero), weight * per_sum, third));
        let [n_a, n_b, n_c] = corners.normals;
        let smooth = n_a * weights[0] + n_b * weights[1] + n_c * weights[2];
        // Vertex normals that cancel leave nothing to interpolate, so the face normal is used.
        let has_normal = F32s::dot(smooth, smooth).gt(F32s::splat(1e-12));
        let normal = F32s::select_vec(has_normal, smooth, planes.normal);
        let normal = F32s::select_vec(met.is_back, -normal, normal);
        let [a, b, c] = corners.positions;
        let bulge = |p: Vec3s, n: Vec3s| F32s::dot(p - met.position, n - smooth).abs();
        Shape {
            weights,
            on_plane,
            normal: normal * (F32s::splat(1.0) / F32s::length(normal)),
            terminator_offset: bulge(a, n_a) * weights[0] + bulge(b, n_b) * weights[1] + bulge(c, n_c) * weights[2],
        }
    }
}

/// Task that packs the surfaces of a block.
struct Pack<'a> {
    corners: &'a Corners,
    planes: &'a Planes,
    met: &'a Met,
    shape: &'a Shape,
    factors: &'a Factors,
    triangles: &'a U32s,
    corner: [u16; 2],
}

impl SimdTask for Pack<'_> {
    type Output = PixelBlock;

    #[inline(always)]
    fn run(self) -> PixelBlock {
        let Self { corners, planes, met, shape, factors, triangles, corner } = self;
        let (zero, one, none) = (F32s::ZERO, F32s::splat(1.0), U32s::ZERO);
        let exists = !triangles.equals(none);
        let weights = shape.weights;
        let base_color: [F32s; 3] = std::array::from_fn(|k| {
            let color = match &corners.colors {
                Some([a, b, c]) => a[k] * weights[0] + b[k] * weights[1] + c[k] * weights[2],
                None => weights[0] + weights[1] + weights[2],
            };
            (factors.base_color[k] * color).within(zero, one)
        });
        let (metallic, roughness) = (factors.metallic.within(zero, one), factors.roughness.within(zero, one));
        let material = material_to_bits(base_color, metallic, roughness);
        PixelBlock {
            depth: met.depth,
            normal: U32s::select(exists, unit_to_bits(shape.normal), none),
            geometric_normal: F32s::select_vec(met.is_back, -planes.normal, planes.normal),
            material: material.map(|bits| U32s::select(exists, bits, none)),
            terminator_offset: F32s::select(exists, shape.terminator_offset, zero),
            triangle: *triangles,
            corner,
        }
    }
}

/// Loads the triangles + 1 of a block and their z; `None` if there are none.
#[inline(never)]
fn load(visible: &VisibilityBuffer, corner: [u16; 2]) -> Option<(U32s, F32s)> {
    let [width, height] = visible.size();
    let (mut triangles, mut z) = (U32s::ZERO, F32s::ZERO);
    for lane in 0..LANES {
        let (x, y) = (corner[0] as usize + lane % BLOCK_SIDE, corner[1] as usize + lane / BLOCK_SIDE);
        if x < width && y < height {
            (triangles.0[lane], z.0[lane]) = visible.at(x, y);
        }
    }
    triangles.0.iter().any(|triangle| *triangle != 0).then_some((triangles, z))
}

#[inline(never)]
fn fetch_planes(scene: &CasterScene, triangles: &U32s) -> Planes {
    let mut planes = Planes { normal: Vec3s::splat([0.0; 3]), offset: F32s::ZERO };
    for lane in 0..LANES {
        let Some(triangle) = triangles.0[lane].checked_sub(1) else { continue };
        let [x, y, z, offset] = scene.planes[triangle as usize];
        (planes.normal.x.0[lane], planes.normal.y.0[lane], planes.normal.z.0[lane]) = (x, y, z);
        planes.offset.0[lane] = offset;
    }
    planes
}

/// uv at the pixels' points, and its changes to the next pixel to the right and down.
struct Footprint {
    uv: [F32s; 2],
    dx: [F32s; 2],
    dy: [F32s; 2],
}

impl Footprint {
    fn lane(&self, lane: usize) -> [Vec2; 3] {
        [&self.uv, &self.dx, &self.dy].map(|[u, v]| Vec2::new(u.0[lane], v.0[lane]))
    }
}

/// Factors of the materials of sixteen pixels, times their textures.
struct Factors {
    base_color: [F32s; 3],
    metallic: F32s,
    roughness: F32s,
}

/// Runs of the triangles of sixteen pixels.
struct Runs {
    /// Lanes without a triangle have the first run.
    indices: [usize; LANES],
    have_textures: bool,
    have_colors: bool,
}

impl SurfaceMaterials {
    #[inline(never)]
    fn runs_of(&self, triangles: &U32s) -> Runs {
        let mut runs = Runs { indices: [0; LANES], have_textures: false, have_colors: false };
        let mut run = 0;
        for (lane, of_lane) in runs.indices.iter_mut().enumerate() {
            let Some(triangle) = triangles.0[lane].checked_sub(1) else { continue };
            run = self.run_of(triangle, run);
            *of_lane = run;
            let MaterialRun { material, has_colors, .. } = &self.runs[run];
            runs.have_textures |= material.has_textures();
            runs.have_colors |= has_colors;
        }
        runs
    }

    /// Looks up the factors of the materials in these runs.
    #[inline(never)]
    fn factors(&self, runs: &Runs, footprint: Option<&Footprint>) -> Factors {
        let first = runs.indices[0];
        if footprint.is_none() && runs.indices.iter().all(|run| *run == first) {
            let SurfaceMaterial { base_color: [r, g, b, _], metallic, roughness, .. } = self.runs[first].material;
            return Factors {
                base_color: [r, g, b].map(F32s::splat),
                metallic: F32s::splat(metallic),
                roughness: F32s::splat(roughness),
            };
        }
        let mut factors = Factors { base_color: [F32s::ZERO; 3], metallic: F32s::ZERO, roughness: F32s::ZERO };
        for (lane, run) in runs.indices.iter().enumerate() {
            let material = &self.runs[*run].material;
            let SurfaceMaterial { base_color: [mut r, mut g, mut b, _], mut metallic, mut roughness, .. } = *material;
            if let Some(footprint) = footprint {
                let [uv, dx, dy] = footprint.lane(lane);
                if let Some(how) = &material.base_color_texture {
                    let [red, green, blue, _] = self.textures[how.texture].sample(how, uv, dx, dy);
                    (r, g, b) = (r * red, g * green, b * blue);
                }
                if let Some(how) = &material.metallic_roughness_texture {
                    let [_, green, blue, _] = self.textures[how.texture].sample(how, uv, dx, dy);
                    (metallic, roughness) = (metallic * blue, roughness * green);
                }
            }
            let [red, green, blue] = &mut factors.base_color;
            (red.0[lane], green.0[lane], blue.0[lane]) = (r, g, b);
            (factors.metallic.0[lane], factors.roughness.0[lane]) = (metallic, roughness);
        }
        factors
    }
}

/// Task that finds uv at the pixels' points, and its changes on the triangles' planes, extrapolated outside of the
/// triangles.
struct FindFootprint<'a> {
    camera: &'a CameraRays,
    corner: [u16; 2],
    corners: &'a Corners,
    uvs: &'a [[F32s; 2]; 3],
    planes: &'a Planes,
    shape: &'a Shape,
}

impl SimdTask for FindFootprint<'_> {
    type Output = Footprint;

    #[inline(always)]
    fn run(self) -> Footprint {
        let Self { camera, corner, corners, uvs, planes, shape } = self;
        let here = uv_by(uvs, shape.on_plane);
        let [dx, dy] = [[1.0, 0.0], [0.0, 1.0]].map(|step| {
            let (origin, direction) = rays(camera, corner, step);
            let distance = (planes.offset - F32s::dot(planes.normal, origin)) / F32s::dot(planes.normal, direction);
            let there = uv_by(uvs, corners.weights_at(origin + direction * distance));
            [there[0] - here[0], there[1] - here[1]]
        });
        Footprint { uv: uv_by(uvs, shape.weights), dx, dy }
    }
}
