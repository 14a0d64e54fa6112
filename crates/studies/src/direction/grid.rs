//! The laws over bend and taper: how far each is off the path, and how far it jumps at a joint.

use std::f64::consts::TAU;

use fastrand::Rng;
use glam::DVec3;
use light::{Light, Root, Tube};
use serde::Serialize;

use super::law::{LAWS, Law};

/// Values of `R kappa` at the joint.
pub const R_KAPPAS: [f64; 10] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Values of `|R'| / |P'|`.
pub const TAPERS: [f64; 5] = [0.0, 0.05, 0.1, 0.25, 0.5];
/// Places around the tube's edge, where every angle is greatest.
const AROUND: usize = 64;
/// Places along each of the two segments, ends included.
const ALONG: usize = 33;
/// Curvature of the bent segment; the radius follows from `R kappa`. The least of those with the greatest taper still
/// leaves the source a radius of 0.
const KAPPA: f64 = 0.1;

/// The laws at one bend and taper.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Cell {
    /// `R kappa` on the bent side of the joint; it is 0 on the other.
    pub r_kappa: f64,
    /// `|R'| / |P'|`.
    pub taper: f64,
    /// One a law, in the order of [`LAWS`].
    pub laws: Vec<AtCell>,
}

/// One law there.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct AtCell {
    /// How the direction was found.
    pub law: Law,
    /// Largest angle to the tangent of the path, degrees.
    pub off_path_deg: f64,
    /// Largest jump of the direction at the joint, degrees.
    pub joint_jump_deg: f64,
    /// The step of `n.l` over the joint that it makes, of surfaces in all orientations that face the light: median.
    pub shading_step_p50: f64,
    /// What one surface in a hundred exceeds.
    pub shading_step_p99: f64,
}

/// Every bend with every taper.
pub fn grid() -> Vec<Cell> {
    let cells = TAPERS.into_iter().flat_map(|taper| R_KAPPAS.map(|r_kappa| (r_kappa, taper)));
    cells.map(|(r_kappa, taper)| cell(r_kappa, taper)).collect()
}

/// A light of two segments of length 1, the first bent with curvature [`KAPPA`] at the joint, the second straight; the
/// radius grows linearly, by `taper` a unit of length.
fn joint(r_kappa: f64, taper: f64) -> Tube<f64> {
    let radius = r_kappa / KAPPA;
    let (sin, cos) = (KAPPA, (1.0 - KAPPA * KAPPA).sqrt());
    let second = DVec3::new(cos, sin, 0.0);
    let first = DVec3::X * 0.5;
    let points = vec![DVec3::ZERO, first, first + second, first + second * 1.5];
    let radii = light::greville(2).into_iter().map(|t| radius + taper * (t - 1.0)).collect();
    Tube::new(&Light::bendy(points, radii)).expect("R kappa below 1")
}

fn cell(r_kappa: f64, taper: f64) -> Cell {
    let tube = joint(r_kappa, taper);
    Cell { r_kappa, taper, laws: LAWS.map(|law| at_cell(&tube, law)).to_vec() }
}

fn at_cell(tube: &Tube<f64>, law: Law) -> AtCell {
    let mut off_path: f64 = 0.0;
    for segment in 0..2 {
        for k in 0..ALONG {
            let u = k as f64 / (ALONG - 1) as f64;
            for angle in around() {
                let root = at_edge(tube, segment, u, angle);
                let path = Law::Path.direction(tube, &root);
                off_path = off_path.max(degrees_between(law.direction(tube, &root), path));
            }
        }
    }
    let worst = worst_jump(tube, law, 1);
    let steps = shading_steps(worst);
    AtCell {
        law,
        off_path_deg: off_path,
        joint_jump_deg: degrees_between(worst[0], worst[1]),
        shading_step_p50: steps[steps.len() / 2],
        shading_step_p99: steps[steps.len() * 99 / 100],
    }
}

/// The two directions at a joint, before and after it, where around the tube's edge they differ most.
pub fn worst_jump(tube: &Tube<f64>, law: Law, joint: usize) -> [DVec3; 2] {
    let sides = around().map(|angle| {
        [(joint - 1, 1.0), (joint, 0.0)]
            .map(|(segment, u)| law.direction(tube, &at_edge(tube, segment, u, angle)))
    });
    let jump = |[before, after]: &[DVec3; 2]| degrees_between(*before, *after);
    sides.max_by(|x, y| jump(x).total_cmp(&jump(y))).expect("some angles")
}

/// The places around the edge, in radians.
fn around() -> impl Iterator<Item = f64> {
    (0..AROUND).map(|k| TAU * k as f64 / AROUND as f64)
}

/// The root of a point on the tube's edge, `angle` around it from `v_hat`.
pub fn at_edge(tube: &Tube<f64>, segment: usize, u: f64, angle: f64) -> Root<f64> {
    let s = &tube.segments[segment].curve;
    let (u_hat, radius) = (s.u_hat(u), s.radius(u));
    let (v_hat, w_hat) = tube.cross_section(s, u_hat);
    let (sin, cos) = libm::sincos(angle);
    let (v_len, w_len) = (radius * cos, radius * sin);
    Root { segment, u, r: v_hat * v_len + w_hat * w_len, v_len, w_len, radius, v_hat, u_hat }
}

/// `|n.l|` differences between two directions, ascending, for normals spread evenly over those that face the first.
fn shading_steps([before, after]: [DVec3; 2]) -> Vec<f64> {
    let mut rng = Rng::with_seed(4);
    let mut steps = Vec::with_capacity(4000);
    while steps.len() < 4000 {
        let n = DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.f64() - 1.0));
        if n.length_squared() <= 1.0 && n.dot(before) > 0.0 {
            let n = n.normalize();
            steps.push((n.dot(before) - n.dot(after).max(0.0)).abs());
        }
    }
    steps.sort_by(f64::total_cmp);
    steps
}

/// Angle between unit vectors; from both products, so that small ones keep their digits.
pub fn degrees_between(x: DVec3, y: DVec3) -> f64 {
    libm::atan2(x.cross(y).length(), x.dot(y)).to_degrees()
}
