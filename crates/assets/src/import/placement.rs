//! Transforms of nodes: composition from parts, and reduction to rigid ones.

use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Computes `T * R * S`. A rotation of zero length is the identity.
pub fn compose(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> DAffine3 {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = DQuat::from_array(rotation.map(f64::from));
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    DAffine3::from_scale_rotation_translation(vector(scale), rotation, vector(translation))
}

/// Removes scale and shear from the transform of a camera or a light.
///
/// The direction of local Z stays, and local Y becomes orthogonal to it. If an axis has zero length, or both
/// are parallel, any axes complete the frame.
pub fn rigid(world_from_local: &DAffine3) -> DAffine3 {
    let back = world_from_local.matrix3.z_axis.normalize_or(DVec3::Z);
    let up = world_from_local.matrix3.y_axis.normalize_or(DVec3::Y).reject_from_normalized(back);
    let up = if up.length() > 1e-6 { up.normalize() } else { back.any_orthonormal_vector() };
    DAffine3 { matrix3: DMat3::from_cols(up.cross(back), up, back), translation: world_from_local.translation }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_placement_is_a_rotation_whatever_comes_in() {
        let turn = DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize();
        let scales =
            [DVec3::ONE, DVec3::new(2.0, -3.0, 0.5), DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0), DVec3::splat(1e-200)];
        for scale in scales {
            let m = rigid(&DAffine3::from_scale_rotation_translation(scale, turn, DVec3::X)).matrix3;
            assert!((m.determinant() - 1.0).abs() < 1e-12, "{scale}");
            assert!((m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{scale}");
        }
        let kept = rigid(&DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 3.0, 5.0), turn, DVec3::X));
        assert!(kept.matrix3.abs_diff_eq(DMat3::from_quat(turn), 1e-12), "scale alone changes no direction");
    }
}
