//! Compares the radiance of textured surfaces with the reference.

use bench::compare::{ComparisonSubject, ExpectedPicture, RenderedSubject};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use light::Light;
use light::parameters::TRANSLATION;
use render::ShadowSettings;
use scene::{Camera, Fill, Image, Material, Primitive, Sampler, Scene, TextureRef, View};

use crate::boxes::{add_mesh, camera};
use crate::pictures::{alone, renderer};

const SIDE: u32 = 32;

/// A picture of noise, with bytes from `least` up.
fn picture(least: u32) -> Image {
    let mut state = 1_u32;
    let byte = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (least + (state >> 16) % (256 - least)) as u8
    };
    Image { width: SIDE, height: SIDE, rgba8: (0..4 * SIDE * SIDE).map(byte).collect() }
}

/// A picture of texels that are either black or white.
fn black_and_white() -> Image {
    let picture = picture(0);
    Image { rgba8: picture.rgba8.iter().map(|byte| if *byte < 128 { 0 } else { 255 }).collect(), ..picture }
}

/// A wall of 2 by 2 units that faces the camera, with uv from `start` on.
fn wall(image: Image, sampler: Sampler, start: Vec2) -> Scene {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let wall = Primitive {
        positions: corners.map(|(x, y)| Vec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, 0.0)).into(),
        normals: vec![Vec3::Z; 4],
        uvs: corners.map(|(x, y)| start + Vec2::new(x, 1.0 - y)).into(),
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    };
    let material =
        Material { base_color_texture: Some(TextureRef { image: 0, sampler }), roughness: 0.7, ..Material::default() };
    let fill = Fill { sky: DVec3::ZERO, ground: DVec3::ZERO };
    let mut scene = Scene { materials: vec![material], images: vec![image], fill, ..Scene::default() };
    add_mesh(&mut scene, DAffine3::IDENTITY, vec![wall]);
    scene
}

/// About eight pixels per texel.
fn view() -> View {
    let camera = camera([0.1, 0.05, 2.0], [0.1, 0.05, 0.0], 0.8);
    View::beauty(Camera { rotation: DQuat::from_rotation_z(0.1), ..camera }, [240, 220])
}

/// Light from the front, wide enough for the whole wall.
fn light() -> Light {
    let points = [0.0, 1.5, 3.0, 4.5].map(|z| DVec3::new(0.0, 0.0, -z));
    Light::bendy(points.into(), vec![0.5, 2.0, 4.0, 5.0]).with(TRANSLATION, DVec3::new(0.2, 0.3, 3.0))
}

/// Error of the radiance in the picture of `drawn`, as a picture of `scene`, relative to its root mean square.
fn error(scene: &Scene, drawn: &Scene) -> f64 {
    let subject = ComparisonSubject::new("wall", scene.clone(), light(), view());
    let mut renderer = renderer();
    renderer.set_scene(&scene::pose(drawn.clone(), 0.0)).expect("the scene fits");
    let drawn = RenderedSubject::under(&mut renderer, &subject, &alone(&light()), ShadowSettings::default());
    let expected = ExpectedPicture::new(&subject, || {}).expect("the light is valid");
    let found = expected.compare(&drawn.expect("it can be drawn"));
    assert!(found.in_light > found.pixels * 9 / 10 && found.pixels > 40_000, "{found:?}");
    found.radiance_rmse
}

/// Colors are packed by their square roots `r` in steps of 1 / 8191. Rounding has an average error of
/// `2 r sqrt(1 / 12) / 8191`. Relative to `r^2` that is 7e-5 of white, and 2e-4 of bytes of 100, which are 0.13 of
/// white; in a picture of many values they are weighted by brightness.
const ERROR: f64 = 2e-4;

#[test]
fn textured_surfaces_have_their_radiance() {
    let (blended, nearest) = (Sampler::default(), Sampler { nearest: true, ..Sampler::default() });
    let grey = |byte: u8| Image { rgba8: vec![byte; 4 * (SIDE * SIDE) as usize], ..picture(0) };
    for (name, image, sampler) in [
        ("white", grey(255), blended),
        ("grey", grey(100), blended),
        ("texels", picture(0), nearest),
        ("black and white", black_and_white(), blended),
        ("colours", picture(0), blended),
        ("alike", picture(200), blended),
    ] {
        let scene = wall(image, sampler, Vec2::ZERO);
        let found = error(&scene, &scene);
        println!("{name}: {found:.2e}");
        assert!(found <= ERROR, "{name}: {found:.2e}");
    }
    // The planted faults: uv displaced by half a step of 1/256 of a texel, the average error of samplers that truncate;
    // and bytes off by one, about the error of decoding dark ones by a cubic polynomial.
    let scene = wall(picture(0), blended, Vec2::ZERO);
    let stepped = error(&scene, &wall(picture(0), blended, Vec2::splat(0.5 / 256.0 / SIDE as f32)));
    let rgba8 = picture(0).rgba8.into_iter().map(|byte| byte ^ 1).collect();
    let decoded = error(&scene, &wall(Image { rgba8, ..picture(0) }, blended, Vec2::ZERO));
    println!("uv in steps: {stepped:.2e}, bytes off by one: {decoded:.2e}");
    assert!(stepped > 2.0 * ERROR && decoded > 2.0 * ERROR, "{stepped:.2e}, {decoded:.2e}");
}
