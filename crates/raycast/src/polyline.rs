//! A path as straight pieces, to be drawn.

use glam::DVec3;

use crate::bent_path::MAX_HALVINGS;
use crate::{BentPath, Chord};

/// How far a polyline may stray from its path, as a share of its length: where it fills a picture of 4,000 pixels it strays by
/// less than one.
///
/// `n` even pieces of a curve that turns by `theta` stray by `L theta / (8 n^2)`, so a half circle takes about 40.
const MAX_ERROR_SHARE: f64 = 1.0 / 4096.0;

/// What halving a piece once more may change of its length, as a share of it.
const LENGTH_ERROR: f64 = 1e-7;

/// A path as straight pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Points of the path in scene space, in order.
    pub points: Vec<DVec3>,
    /// No point of the path is farther than this from the pieces, in world units.
    pub max_error: f64,
    /// Length of the path itself, in world units: to a millionth or so.
    pub length: f64,
}

impl BentPath<'_> {
    /// Points from the source to `t_end`, so many that the pieces between them stray by less than 1/4096 of their length; but
    /// at most `most`, of which there are at least two a segment.
    ///
    /// The piece that strays most is halved until none strays too far, each by its own bound `|C''| h^2 / 8`.
    pub fn polyline(&self, t_end: f64, most: usize) -> Polyline {
        let mut chords: Vec<Chord> = (0..self.tube.segments.len())
            .filter_map(|segment| {
                let left = t_end - segment as f64;
                let end = if segment == self.tube.n { left } else { left.min(1.0) };
                (end > 0.0 || segment == 0).then(|| self.chord(segment, [0.0, end.max(0.0)]))
            })
            .collect();
        let stray = loop {
            let (worst, stray) = chords
                .iter()
                .map(chord_error_bound)
                .enumerate()
                .fold((0, 0.0), |most, (k, stray)| if stray > most.1 { (k, stray) } else { most });
            let length: f64 = chords.iter().map(Chord::length).sum();
            if stray <= MAX_ERROR_SHARE * length || chords.len() + 1 >= most {
                break stray;
            }
            let Chord { segment, u: [start, end], .. } = chords[worst];
            let middle = f64::midpoint(start, end);
            let halves = [[start, middle], [middle, end]].map(|u| self.chord(segment, u));
            chords.splice(worst..=worst, halves);
        };
        let points = chords[..1].iter().map(|first| first.ends[0]).chain(chords.iter().map(|c| c.ends[1]));
        let length = chords.iter().map(|chord| self.arc_length_between(chord.segment, chord.u, 0)).sum();
        Polyline { points: points.collect(), max_error: stray, length }
    }

    /// Length of the path between two parameters of a segment: as that of two halves, each halved again until that makes no
    /// difference.
    fn arc_length_between(&self, segment: usize, [start, end]: [f64; 2], halvings: u32) -> f64 {
        let middle = f64::midpoint(start, end);
        let (whole, halves) =
            (self.extrapolated_length(segment, [start, end]), [[start, middle], [middle, end]]);
        let parts: f64 = halves.iter().map(|half| self.extrapolated_length(segment, *half)).sum();
        if (parts - whole).abs() <= LENGTH_ERROR * parts || halvings == MAX_HALVINGS {
            return parts;
        }
        halves.iter().map(|half| self.arc_length_between(segment, *half, halvings + 1)).sum()
    }

    /// The same by Richardson's extrapolation: halving takes three quarters off the error of the straight length.
    fn extrapolated_length(&self, segment: usize, [start, end]: [f64; 2]) -> f64 {
        let [from, middle, to] =
            [start, f64::midpoint(start, end), end].map(|u| self.position_at(segment, u));
        (4.0 * (from.distance(middle) + middle.distance(to)) - from.distance(to)) / 3.0
    }
}

/// Bound of how far a path strays from its chord. Where the curve stops there is none, but a piece of 2^-24 of a segment is
/// as good as a point.
fn chord_error_bound(chord: &Chord) -> f64 {
    let shortest = 1.0 / f64::from(1 << MAX_HALVINGS);
    let error = chord.error();
    match chord.u[1] - chord.u[0] > shortest {
        true if error.is_nan() => f64::INFINITY,
        true => error,
        false => 0.0,
    }
}
