//! Why a light is refused.

use thiserror::Error;

/// Why a light cannot be evaluated. Each sentence says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LightError {
    /// Fewer control points than one quadratic segment needs.
    #[error("a BendyLight needs at least 3 control points, this one has {0}: add points")]
    TooFewPoints(usize),
    /// More control points than [`crate::MAX_SEGMENTS`] allows.
    #[error("a BendyLight has at most {limit} control points, this one has {count}: remove points")]
    TooManyPoints {
        /// How many it has.
        count: usize,
        /// How many it may have.
        limit: usize,
    },
    /// Lists of control points' values, as files have them, that differ in length.
    #[error("`{field}` has {count} entries for {points} control points: give one entry a point")]
    LengthMismatch {
        /// The field.
        field: &'static str,
        /// Its length.
        count: usize,
        /// The length of `points`.
        points: usize,
    },
    /// A number is NaN or infinite.
    #[error("`{0}` holds a number that is not finite: replace it")]
    NotFinite(&'static str),
    /// A number is outside its domain.
    #[error("`{field}` is {value}, but {domain}: change it")]
    OutOfDomain {
        /// The field.
        field: &'static str,
        /// What it holds.
        value: f64,
        /// The domain, as the end of a sentence.
        domain: String,
    },
    /// A rotation that is none.
    #[error(
        "`{field}` has length {length}, but it must be a unit quaternion [x, y, z, w], of length 1: change it"
    )]
    NotARotation {
        /// The field.
        field: &'static str,
        /// What it has.
        length: f64,
    },
    /// Text that is too long.
    #[error("`{field}` has more than {limit} bytes: shorten it")]
    TooLong {
        /// The field.
        field: &'static str,
        /// How many it may have.
        limit: usize,
    },
    /// Links that name too many nodes.
    #[error("`{field}` names {count} nodes, at most {limit} may be: name what they stand under instead")]
    TooManyLinks {
        /// The field.
        field: &'static str,
        /// How many it names.
        count: usize,
        /// How many it may name.
        limit: usize,
    },
    /// A curve over an angle with too many knots.
    #[error("`{field}` has {count} pairs, at most {limit} may be: leave some out")]
    TooManyKnots {
        /// The field.
        field: &'static str,
        /// How many it has.
        count: usize,
        /// How many it may have.
        limit: usize,
    },
    /// A curve over an angle that goes back, or more than once around.
    #[error(
        "`{0}` must be pairs [degrees, number] whose degrees ascend from 0 to less than 360, each given once: sort them"
    )]
    UnsortedKnots(&'static str),
    /// A value of another type than the parameter's.
    #[error("`{field}` must be {expected}: change it")]
    WrongType {
        /// The field.
        field: &'static str,
        /// What it takes.
        expected: String,
    },
    /// A radius that no tube can have.
    #[error(
        "`radii[{index}]` is {value}, but a radius must be 0 or more and at most a million times the light's length: change it"
    )]
    Radius {
        /// Index of the control point.
        index: usize,
        /// The radius.
        value: f64,
    },
    /// The first control point is not the light's origin.
    #[error("`points[0]` is the source and must be [0, 0, 0]: move the light by its `transform.translation`")]
    SourceNotAtOrigin,
    /// A segment without direction, or one that runs back over itself.
    #[error("segment {segment} {why}: move control point {point}")]
    Degenerate {
        /// Index of the segment, from 0.
        segment: usize,
        /// What is wrong, as a verb phrase.
        why: &'static str,
        /// Index of the control point to move.
        point: usize,
    },
    /// The tube folds over itself: `R kappa >= 1` somewhere.
    #[error(
        "the tube folds in segment {segment}: its radius is {r_kappa:.3} times the radius of its bend, which must \
         stay below 1: make `radii` around control point {point} smaller or the bend wider"
    )]
    Fold {
        /// Index of the segment, from 0.
        segment: usize,
        /// The largest `R kappa` there.
        r_kappa: f64,
        /// Index of the segment's middle control point.
        point: usize,
    },
    /// Only a spotlight, or a light that is first given a cone, can be bent.
    #[error("only a straight light can be made a BendyLight, and this one is bent: move its control points")]
    NotASpot,
    /// Only a BendyLight can be made straight.
    #[error("only a BendyLight can be made straight, and this light is straight already: leave it as it is")]
    NotBent,
    /// A BendyLight that ends where it begins has no direction.
    #[error(
        "the light ends where it begins, which is no direction to shine along: move its last control point"
    )]
    NoDirection,
    /// An omni light is to shine at where it stands.
    #[error("`toward` is where the light stands, which is no direction to shine along: choose another place")]
    TowardAtSource,
    /// An omni light whose range cuts off what fades past its cut-off: a BendyLight has one end.
    #[error(
        "the light ends at its `range` of {range} while it still fades, from its `cutOff` of {cut_off} over its \
         `farEdge`; a BendyLight fades or ends, and not both: make the range larger or the edge shorter"
    )]
    RangeInFarEdge {
        /// World units.
        range: f64,
        /// World units.
        cut_off: f64,
    },
    /// A spotlight cannot be divided into this many segments.
    #[error("a light is bent into 1 to {limit} segments, not {count}: choose another number")]
    SegmentCount {
        /// How many were asked for.
        count: usize,
        /// How many it may have.
        limit: usize,
    },
}
