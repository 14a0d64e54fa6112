//! Tests of the share of the scene's fill in a picture.

use glam::DVec3;
use light::LightInstance;
use render::{Aov, Picture, RenderError, Renderer, View};
use scene::{Fill, Material};

use crate::support::{EPS, floor, picture, renderer, scene_of, spot, view};

const SKY: DVec3 = DVec3::new(0.10, 0.115, 0.145);

/// Returns a white floor that is 3 wide, under a light that reaches a disc of it 0.9 wide.
fn lit_in_the_middle(fills: &[f64]) -> Vec<Picture> {
    let mut scene = scene_of([floor(1.5, 0.0)], vec![Material::default()]);
    scene.fill = Fill { sky: SKY, ground: DVec3::ZERO };
    let lights = [spot(DVec3::Y, DVec3::ZERO)];
    let view = view(DVec3::new(0.0, 5.0, 0.01), DVec3::ZERO, [60, 40], Aov::Beauty);
    fills.iter().map(|&fill| picture(&scene, &View { fill, samples: 2, ..view.clone() }, &lights)).collect()
}

#[test]
fn without_fill_nothing_is_left_where_no_light_reaches() {
    let pictures = lit_in_the_middle(&[0.0, 1.0, 2.5]);
    let [none, whole, more] = &pictures[..] else { panic!("three pictures") };
    assert_eq!(none.pixels.iter().map(|p| p[3]).sum::<f32>(), whole.pixels.iter().map(|p| p[3]).sum::<f32>());
    let (mut dark, mut lit) = (0, 0);
    for ((none, whole), more) in none.pixels.iter().zip(&whole.pixels).zip(&more.pixels) {
        let [alone, whole, more] = [none, whole, more].map(|[r, g, b, _]| DVec3::new(*r as f64, *g as f64, *b as f64));
        let covered = f64::from(none[3]);
        (dark, lit) = (dark + u32::from(covered == 1.0 && alone == DVec3::ZERO), lit + u32::from(alone.x > 0.0));
        // A white floor that faces up returns the sky's light. A pixel is a sum of two samples of fill and light, each
        // rounded at most four times.
        let fits = |picture: DVec3, factor: f64| {
            let expected = alone + SKY * factor * covered;
            (picture - expected).abs().cmple(expected * (8.0 * EPS)).all()
        };
        assert!(fits(whole, 1.0) && fits(more, 2.5), "{alone} {whole} {more}");
        // Deliberate fault that the check must detect: another share of the fill.
        assert!(covered == 0.0 || !fits(more, 2.4), "{alone} {more}");
    }
    assert!(dark > 500 && lit > 40, "{dark} {lit}");
}

#[test]
fn a_factor_that_is_none_is_refused() {
    let scene = scene_of([floor(1.0, 0.0)], vec![Material::default()]);
    let mut renderer: Renderer = renderer(&scene);
    let view = view(DVec3::Y * 2.0, DVec3::ZERO, [3, 3], Aov::Beauty);
    let none: &[LightInstance] = &[];
    for fill in [-0.1, 1.1e6, f64::NAN, f64::INFINITY] {
        let refused = renderer.render(&View { fill, ..view.clone() }, none);
        assert!(matches!(refused, Err(RenderError::InvalidView(_))), "{fill}: {refused:?}");
    }
    assert!(renderer.render(&View { fill: 1e6, ..view }, none).is_ok());
}
