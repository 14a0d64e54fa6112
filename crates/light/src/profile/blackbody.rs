//! Colour of a black body.

use glam::DVec3;

/// Kelvins between knots. The first knot is at 1000.
const STEP: f64 = 500.0;

/// Linear Rec. 709 colour of a black body every [`STEP`] kelvins from 1000 to 10000, with a largest channel of 1: the
/// numbers that UsdLux states, computed from the CIE 1931 observer.
const KNOTS: [[f64; 3]; 19] = [
    [1.0, 0.027_490, 0.0],
    [1.0, 0.149_664, 0.0],
    [1.0, 0.256_644, 0.008_095],
    [1.0, 0.372_033, 0.067_450],
    [1.0, 0.476_725, 0.153_601],
    [1.0, 0.570_376, 0.259_196],
    [1.0, 0.653_480, 0.377_155],
    [1.0, 0.726_878, 0.501_606],
    [1.0, 0.791_543, 0.628_050],
    [1.0, 0.848_462, 0.753_228],
    [1.0, 0.898_581, 0.874_905],
    [1.0, 0.942_771, 0.991_642],
    [0.906_947, 0.890_456, 1.0],
    [0.828_247, 0.841_838, 1.0],
    [0.765_791, 0.801_896, 1.0],
    [0.715_255, 0.768_579, 1.0],
    [0.673_683, 0.740_423, 1.0],
    [0.638_992, 0.716_359, 1.0],
    [0.609_681, 0.695_588, 1.0],
];

/// Rec. 709 luminance of linear RGB.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Computes the linear RGB of a black body at `kelvin`, with luminance 1, as white has: UsdLux's fit, a Catmull-Rom
/// spline through knots every 500 K. It is constant below 1000 K and above 10000 K. At 6500 K it is not quite white:
/// white is daylight's colour there, not a black body's.
///
/// Near 1300 K the spline's blue is negative and counts as 0, after the luminance is taken.
pub fn blackbody(kelvin: f64) -> DVec3 {
    let last = KNOTS.len() - 1;
    let x = ((kelvin - 1000.0) / STEP).clamp(0.0, last as f64);
    let segment = (x as usize).min(last - 1);
    let u = x - segment as f64;
    // The end knots are doubled.
    let knot = |index: usize| DVec3::from_array(KNOTS[index.saturating_sub(1).min(last)]);
    let [k0, k1, k2, k3] = [0, 1, 2, 3].map(|k| knot(segment + k));
    let cubic = (3.0 * (k1 - k2) + k3 - k0) * 0.5;
    let quadratic = k0 - 2.5 * k1 + 2.0 * k2 - 0.5 * k3;
    let linear = (k2 - k0) * 0.5;
    let rgb = ((cubic * u + quadratic) * u + linear) * u + k1;
    (rgb / rgb.dot(LUMINANCE)).max(DVec3::ZERO)
}
