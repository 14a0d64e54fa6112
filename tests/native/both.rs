//! Draws a picture with both backends and compares them.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use assets::LoadedScene;
use light::parameters::{CROSS_SECTION, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH};
use light::{CrossSection, Light, LightInstance};
use render::{Backend, Renderer, ShadowSettings};
use scene::{Aov, PosedScene, View};

use crate::pictures::{alone, around, renderer_of};

/// Size of each picture: no side is a multiple of four, so that blocks of pixels extend beyond the picture.
pub const SIZE: [u32; 2] = [343, 191];
/// Distance in pixels from an edge that a filter of four texels can affect.
const BESIDE: usize = 2;

/// One renderer per backend, and the scene that both have.
struct BothRenderers {
    wgpu: Renderer,
    native: Renderer,
    scene: Option<Arc<PosedScene>>,
}

static BOTH: LazyLock<Mutex<BothRenderers>> = LazyLock::new(|| {
    let [wgpu, native] = [Backend::Wgpu, Backend::Native].map(renderer_of);
    Mutex::new(BothRenderers { wgpu, native, scene: None })
});

pub fn demo(name: &str) -> LoadedScene {
    assets::demo(name).expect("it is one of the demos")
}

/// Scene, view and settings of a comparison.
#[derive(Clone)]
pub struct ViewedScene {
    pub scene: Arc<PosedScene>,
    pub view: View,
    pub shadows: ShadowSettings,
}

impl ViewedScene {
    /// View of a scene by its own camera.
    pub fn at(loaded: &LoadedScene) -> Self {
        let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
        Self { scene: scene::pose(loaded.scene.clone(), 0.0), view, shadows: ShadowSettings::default() }
    }

    /// Calls `work` with both renderers, which have the scene and the settings.
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

    /// Returns the raw values of `view`, by wgpu under the first light and by the native backend under the second.
    pub fn raw(&self, view: &View, [wgpu, native]: [&Light; 2]) -> [Vec<[f32; 4]>; 2] {
        self.with(|both| {
            let of_device = both.wgpu.render(view, &alone(wgpu)).expect("it can be drawn");
            let of_processor = both.native.render(view, &alone(native)).expect("it can be drawn");
            [of_device.pixels, of_processor.pixels]
        })
    }

    /// Marks the pixels beside which another depth or normal begins.
    fn surface_edges(&self, renderer: &mut Renderer) -> Vec<bool> {
        let [depth, normal] = [Aov::Depth, Aov::Normal]
            .map(|aov| renderer.render(&View { aov, ..self.view.clone() }, &[]).expect("it can be drawn").pixels);
        let differ = |a: usize, b: usize| {
            let turned = (0..3).any(|k| (normal[a][k] - normal[b][k]).abs() > 0.02);
            turned || (depth[a][0] - depth[b][0]).abs() > 0.01 * depth[a][0].min(depth[b][0])
        };
        (0..depth.len()).map(|pixel| around(pixel, SIZE, 1).any(|other| differ(pixel, other))).collect()
    }

    /// Marks the pixels that have a different visibility within `BESIDE` pixels.
    fn edges(&self, renderer: &mut Renderer, light: &Light) -> Vec<bool> {
        let view = View { aov: Aov::Visibility, ..self.view.clone() };
        let picture = renderer.render(&view, &alone(light)).expect("it can be drawn");
        let is_beside_another =
            |pixel: usize| around(pixel, SIZE, BESIDE).any(|other| picture.pixels[other] != picture.pixels[pixel]);
        (0..picture.pixels.len()).map(is_beside_another).collect()
    }
}

/// Numbers of pixels in a comparison of both backends.
#[derive(Debug, PartialEq, Eq)]
pub struct Compared {
    /// Pixels that the light changes.
    lit: usize,
    /// Pixels near an edge of a shadow or of the light.
    edges: usize,
    /// Pixels near an edge that differ by more than 1 of 255.
    beside: usize,
    /// Pixels at an edge of a surface.
    surface_edges: usize,
    /// Pixels at an edge of a surface that differ.
    moved: usize,
    /// Other pixels that differ by more than 1 of 255.
    away: usize,
}

impl Compared {
    /// Returns the fault, if any.
    ///
    /// Both compute the same up to rounding, so values may differ by one of 255 steps. At an edge, a texel of the map
    /// may have a different triangle. Both rasterizers snap corners to 1/256 of a texel, from positions that differ in
    /// their last bits, some 1/1000 of a texel for maps thousands of texels wide. A corner that close to the middle
    /// between two steps snaps the other way: this happens to one coordinate in some thousand, and then one of hundreds
    /// of texel centers changes sides. One pixel in a thousand is more than was ever measured.
    ///
    /// Each backend rasterizes the surfaces by itself, with the same roundings at their edges. A level edge between two
    /// steps changes sides all along a row of pixels: a pixel in a hundred.
    pub fn fault(&self) -> Option<&'static str> {
        if self.lit < 1000 {
            return Some("little to see");
        }
        if self.away > 0 {
            return Some("they differ far from edges of shadows");
        }
        if self.moved > 1 + self.surface_edges / 100 {
            return Some("edges of surfaces lie elsewhere");
        }
        (self.beside > 1 + self.edges / 1000).then_some("they differ in many places at edges of shadows")
    }
}

/// Compares the picture of `native` by the CPU with that of `wgpu` by the GPU. Both lights are the same except for
/// planted faults.
pub fn compared(looked: &ViewedScene, wgpu: &Light, native: &Light) -> Compared {
    compared_from(looked, &looked.view, wgpu, native)
}

/// Compares like [`compared`]; the CPU draws what `native_view` shows.
pub fn compared_from(looked: &ViewedScene, native_view: &View, wgpu: &Light, native: &Light) -> Compared {
    let (of_processor, dark, of_device, edges, surface_edges) = looked.with(|both| {
        let of_processor = both.native.render_display(native_view, &alone(native)).expect("it can be drawn");
        let dark = looked.shown(&mut both.wgpu, &[]);
        let of_device = looked.shown(&mut both.wgpu, &alone(wgpu));
        let (edges, surface_edges) = (looked.edges(&mut both.wgpu, wgpu), looked.surface_edges(&mut both.wgpu));
        (of_processor, dark, of_device, edges, surface_edges)
    });
    let mut compared = Compared { lit: 0, edges: 0, beside: 0, surface_edges: 0, moved: 0, away: 0 };
    let [dark, of_device, of_processor] = [&dark, &of_device, &of_processor].map(|bytes| bytes.as_chunks::<4>().0);
    let differ = |a: [u8; 4], b: [u8; 4]| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 1);
    for (pixel, (is_edge, is_surface_edge)) in edges.into_iter().zip(surface_edges).enumerate() {
        let (a, b) = (of_device[pixel], of_processor[pixel]);
        let differs = differ(a, b);
        compared.surface_edges += usize::from(is_surface_edge);
        if differs && is_surface_edge {
            compared.moved += 1;
            continue;
        }
        compared.lit += usize::from(a != dark[pixel]);
        compared.edges += usize::from(is_edge);
        compared.beside += usize::from(differs && is_edge);
        compared.away += usize::from(differs && !is_edge);
    }
    compared
}

/// Tests that both pictures of a light agree.
pub fn assert_the_same(name: &str, looked: &ViewedScene, light: &Light) {
    let compared = compared(looked, light, light);
    println!("{name}: {compared:?}");
    assert_eq!(compared.fault(), None, "{name}: {compared:?}");
}

/// Tests that both pictures of `light` agree, and that it differs visibly from `plain`, which is what ignoring its
/// parameter would show.
pub fn assert_same_and_visible(name: &str, looked: &ViewedScene, plain: &Light, light: &Light) {
    assert_the_same(name, looked, light);
    let changed = differing_pixels(looked, plain, light);
    assert!(changed > 100, "{name}: dropping it goes unseen but for {changed} pixels");
}

/// A light with a superellipse as its cross-section.
pub fn with_superellipse(light: Light, width: f64, height: f64, roundness: f64) -> Light {
    let light = light.with(CROSS_SECTION, CrossSection::Superellipse).with(SECTION_ROUNDNESS, roundness);
    light.with(SECTION_WIDTH, width).with(SECTION_HEIGHT, height)
}

/// Number of pixels that change by more than 1 of 255 on the GPU if it draws `light` instead of `other`. It shows that
/// their difference is visible at all.
pub fn differing_pixels(looked: &ViewedScene, light: &Light, other: &Light) -> usize {
    let [a, b] = looked.with(|both| [light, other].map(|light| looked.shown(&mut both.wgpu, &alone(light))));
    let pixels = a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0);
    pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count()
}
