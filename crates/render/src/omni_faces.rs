//! The six faces of an omni light's shadow map: perspective pictures, each fitted to its casters.

use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4};

use crate::clusters::{ClusterBounds, Clusters, MapCover, OpenSide};
use crate::gpu_structs::OMNI_FACES;
use crate::map_views::{FaceCover, FittedFace, MARGIN_TEXELS, SMALLEST_SHARE};

/// Number of faces: +x, -x, +y, -y, +z and -z in the light's axes, as in `omni_lookup.wgsl`.
pub(crate) const FACES: usize = OMNI_FACES;

#[derive(Clone, Copy, Debug)]
pub(crate) struct FittedCube {
    /// Drawn parts of the faces: distance to the right over distance ahead, and distance upwards over distance ahead.
    pub faces: [FittedFace; FACES],
    /// Least distance ahead, on its face, of any caster; infinity without casters.
    pub nearest: f64,
}

/// Returns the indices of the light axes that point right and up on a face, and the index and sign of the axis that
/// points ahead.
fn axes(index: usize) -> ([usize; 2], usize, f64) {
    let ahead = index / 2;
    ([(ahead + 1) % 3, (ahead + 2) % 3], ahead, if index.is_multiple_of(2) { 1.0 } else { -1.0 })
}

/// Returns the projection of a face with reversed depth, from `near` to infinity.
pub(crate) fn clip_from_light(index: usize, face: &FittedFace, near: f64) -> DMat4 {
    let ([right, up], ahead, sign) = axes(index);
    let mut columns = [DVec4::ZERO; 3];
    columns[right] = DVec4::new(face.half.x.recip(), 0.0, 0.0, 0.0);
    columns[up] = DVec4::new(0.0, face.half.y.recip(), 0.0, 0.0);
    let shift = -face.center / face.half;
    columns[ahead] = DVec4::new(shift.x, shift.y, 0.0, 1.0) * sign;
    let [x, y, z] = columns;
    DMat4::from_cols(x, y, z, DVec4::new(0.0, 0.0, near, 0.0))
}

/// Returns the cover of a box along the light's axes on a face with slopes up to `widest`; `None` if no part of it is
/// there.
fn cover_of_box([min, max]: [DVec3; 2], index: usize, widest: f64) -> Option<FaceCover> {
    let ([right, up], ahead, sign) = axes(index);
    let [a, b] = [min[ahead] * sign, max[ahead] * sign];
    let (nearest, farthest) = (a.min(b), a.max(b));
    // A point on the face is aside by at most `widest` times its distance ahead.
    let aside = |axis: usize| min[axis].max(-max[axis]).max(0.0) / widest;
    let nearest = nearest.max(aside(right)).max(aside(up)).max(0.0);
    if nearest > farthest || farthest <= 0.0 {
        return None;
    }
    // A slope is largest at the nearest point. A box that reaches the source covers all slopes.
    let slope = |aside: f64, over: f64, every: f64| if over > 0.0 { aside / over } else { every };
    let least = |axis: usize| slope(min[axis], if min[axis] > 0.0 { farthest } else { nearest }, -widest);
    let most = |axis: usize| slope(max[axis], if max[axis] > 0.0 { nearest } else { farthest }, widest);
    let low = DVec2::new(least(right), least(up)).max(DVec2::splat(-widest));
    let high = DVec2::new(most(right), most(up)).min(DVec2::splat(widest));
    low.cmple(high).all().then_some(FaceCover { low, high, nearest })
}

impl FittedCube {
    /// Faces of a light without a map.
    pub const NONE: Self = Self {
        faces: [FittedFace { center: DVec2::ZERO, half: DVec2::ONE, has_casters: false }; FACES],
        nearest: f64::INFINITY,
    };

    /// Fits the faces of a map, `side` texels a side, to `clusters`.
    pub fn new(light_from_scene: DAffine3, clusters: &Clusters, side: f64) -> Self {
        let source = light_from_scene.inverse().translation;
        // Light that starts inside a side of the scene's bounds leaves through it and does not return.
        let comes_in = |side: &OpenSide| side.height(source) >= 0.0;
        // Beyond its edge a face is drawn as far as the filter reads.
        let grown = side / (side - 2.0 * MARGIN_TEXELS);
        let in_light = |cluster: &ClusterBounds| {
            let m = light_from_scene.matrix3;
            let reach =
                m.x_axis.abs() * cluster.half.x + m.y_axis.abs() * cluster.half.y + m.z_axis.abs() * cluster.half.z;
            let middle = light_from_scene.transform_point3(cluster.center);
            [middle - reach, middle + reach]
        };
        let mut nearest = f64::INFINITY;
        let faces = std::array::from_fn(|index| {
            let mut cover = FaceCover::EMPTY;
            cover.extend_by_leaves(clusters.casting_trees(clusters.open_sides(comes_in)), |cluster| {
                cover_of_box(in_light(cluster), index, grown)
            });
            nearest = nearest.min(cover.nearest);
            cover.fitted([DVec2::NEG_ONE, DVec2::ONE], grown, SMALLEST_SHARE)
        });
        Self { faces, nearest }
    }
}
