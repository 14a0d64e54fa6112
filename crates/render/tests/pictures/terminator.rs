//! Tests of grazing light on a smooth mesh of few facets.

use glam::{DAffine3, DVec3, Vec3};
use light::Light;
use light::parameters::DIRECTION;
use render::{Aov, Picture};
use scene::{Material, Scene};

use crate::support::{ball, picture, scene_of, spot, view};

fn drawn(scene: &Scene, light: &Light, aov: Aov) -> Picture {
    let seen = view(DVec3::new(0.5, 1.0, 4.0), DVec3::ZERO, [160, 120], aov);
    picture(scene, &seen, std::slice::from_ref(light))
}

/// Returns the number of wrong pixels in the light: lit although their normal faces away, or dark although it faces the
/// light, by more than a cosine of `margin`. Also the number of all pixels in the light.
fn wrong(scene: &Scene, light: &Light, margin: f64) -> (usize, usize) {
    let [visibility, normal, direction] =
        [Aov::Visibility, Aov::Normal, Aov::Direction].map(|aov| drawn(scene, light, aov));
    let in_light: Vec<_> = (0..visibility.pixels.len()).filter(|&pixel| visibility.pixels[pixel][3] == 1.0).collect();
    let vector = |picture: &Picture, pixel: usize| {
        let [x, y, z, _] = picture.pixels[pixel].map(f64::from);
        DVec3::new(x, y, z)
    };
    let is_wrong = |pixel: &&usize| {
        let facing = vector(&normal, **pixel).dot(vector(&direction, **pixel));
        let share = visibility.pixels[**pixel][0];
        (facing > margin && share < 1.0) || (facing < -margin && share > 0.0)
    };
    (in_light.iter().filter(is_wrong).count(), in_light.len())
}

#[test]
fn the_terminator_of_a_coarse_ball_is_smooth() {
    let key = spot(DVec3::new(5.0, 2.0, 0.5), DVec3::ZERO);
    let bent = light::bend(&key, 3).expect("valid").with(DIRECTION, light::DirectionMode::Path);
    for facets in [6, 12, 24] {
        let scene = scene_of([(ball(facets), DAffine3::IDENTITY)], vec![Material::default()]);
        for light in [&key, &bent] {
            // Normals are packed to 2^-15 per axis.
            let (wrong, in_light) = wrong(&scene, light, 1e-4);
            assert!(in_light > 2500);
            assert_eq!(wrong, 0, "{facets} facets, of {in_light}");
        }
        // Deliberate fault that the check must detect, the former behavior: the facets' own normals.
        let mut faceted = ball(facets);
        let corners: Vec<_> = faceted.indices.iter().map(|&k| faceted.positions[k as usize]).collect();
        let facet = |[a, b, c]: &[Vec3; 3]| [(*b - *a).cross(*c - *a).normalize_or_zero(); 3];
        faceted.normals = corners.as_chunks::<3>().0.iter().flat_map(facet).collect();
        faceted.indices = (0..corners.len() as u32).collect();
        faceted.positions = corners;
        let faceted = scene_of([(faceted, DAffine3::IDENTITY)], vec![Material::default()]);
        let [smooth, faceted] = [&scene, &faceted].map(|scene| drawn(scene, &key, Aov::Visibility).pixels);
        let differ = smooth.iter().zip(&faceted).filter(|(a, b)| (a[0] == 1.0) != (b[0] == 1.0)).count();
        assert!(differ > 600 / facets as usize, "{facets} facets: {differ}");
    }
}
