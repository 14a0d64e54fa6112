//! The same picture both ways, and how they differ.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use assets::LoadedScene;
use light::{Light, LightInstance};
use render::{Backend, Gpu, MemoryBudget, Renderer, ShadowSettings};
use scene::{Aov, PosedScene, View};

/// Pixels of each picture: none of its sides is a multiple of four, so that blocks of pixels reach beyond them.
pub const SIZE: [u32; 2] = [343, 191];
/// Pixels beside an edge that a filter of four texels may reach.
const BESIDE: usize = 2;

/// One renderer a way, and the scene that both have.
struct BothRenderers {
    wgpu: Renderer,
    native: Renderer,
    scene: Option<Arc<PosedScene>>,
}

static BOTH: LazyLock<Mutex<BothRenderers>> = LazyLock::new(|| {
    let [wgpu, native] = [Backend::Wgpu, Backend::Native].map(renderer_of);
    Mutex::new(BothRenderers { wgpu, native, scene: None })
});

/// A renderer on a device of its own whose lights `backend` draws.
pub fn renderer_of(backend: Backend) -> Renderer {
    let gpu = Gpu::open(MemoryBudget::default(), Some(backend)).expect("tests need a graphics driver");
    Renderer::new(Arc::new(gpu)).expect("the device works")
}

/// The light alone, as a renderer takes it.
pub fn instances(light: &Light) -> Vec<LightInstance> {
    LightInstance::numbered(vec![light.clone()]).expect("a light")
}

/// The demo of that name.
pub fn demo(name: &str) -> LoadedScene {
    assets::demo(name).expect("it is one of the demos")
}

/// Where and how a comparison looks.
#[derive(Clone)]
pub struct ViewedScene {
    pub scene: Arc<PosedScene>,
    pub view: View,
    pub shadows: ShadowSettings,
}

impl ViewedScene {
    /// At a scene by its own camera.
    pub fn at(loaded: &LoadedScene) -> Self {
        let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
        Self { scene: scene::pose(loaded.scene.clone()), view, shadows: ShadowSettings::default() }
    }

    /// Does `work` with both renderers, which have the scene and the settings.
    fn with<T>(&self, work: impl FnOnce(&mut BothRenderers) -> T) -> T {
        let mut both = BOTH.lock().unwrap_or_else(PoisonError::into_inner);
        let is_other = both.scene.take().is_none_or(|scene| !Arc::ptr_eq(&scene, &self.scene));
        let BothRenderers { wgpu, native, .. } = &mut *both;
        for renderer in [wgpu, native] {
            renderer.set_shadow_settings(self.shadows).expect("they are sound");
            if is_other {
                renderer.set_scene(&self.scene).expect("the scene fits");
            }
        }
        both.scene = Some(Arc::clone(&self.scene));
        work(&mut both)
    }

    fn shown(&self, renderer: &mut Renderer, lights: &[LightInstance]) -> Vec<u8> {
        renderer.render_display(&self.view, lights).expect("it can be drawn")
    }

    /// Which pixels have one of another visibility beside them.
    fn edges(&self, renderer: &mut Renderer, light: &Light) -> Vec<bool> {
        let view = View { aov: Aov::Visibility, ..self.view.clone() };
        let picture = renderer.render(&view, &instances(light)).expect("it can be drawn");
        let [width, height] = SIZE.map(|side| side as usize);
        let is_beside_another = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let columns = x.saturating_sub(BESIDE)..(x + BESIDE + 1).min(width);
            let mut around = (y.saturating_sub(BESIDE)..(y + BESIDE + 1).min(height))
                .flat_map(|y| columns.clone().map(move |x| y * width + x));
            around.any(|other| picture.pixels[other] != picture.pixels[pixel])
        };
        (0..width * height).map(is_beside_another).collect()
    }
}

/// What the two ways show of a light, in pixels.
#[derive(Debug, PartialEq, Eq)]
pub struct Compared {
    /// Those that the light changes.
    lit: usize,
    /// Those near an edge of a shadow or of the light.
    edges: usize,
    /// Those near an edge that differ by more than 1 of 255.
    beside: usize,
    /// Those elsewhere that do.
    away: usize,
}

impl Compared {
    /// What is wrong with it, or nothing.
    ///
    /// Roundings apart, both compute the same, so that of 255 steps they may differ by one. At an edge a texel of the map may
    /// have another triangle: both rasterisers move corners to 1/256 of a texel, from places that differ in their last bits,
    /// some 1/1000 of a texel of maps thousands of texels wide. A corner that lies so near to where rounding turns is moved the
    /// other way: one coordinate in some thousand, and then one of hundreds of centres changes sides. One pixel in a thousand
    /// is more than was ever seen.
    pub fn fault(&self) -> Option<&'static str> {
        if self.lit < 1000 {
            return Some("little to see");
        }
        if self.away > 0 {
            return Some("they differ far from edges of shadows");
        }
        (self.beside > 1 + self.edges / 1000).then_some("they differ in many places at edges of shadows")
    }
}

/// Compares `native` as the processor shows it with `wgpu` as the device does, which but for planted faults is the
/// same.
pub fn compared(looked: &ViewedScene, wgpu: &Light, native: &Light) -> Compared {
    let (of_processor, dark, of_device, edges) = looked.with(|both| {
        let of_processor = looked.shown(&mut both.native, &instances(native));
        let dark = looked.shown(&mut both.wgpu, &[]);
        let of_device = looked.shown(&mut both.wgpu, &instances(wgpu));
        (of_processor, dark, of_device, looked.edges(&mut both.wgpu, wgpu))
    });
    let mut compared = Compared { lit: 0, edges: 0, beside: 0, away: 0 };
    let [dark, of_device, of_processor] =
        [&dark, &of_device, &of_processor].map(|bytes| bytes.as_chunks::<4>().0);
    for (pixel, is_edge) in edges.into_iter().enumerate() {
        let (a, b) = (of_device[pixel], of_processor[pixel]);
        let differs = a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 1);
        compared.lit += usize::from(a != dark[pixel]);
        compared.edges += usize::from(is_edge);
        compared.beside += usize::from(differs && is_edge);
        compared.away += usize::from(differs && !is_edge);
    }
    compared
}

/// Holds both pictures of a light to each other.
pub fn assert_the_same(name: &str, looked: &ViewedScene, light: &Light) {
    let compared = compared(looked, light, light);
    println!("{name}: {compared:?}");
    assert_eq!(compared.fault(), None, "{name}: {compared:?}");
}

/// How many pixels change by more than 1 of 255 on the device where it draws `light` in place of `other`: whether what they
/// differ by is in the picture at all.
pub fn differing_pixels(looked: &ViewedScene, light: &Light, other: &Light) -> usize {
    let [a, b] =
        looked.with(|both| [light, other].map(|light| looked.shown(&mut both.wgpu, &instances(light))));
    let pixels = a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0);
    pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count()
}
