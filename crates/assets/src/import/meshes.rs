//! Import of meshes as triangle lists with normals.

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use scene::Primitive;

use super::accessors::{IntegerConversion, components};
use super::materials::ImportedMaterial;
use super::{ImportReport, ImportSource, display_name};
use crate::fault::invalid_gltf;
use crate::{AssetFault, ImportLimit};

/// Reads the mesh at `index` in the file. Primitives without triangles are left out.
pub fn read(
    source: &ImportSource,
    index: usize,
    materials: &[ImportedMaterial],
    report: &mut ImportReport,
) -> Result<scene::Mesh, AssetFault> {
    let mesh = &source.root.meshes[index];
    let name = display_name(mesh.name.as_deref(), "mesh", index);
    let mut primitives = Vec::new();
    for primitive in &mesh.primitives {
        let triangles_of: fn(&[u32]) -> Vec<u32> = match primitive.mode {
            Checked::Valid(Mode::Triangles) | Checked::Invalid => list,
            Checked::Valid(Mode::TriangleStrip) => strip,
            Checked::Valid(Mode::TriangleFan) => fan,
            Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => {
                report.notes.add("points and lines are not drawn", name.as_str());
                continue;
            }
        };
        let Some(positions) = attribute(source, primitive, Semantic::Positions)? else {
            report.notes.add("meshes without positions are not drawn", name.as_str());
            continue;
        };
        let order = vertex_order(source, primitive, positions, report)?;
        let indices = triangles_of(&order);
        if indices.is_empty() {
            report.notes.add("meshes without a whole triangle are not drawn", name.as_str());
            continue;
        }
        let material = primitive.material.map_or(materials.len() - 1, |m| m.value());
        primitives.push(assemble(source, primitive, indices, material, &materials[material], report)?);
    }
    Ok(scene::Mesh { name, primitives })
}

/// Returns the vertex indices in drawing order. Each is in range.
fn vertex_order(
    source: &ImportSource,
    primitive: &json::mesh::Primitive,
    positions: &Accessor,
    report: &mut ImportReport,
) -> Result<Vec<u32>, AssetFault> {
    let vertices = positions.count.0;
    report.budget.spend(ImportLimit::Vertices, vertices)?;
    let indices = primitive.indices.and_then(|indices| source.root.get(indices));
    // A strip or fan has about one triangle per index.
    let per_triangle = if primitive.mode == Checked::Valid(Mode::Triangles) { 3 } else { 1 };
    report.budget.spend(ImportLimit::Triangles, indices.map_or(vertices, |i| i.count.0) / per_triangle)?;
    let Some(indices) = indices else { return Ok((0..vertices as u32).collect()) };
    let order = source.indices(indices)?;
    match order.iter().find(|&&i| u64::from(i) >= vertices) {
        Some(index) => Err(invalid_gltf(format!("an index is {index}, but there are {vertices} vertices"))),
        None => Ok(order),
    }
}

fn assemble(
    source: &ImportSource,
    primitive: &json::mesh::Primitive,
    indices: Vec<u32>,
    material: usize,
    look: &ImportedMaterial,
    report: &mut ImportReport,
) -> Result<Primitive, AssetFault> {
    let positions = vectors::<3>(source, primitive, Semantic::Positions)?;
    let normals = vectors::<3>(source, primitive, Semantic::Normals)?;
    let uvs = vectors::<2>(source, primitive, Semantic::TexCoords(look.coordinates.set))?;
    let in_picture = |uv| look.coordinates.picture_from_stored.transform_point2(Vec2::from_array(uv));
    let uvs: Vec<Vec2> = uvs.into_iter().map(in_picture).collect();
    if !uvs.iter().all(|uv| uv.is_finite()) {
        return Err(invalid_gltf("texture coordinates are not finite"));
    }
    let has_normals = !normals.is_empty();
    let made = Primitive {
        positions: positions.into_iter().map(Vec3::from_array).collect(),
        normals: normals.into_iter().map(|n| unit(Vec3::from_array(n))).collect(),
        uvs,
        colors: colors(source, primitive)?,
        indices,
        material,
    };
    if has_normals {
        return Ok(made);
    }
    report.budget.spend(ImportLimit::Vertices, made.indices.len() as u64)?;
    Ok(faceted(&made))
}

/// Reads an attribute of `N` components; an empty list if the primitive does not have it.
fn vectors<const N: usize>(
    source: &ImportSource,
    primitive: &json::mesh::Primitive,
    semantic: Semantic,
) -> Result<Vec<[f32; N]>, AssetFault> {
    let accessor = attribute(source, primitive, semantic)?;
    accessor.map_or(Ok(Vec::new()), |accessor| source.floats(accessor, IntegerConversion::AsDeclared))
}

/// Returns `COLOR_0` as RGBA, or an empty list.
fn colors(source: &ImportSource, primitive: &json::mesh::Primitive) -> Result<Vec<Vec4>, AssetFault> {
    let Some(accessor) = attribute(source, primitive, Semantic::Colors(0))? else { return Ok(Vec::new()) };
    let colors: Vec<Vec4> = if components(accessor) == 3 {
        let rgb = source.floats::<3>(accessor, IntegerConversion::Normalized)?;
        rgb.into_iter().map(|c| Vec3::from_array(c).extend(1.0)).collect()
    } else {
        source.floats::<4>(accessor, IntegerConversion::Normalized)?.into_iter().map(Vec4::from_array).collect()
    };
    Ok(colors.into_iter().map(|c| c.clamp(Vec4::ZERO, Vec4::ONE)).collect())
}

/// Returns the accessor of an attribute, or an error if it has not one element per vertex.
fn attribute<'a>(
    source: &ImportSource<'a>,
    primitive: &json::mesh::Primitive,
    semantic: Semantic,
) -> Result<Option<&'a Accessor>, AssetFault> {
    let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).and_then(|&a| source.root.get(a));
    let accessor = find(semantic);
    let vertices = find(Semantic::Positions).map(|a| a.count);
    match accessor {
        Some(accessor) if Some(accessor.count) != vertices => Err(invalid_gltf("a mesh's attributes differ in length")),
        found => Ok(found),
    }
}

/// Splits vertices per triangle, and gives each triangle its geometric normal.
fn faceted(shared: &Primitive) -> Primitive {
    let corners = || shared.indices.iter().map(|&i| i as usize);
    let positions: Vec<Vec3> = corners().map(|i| shared.positions[i]).collect();
    let (triangles, _) = positions.as_chunks::<3>();
    let normals = triangles.iter().flat_map(|&[a, b, c]| [normal(a, b, c); 3]).collect();
    // Empty lists stay empty.
    let uvs = corners().filter_map(|i| shared.uvs.get(i).copied()).collect();
    let colors = corners().filter_map(|i| shared.colors.get(i).copied()).collect();
    let indices = (0..positions.len() as u32).collect();
    Primitive { positions, normals, uvs, colors, indices, material: shared.material }
}

/// Returns the unit normal of a triangle, counterclockwise seen from outside; +Y if its area is zero.
fn normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a).normalize_or(glam::DVec3::Y).as_vec3()
}

/// Normalizes a stored normal in f64, because an f32 length may overflow or underflow. Returns +Y for zero.
fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().normalize_or(glam::DVec3::Y).as_vec3()
}

fn list(order: &[u32]) -> Vec<u32> {
    order[..order.len() / 3 * 3].to_vec()
}

/// Converts a strip to triangles. Every second triangle is reversed, so that all have the same winding (glTF
/// 2.0, section 3.7.2.1).
fn strip(order: &[u32]) -> Vec<u32> {
    let turn = |(i, t): (usize, &[u32])| [t[0], t[1 + i % 2], t[2 - i % 2]];
    order.windows(3).enumerate().flat_map(turn).collect()
}

fn fan(order: &[u32]) -> Vec<u32> {
    let Some((&hub, rim)) = order.split_first() else { return Vec::new() };
    rim.windows(2).flat_map(|t| [t[0], t[1], hub]).collect()
}
