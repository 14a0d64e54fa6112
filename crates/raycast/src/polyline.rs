//! Polylines of light paths, for display.

use glam::DVec3;

use crate::bent_path::MAX_HALVINGS;
use crate::{BentPath, Chord};

/// Maximum error of a polyline as a share of the path's length: less than a pixel if the path fills a picture of 4,000
/// pixels.
///
/// The error of `n` even pieces of a curve that turns by `theta` is `L theta / (8 n^2)`, so a half circle takes about
/// 40.
const MAX_ERROR_SHARE: f64 = 1.0 / 4096.0;

/// Relative change of a piece's length, from one halving to the next, at which halving stops.
const LENGTH_ERROR: f64 = 1e-7;

/// Path as straight pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    pub points: Vec<DVec3>,
    /// Upper bound of the distance between the path and the straight pieces, in world units.
    pub max_error: f64,
    /// Length of the path itself, in world units, to about a millionth.
    pub length: f64,
}

impl BentPath<'_> {
    /// Makes a polyline from the source to `t_end`. It has as many points as an error below 1/4096 of the length needs,
    /// but at most `most`, and at least two for each segment.
    ///
    /// The piece with the largest bound `|C''| h^2 / 8` is halved until all bounds are small enough.
    pub fn polyline(&self, t_end: f64, most: usize) -> Polyline {
        let mut chords: Vec<Chord> = (0..self.tube.segments.len())
            .filter_map(|segment| {
                let left = t_end - segment as f64;
                let end = if segment == self.tube.n { left } else { left.min(1.0) };
                (end > 0.0 || segment == 0).then(|| self.chord(segment, [0.0, end.max(0.0)]))
            })
            .collect();
        let error = loop {
            let (worst, error) = chords
                .iter()
                .map(chord_error_bound)
                .enumerate()
                .fold((0, 0.0), |most, (k, error)| if error > most.1 { (k, error) } else { most });
            let length: f64 = chords.iter().map(Chord::length).sum();
            if error <= MAX_ERROR_SHARE * length || chords.len() + 1 >= most {
                break error;
            }
            let Chord { segment, u: [start, end], .. } = chords[worst];
            let middle = f64::midpoint(start, end);
            let halves = [[start, middle], [middle, end]].map(|u| self.chord(segment, u));
            chords.splice(worst..=worst, halves);
        };
        let points = chords[..1].iter().map(|first| first.ends[0]).chain(chords.iter().map(|c| c.ends[1]));
        let length = chords.iter().map(|chord| self.arc_length_between(chord.segment, chord.u, 0)).sum();
        Polyline { points: points.collect(), max_error: error, length }
    }

    /// Returns the length of the path between two parameters of a segment, by halving until that makes no difference.
    fn arc_length_between(&self, segment: usize, [start, end]: [f64; 2], halvings: u32) -> f64 {
        let middle = f64::midpoint(start, end);
        let (whole, halves) = (self.extrapolated_length(segment, [start, end]), [[start, middle], [middle, end]]);
        let parts: f64 = halves.iter().map(|half| self.extrapolated_length(segment, *half)).sum();
        if (parts - whole).abs() <= LENGTH_ERROR * parts || halvings == MAX_HALVINGS {
            return parts;
        }
        halves.iter().map(|half| self.arc_length_between(segment, *half, halvings + 1)).sum()
    }

    /// Returns the length by Richardson's extrapolation: halving removes three quarters of the error of the straight
    /// length.
    fn extrapolated_length(&self, segment: usize, [start, end]: [f64; 2]) -> f64 {
        let [from, middle, to] = [start, f64::midpoint(start, end), end].map(|u| self.position_at(segment, u));
        (4.0 * (from.distance(middle) + middle.distance(to)) - from.distance(to)) / 3.0
    }
}

/// Returns an upper bound of the distance between a path and its chord. There is no bound where the curve stops. A
/// piece of 2^-24 of a segment then counts as a point.
fn chord_error_bound(chord: &Chord) -> f64 {
    let shortest = 1.0 / f64::from(1 << MAX_HALVINGS);
    let error = chord.error();
    match chord.u[1] - chord.u[0] > shortest {
        true if error.is_nan() => f64::INFINITY,
        true => error,
        false => 0.0,
    }
}
