//! The light model as a library: a spotlight is bent, a control point moved, and points of the world are located in it.
//!
//!     cargo run --example bend -p light

use glam::DVec3;
use light::parameters::{CONE_ANGLE, INTENSITY, RANGE, TRANSLATION};
use light::{CheckedLight, Light, LightError, bend};

fn main() -> Result<(), LightError> {
    // It stands at the origin of the world and shines along -Z.
    let spot = Light::spot()
        .with(TRANSLATION, DVec3::new(0.0, 2.0, 0.0))
        .with(RANGE, Some(8.0))
        .with(CONE_ANGLE, 20.0)
        .with(INTENSITY, 60.0);
    let straight = bend(&spot, 3)?;
    let bent = straight.clone().map_point(3, |point| point.position.x += 1.0);

    for light in [straight, bent] {
        let light = CheckedLight::new(light)?;
        let tube = light.tube().expect("a BendyLight has a tube");
        for z in [-2.0, -4.0, -6.0] {
            let location = tube.locate(DVec3::new(0.5, 2.0, z));
            match location.point {
                Some(point) => println!("z {z}: t {:.3}, v {:.3}, w {:.3}", point.t, point.v, point.w),
                None => println!("z {z}: outside"),
            }
        }
    }
    Ok(())
}
