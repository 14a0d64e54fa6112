//! Renderers, lights and files for tests of pictures, and the pixels in which a picture differs from the reference.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use bench::compare::{Comparison, ComparisonSubject, ExpectedPicture, RenderedSubject};
use glam::DVec3;
use light::{Light, LightInstance};
use render::{Backend, Culling, Device, Host, Picture, Renderer};
use scene::{PosedScene, View};

/// Makes a renderer with the backend that suits the device.
pub fn renderer() -> Renderer {
    static FIRST: OnceLock<Mutex<Renderer>> = OnceLock::new();
    with_same_pipelines(&FIRST, None)
}

/// Makes a renderer with `backend`.
pub fn renderer_of(backend: Backend) -> Renderer {
    static FIRST: [OnceLock<Mutex<Renderer>>; 2] = [const { OnceLock::new() }; 2];
    with_same_pipelines(&FIRST[backend as usize], Some(backend))
}

/// Makes a renderer that shares the pipelines of the `first`: compiling them takes longer than drawing a picture.
fn with_same_pipelines(first: &OnceLock<Mutex<Renderer>>, backend: Option<Backend>) -> Renderer {
    let first = first.get_or_init(|| {
        let device = Device::open(Host::default(), backend).expect("tests need a graphics driver");
        Mutex::new(Renderer::new(&device).expect("the device works"))
    });
    let first = first.lock().unwrap_or_else(PoisonError::into_inner);
    first.with_same_pipelines().expect("the device works")
}

/// Lights, checked and numbered for a renderer.
pub fn instances(lights: &[Light]) -> Vec<LightInstance> {
    LightInstance::numbered(lights.iter().cloned()).expect("lights")
}

/// The light alone, checked for a renderer.
pub fn alone(light: &Light) -> Vec<LightInstance> {
    instances(std::slice::from_ref(light))
}

/// The reference's picture of a subject, kept for tests that share it: the reference takes longest.
pub fn expected(subject: ComparisonSubject) -> ExpectedPicture<'static> {
    ExpectedPicture::new(Box::leak(Box::new(subject)), || {}).expect("the light is valid")
}

/// Draws a picture with a renderer that several tests share.
pub fn draw_with(shared: &Mutex<Renderer>, scene: &Arc<PosedScene>, view: &View, lights: &[LightInstance]) -> Picture {
    let mut renderer = shared.lock().unwrap_or_else(PoisonError::into_inner);
    renderer.set_scene(scene).expect("it fits");
    renderer.render(view, lights).expect("it can be drawn")
}

/// Path in the folder of assets beside the checkout. Tests that need it are ignored by default.
pub fn shared_asset(path: &str) -> PathBuf {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets")).join(path);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

/// Size of pictures that are compared: that of the environment variable `BENDYLIGHTS_ACCURACY_SIZE`, or `default`.
pub fn compared_size(default: [u32; 2]) -> [u32; 2] {
    let Ok(size) = std::env::var("BENDYLIGHTS_ACCURACY_SIZE") else { return default };
    let (width, height) = size.split_once('x').expect("the size is written WIDTHxHEIGHT");
    [width, height].map(|side| side.parse().expect("a side is a number of pixels"))
}

/// Each kind of culling turned off, and all of them.
pub fn reduced_culling() -> [(&'static str, Culling); 5] {
    let on = Culling::ALL;
    [
        ("clusters", Culling { clusters: false, ..on }),
        ("backs", Culling { backs: false, ..on }),
        ("sides", Culling { sides: false, ..on }),
        ("pixels", Culling { pixels: false, ..on }),
        ("all", Culling::NONE),
    ]
}

/// Pixels of a picture that are compared, by their visibility in the reference.
#[derive(Default)]
pub struct ComparedPixels {
    pub lit: Vec<usize>,
    pub dark: Vec<usize>,
}

impl ComparedPixels {
    pub fn push(&mut self, pixel: usize, is_lit: bool) {
        if is_lit { &mut self.lit } else { &mut self.dark }.push(pixel);
    }

    pub fn count(&self) -> usize {
        self.lit.len() + self.dark.len()
    }

    /// Pixels that have another visibility in `picture`.
    pub fn wrong(&self, picture: &Picture) -> Vec<usize> {
        let differs = |pixel: usize, visibility: f32| picture.pixels[pixel][0] != visibility;
        let dark = self.lit.iter().filter(|&&pixel| differs(pixel, 1.0));
        dark.chain(self.dark.iter().filter(|&&pixel| differs(pixel, 0.0))).copied().collect()
    }
}

/// Pixels at most `reach` columns and rows away from a pixel, that pixel included.
pub fn around(pixel: usize, size: [u32; 2], reach: usize) -> impl Iterator<Item = usize> {
    let [width, height] = size.map(|side| side as usize);
    let near = move |at: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
    near(pixel / width, height).flat_map(move |y| near(pixel % width, width).map(move |x| y * width + x))
}

/// Root mean square error of a picture's radiance, relative to that of the expected one, and the number of compared
/// pixels: those with an expected radiance.
pub struct PictureError {
    pub relative_rmse: f64,
    pub compared: usize,
}

impl PictureError {
    pub fn new(picture: &Picture, expected: impl IntoIterator<Item = Option<DVec3>>) -> Self {
        let (mut error2, mut expected2, mut compared) = (0.0, 0.0, 0);
        for ([r, g, b, _], expected) in picture.pixels.iter().map(|pixel| pixel.map(f64::from)).zip(expected) {
            let Some(expected) = expected else { continue };
            error2 += (DVec3::new(r, g, b) - expected).length_squared();
            expected2 += expected.length_squared();
            compared += 1;
        }
        let relative_rmse = if error2 == 0.0 { 0.0 } else { (error2 / expected2).sqrt() };
        Self { relative_rmse, compared }
    }
}

/// Saves the panels of a comparison in `BENDYLIGHTS_ACCURACY_PICTURES`, if that is set.
pub fn save_panels(name: &str, expected: &ExpectedPicture, drawn: &RenderedSubject, comparison: &Comparison) {
    if let Ok(folder) = std::env::var("BENDYLIGHTS_ACCURACY_PICTURES") {
        let file = Path::new(&folder).join(format!("{name}.png"));
        expected.panels(drawn, comparison).save(file).expect("the picture can be written");
    }
}

/// Saves a picture in `BENDYLIGHTS_SHADOW_PICTURES`, if that is set, with its `marks` in red.
pub fn save_picture(name: &str, picture: &Picture, marks: &[usize], color: impl Fn(&[f32; 4]) -> [u8; 3]) {
    let Ok(folder) = std::env::var("BENDYLIGHTS_SHADOW_PICTURES") else { return };
    let mut image = image::RgbImage::new(picture.width, picture.height);
    for (k, (pixel, value)) in image.pixels_mut().zip(&picture.pixels).enumerate() {
        *pixel = image::Rgb(if marks.contains(&k) { [255, 0, 0] } else { color(value) });
    }
    image.save(Path::new(&folder).join(format!("{name}.png"))).expect("the picture can be written");
}
