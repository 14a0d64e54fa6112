//! Overlaps of distant parts of a tube.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::Tube;
use crate::arc::arc_length;
use crate::curve::Curve;
use crate::rays::tube::TubeRoot;
use crate::segment::Segment;

/// Numbers of cross-sections of a segment that are tested, at least and at most, and of points around each.
const ALONG: [f64; 2] = [4.0, 64.0];
const AROUND: usize = 12;

/// Distance between tested cross-sections, in radii.
const SPACING_RADII: f64 = 0.25;

/// Distance of the tested points from the axis, in radii. They avoid the rounding at the rim.
const RIM: f64 = 0.999;

/// Least distance along the axis between two parts that may not come near each other, in radii. Cross-sections of one
/// bend come near each other before it folds, but those of two arms lie further apart along the axis.
const LEAST_ARC_RADII: f64 = 2.0;

/// Point in two distant parts of a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeOverlap {
    /// Global t of the point in one part.
    pub t: f64,
    /// Coordinates (v, w) across that part, in its radii.
    pub across: DVec2,
    /// Global t of the same point in the other part.
    pub other_t: f64,
    /// Coordinates (v, w) across the other part, in its radii.
    pub other_across: DVec2,
}

/// Cross-section whose points are tested.
struct CrossSection {
    segment: usize,
    u: f64,
    center: DVec3,
    /// Unit tangent of the curve, normal to the cross-section.
    tangent: DVec3,
    radius: f64,
    /// Arc length from the source.
    arc: f64,
    /// Distance of the centers of the neighbouring cross-sections, at most, and the largest radius up to them.
    spacing: f64,
    largest_radius: f64,
}

impl CrossSection {
    fn t(&self) -> f64 {
        self.segment as f64 + self.u
    }

    /// True if points of this cross-section, moved outwards by the clearance, may lie in one between the neighbours of the
    /// other. Such a point is at most twice the spacing from the other's plane: once along the curve, and once by the turn
    /// of the planes, since the radius is less than that of the bend.
    fn may_touch(&self, other: &Self, clearance: f64) -> bool {
        let is_apart =
            clearance == 0.0 || self.is_apart(other.arc + other.spacing) || self.is_apart(other.arc - other.spacing);
        if !is_apart {
            return false;
        }
        let (rim, between) = (self.radius * (RIM + clearance), self.center - other.center);
        let turn = self.tangent.cross(other.tangent).length();
        between.dot(other.tangent).abs() <= rim * turn + 2.0 * other.spacing
            && between.length() <= rim + other.largest_radius + other.spacing
    }

    fn is_apart(&self, arc: f64) -> bool {
        (arc - self.arc).abs() > LEAST_ARC_RADII * self.radius
    }
}

impl Tube<f64> {
    /// Returns a point in two distant parts of the tube, if it finds one. With a `clearance`, in radii, one part may not
    /// come nearer than that to the other.
    ///
    /// Points of a grid are tested, at the rim of cross-sections and on the axis. Where the other part is a sharp edge,
    /// such as the rim of the tube's end, it may reach a thirtieth of a radius between two of them.
    pub fn overlap(&self, clearance: f64) -> Option<TubeOverlap> {
        let sections = self.tested_cross_sections();
        let may_overlap = |section: &&CrossSection| sections.iter().any(|other| section.may_touch(other, clearance));
        sections.iter().filter(may_overlap).find_map(|section| self.overlap_of_cross_section(section, clearance))
    }

    /// Returns the number of cross-sections that [`Self::overlap()`] tests.
    pub fn overlap_section_count(&self) -> usize {
        self.segments[..self.n].iter().map(|segment| cross_section_count(&segment.curve)).sum::<usize>() + 1
    }

    fn tested_cross_sections(&self) -> Vec<CrossSection> {
        let of_segment = |(i, segment): (usize, &Segment<f64>)| {
            let (curve, arc_start) = (segment.curve, segment.arc_start);
            let count = cross_section_count(&curve);
            // The cross-section at the end belongs to the next segment, if there is one.
            let last = if i + 1 == self.n { count } else { count - 1 };
            (0..=last).map(move |k| {
                let [before, u, after] = [k as f64 - 1.0, k as f64, k as f64 + 1.0].map(|k| k / count as f64);
                let (center, radius) = (curve.position(u), curve.radius(u));
                let beside = [before, after].map(|u| u.clamp(0.0, 1.0));
                CrossSection {
                    segment: i,
                    u,
                    center,
                    tangent: curve.u_hat(u),
                    radius,
                    arc: arc_start + arc_length(&curve, u),
                    spacing: beside.map(|u| curve.position(u).distance(center)).into_iter().fold(0.0, f64::max),
                    largest_radius: beside.map(|u| curve.radius(u)).into_iter().fold(radius, f64::max),
                }
            })
        };
        self.segments[..self.n].iter().enumerate().flat_map(of_segment).collect()
    }

    fn overlap_of_cross_section(&self, section: &CrossSection, clearance: f64) -> Option<TubeOverlap> {
        let curve = &self.segments[section.segment].curve;
        let (v_hat, w_hat) = self.cross_section(curve, section.tangent);
        let arc_of = |root: &TubeRoot<f64>| {
            let segment = &self.segments[root.segment];
            segment.arc_start + arc_length(&segment.curve, root.u)
        };
        (0..=AROUND).find_map(|around| {
            let (sin, cos) = libm::sincos(TAU * around as f64 / AROUND as f64);
            // The last point is on the axis.
            let rho = if around == AROUND { 0.0 } else { RIM + clearance };
            let across = DVec2::new(cos, sin) * rho;
            let mut other = None;
            self.for_each_root(section.center + (v_hat * across.x + w_hat * across.y) * section.radius, |root| {
                let is_apart = if clearance > 0.0 {
                    section.is_apart(arc_of(&root))
                } else {
                    (root.t() - section.t()).abs() > 1e-6
                };
                if is_apart && root.radius > 0.0 {
                    other = Some((root.t(), DVec2::new(root.v_len, root.w_len) / root.radius));
                }
            });
            let (other_t, other_across) = other?;
            Some(TubeOverlap { t: section.t(), across, other_t, other_across })
        })
    }
}

/// Returns the number of cross-sections of a segment that are tested.
fn cross_section_count(curve: &Curve<f64>) -> usize {
    let length = curve.d0.length() + curve.d1.length();
    let radius = 0.5 * (curve.radius(0.0) + curve.radius(1.0));
    (length / (SPACING_RADII * radius).max(f64::MIN_POSITIVE)).ceil().clamp(ALONG[0], ALONG[1]) as usize
}
