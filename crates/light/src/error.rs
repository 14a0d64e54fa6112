//! Errors of lights.

use thiserror::Error;

/// Reason why a light cannot be evaluated. The message says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LightError {
    /// Fewer control points than one quadratic segment needs.
    #[error("a BendyLight needs at least 3 control points, this one has {0}: add points")]
    TooFewPoints(usize),
    /// More control points than [`crate::MAX_SEGMENTS`] allows.
    #[error("a BendyLight has at most {limit} control points, this one has {count}: remove points")]
    TooManyPoints { count: usize, limit: usize },
    /// Lists of control points' values, as in files, that differ in length.
    #[error("`{field}` has {count} entries for {points} control points: give one entry a point")]
    LengthMismatch {
        field: &'static str,
        /// Length of the field's list.
        count: usize,
        /// Length of `points`.
        points: usize,
    },
    /// Number that is NaN or infinite.
    #[error("`{0}` holds a number that is not finite: replace it")]
    NotFinite(&'static str),
    /// Number outside its domain.
    #[error("`{field}` is {value}, but {domain}: change it")]
    OutOfDomain {
        field: &'static str,
        value: f64,
        /// Domain, as the end of a sentence.
        domain: String,
    },
    /// Quaternion far from unit length.
    #[error("`{field}` has length {length}, but it must be a unit quaternion [x, y, z, w], of length 1: change it")]
    NotARotation { field: &'static str, length: f64 },
    #[error("`{field}` has more than {limit} bytes: shorten it")]
    TooLong { field: &'static str, limit: usize },
    /// Links that name too many nodes.
    #[error("`{field}` names {count} nodes, at most {limit} may be: name what they stand under instead")]
    TooManyLinks { field: &'static str, count: usize, limit: usize },
    /// Curve over an angle with too many knots.
    #[error("`{field}` has {count} pairs, at most {limit} may be: leave some out")]
    TooManyKnots { field: &'static str, count: usize, limit: usize },
    /// Curve over an angle whose knots are not in ascending order within one turn.
    #[error(
        "`{0}` must be pairs [degrees, number] whose degrees ascend from 0 to less than 360, each given once: sort them"
    )]
    UnsortedKnots(&'static str),
    /// Value of another type than the parameter's.
    #[error("`{field}` must be {expected}: change it")]
    WrongType {
        field: &'static str,
        /// Expected type, as the end of a sentence.
        expected: String,
    },
    /// Radius outside its range.
    #[error(
        "`radii[{index}]` is {value}, but a radius must be 0 or more and at most a million times the light's length: change it"
    )]
    Radius { index: usize, value: f64 },
    /// First control point that is not at the light's origin.
    #[error("`points[0]` is the source and must be [0, 0, 0]: move the light by its `transform.translation`")]
    SourceNotAtOrigin,
    /// Segment without direction, or one that runs back over itself.
    #[error("segment {segment} {why}: move control point {point}")]
    Degenerate {
        /// Index of the segment, from 0.
        segment: usize,
        /// Problem of the segment, as a verb phrase.
        why: &'static str,
        point: usize,
    },
    /// Tube that folds over itself: `R kappa >= 1` somewhere.
    #[error(
        "the tube folds in segment {segment}: its radius is {r_kappa:.3} times the radius of its bend, which must \
         stay below 1: make `radii` around control point {point} smaller or the bend wider"
    )]
    Fold {
        /// Index of the segment, from 0.
        segment: usize,
        /// Largest `R kappa` of the segment.
        r_kappa: f64,
        point: usize,
    },
    /// Bend of a light that is not a spotlight. An omni or directional light is given a cone first.
    #[error("only a straight light can be made a BendyLight, and this one is bent: move its control points")]
    NotASpot,
    /// Straightening of a light that is not a BendyLight.
    #[error("only a BendyLight can be made straight, and this light is straight already: leave it as it is")]
    NotBent,
    /// BendyLight that ends at its source and so has no direction.
    #[error("the light ends where it begins, which is no direction to shine along: move its last control point")]
    NoDirection,
    /// Omni light whose target is its own position.
    #[error("`toward` is where the light stands, which is no direction to shine along: choose another place")]
    TowardAtSource,
    /// Omni light whose range cuts off a fade past its cut-off. A BendyLight has one end.
    #[error(
        "the light ends at its `range` of {range} while it still fades, from its `cutOff` of {cut_off} over its \
         `farEdge`; a BendyLight fades or ends, and not both: make the range larger or the edge shorter"
    )]
    RangeInFarEdge {
        /// Range of the omni light, in world units.
        range: f64,
        /// Cut-off of the omni light, in world units.
        cut_off: f64,
    },
    /// Number of segments, for bending a spotlight, that is 0 or too large.
    #[error("a light is bent into 1 to {limit} segments, not {count}: choose another number")]
    SegmentCount { count: usize, limit: usize },
}
