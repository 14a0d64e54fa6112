//! Tests that the faces contain every caster in the light.

use glam::DQuat;
use light::Light;
use light::parameters::CONE_ANGLE;

use super::*;
use crate::casters::of_opaque;
use crate::straight::cover::FittedFace;

/// Vectors for points and lights, the same in every run.
fn vector(k: usize) -> DVec3 {
    let k = k as f64 + 1.0;
    DVec3::new(k * 0.754_877_666, k * 0.569_840_29, k * 0.362_3).fract() * 2.0 - 1.0
}

/// Returns the face of a position in light space, and x / depth, y / depth and depth there.
fn on_face(faces: &[PerspectiveFace], position: DVec3) -> (usize, DVec3) {
    let on = |face: &PerspectiveFace| face.axes * position;
    let aside = |p: DVec3| p.x.abs().max(p.y.abs()) / p.z;
    let ahead = faces.iter().enumerate().filter(|(_, face)| on(face).z > 0.0);
    let (index, face) = ahead.min_by(|(_, a), (_, b)| aside(on(a)).total_cmp(&aside(on(b)))).expect("a face");
    let p = on(face);
    (index, DVec3::new(p.x / p.z, p.y / p.z, p.z))
}

/// True if a face, its size times `share`, contains a position with a margin of two texels.
fn shows(fitted: &PerspectiveFit, side: f64, position: DVec3, share: f64) -> bool {
    let (index, p) = on_face(&fitted.faces, position);
    let FittedFace { center, half, has_casters } = fitted.faces[index].fitted;
    let margin = half * 2.0 * MARGIN_TEXELS / side - 1e-9;
    has_casters
        && ((p.truncate() - center).abs() + margin).cmple(half * share).all()
        && p.z >= fitted.nearest * (1.0 - 1e-9)
}

#[test]
fn faces_contain_all_casters() {
    let (side, mut checked, mut empty, mut caught) = (1024.0, 0, 0, 0);
    for k in 0..180 {
        let light = Light::spot().with(CONE_ANGLE, 10.0 + 79.9 * (k as f64 / 180.0));
        let rotation = DQuat::from_scaled_axis(vector(k) * 3.0);
        let light_from_scene = DAffine3::from_rotation_translation(rotation, vector(k + 100) * 2.0);
        let scene_from_light = light_from_scene.inverse();
        // Most of them are ahead.
        let lump = |lump| {
            let middle = scene_from_light.transform_point3(vector(k + 200 + 17 * lump) * 2.0 - DVec3::Z);
            let size = 0.02 + 0.4 * vector(k + lump).x.abs();
            (0..300).map(move |i| (middle + vector(i) * size).as_vec3().to_array())
        };
        let positions: Vec<[f32; 3]> = (0..=k % 3).flat_map(lump).collect();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let clusters = of_opaque(&positions, &indices);
        let fitted = fit_faces(&light, side, light_from_scene, &clusters);
        let tan_outer = libm::tan(light.get(CONE_ANGLE).to_radians());
        let inside = |p: &DVec3| p.truncate().length() <= -p.z * tan_outer && p.z < -1e-9;
        let in_light: Vec<_> = positions
            .as_chunks::<3>()
            .0
            .iter()
            .flat_map(|corners| {
                let [a, b, c] = corners.map(|p| light_from_scene.transform_point3(glam::Vec3::from(p).as_dvec3()));
                [a, b, c, (a + b) / 2.0, (a + b + c) / 3.0]
            })
            .filter(inside)
            .collect();
        for &position in &in_light {
            assert!(shows(&fitted, side, position, 1.0), "{position} of light {k} is not in {fitted:?}");
        }
        checked += in_light.len();
        empty += usize::from(fitted.nearest == f64::INFINITY);
        // Deliberate fault that the check must detect: faces that are slightly too small.
        caught += usize::from(in_light.iter().any(|&position| !shows(&fitted, side, position, 0.9)));
    }
    assert!(checked > 3000 && empty > 5, "{checked} points, {empty} lights with nothing in them");
    assert!(caught > 30, "faces that are too small are seen in only {caught} lights");
}
