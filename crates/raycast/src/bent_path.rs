//! The way light takes: a curve of constant (v, w), cut into chords.

use bendy::{Frame, Segment, Tube};
use glam::DVec3;

use crate::PosedScene;

/// How far a chord may stray from its path, as a share of the chord's length.
///
/// Chosen by what it costs: boxes grow by it, and a hierarchy's leaves are seldom thirty times smaller than a
/// chord; half of it takes 1.4 times as many chords. Hits are found on the path itself, so no result
/// depends on it.
const CHORD_ERROR: f64 = 1.0 / 32.0;

/// Halvings after which a chord stands for its path all the same: where the curve stops (`P' = 0`) no
/// bound on its turning exists, but a piece of 2^-24 of a segment is as good as a point.
const MAX_HALVINGS: u32 = 24;

/// A curve of constant (v, w) in a light: `C(t) = P + R (v v_hat + w w_hat)` (light model, section 3).
#[derive(Clone, Copy, Debug)]
pub struct BentPath<'a> {
    /// The light.
    pub tube: &'a Tube<f64>,
    /// Place across the tube along `v_hat`, in radii.
    pub v: f64,
    /// Place across the tube along `w_hat`, in radii.
    pub w: f64,
    /// Position of the light's source in scene space.
    source: DVec3,
}

impl PosedScene<'_> {
    /// The path of constant (v, w), both in radii, through this scene.
    pub fn path<'a>(&self, tube: &'a Tube<f64>, v: f64, w: f64) -> BentPath<'a> {
        BentPath { tube, v, w, source: tube.placement.translation - self.origin_in_world }
    }
}

/// A piece of a path and the straight line between its ends.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// Index of the light's segment.
    pub segment: usize,
    /// Parameters in that segment of the two ends.
    pub u: [f64; 2],
    /// Positions of the two ends, in scene space.
    pub ends: [DVec3; 2],
    /// Bound of `|C''|` over the piece, by u, in world lengths.
    pub bend: f64,
}

impl Chord {
    /// Bound of the distance between the line and the path, at equal u: `|C''| h^2 / 8`.
    pub fn error(&self) -> f64 {
        let h = self.u[1] - self.u[0];
        // A straight piece may be endless in u, and 0 times that is no bound.
        if self.bend == 0.0 { 0.0 } else { self.bend * h * h / 8.0 }
    }

    fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

impl BentPath<'_> {
    /// Position in scene space at parameter `u` of a segment.
    pub fn at(&self, segment: usize, u: f64) -> DVec3 {
        let s = &self.tube.segments[segment];
        let (v_hat, w_hat) = self.tube.cross_section(s, s.u_hat(u));
        let in_tube = s.position(u) + (v_hat * self.v + w_hat * self.w) * s.radius(u);
        let placement = &self.tube.placement;
        self.source + placement.rotation * (in_tube * placement.world_per_tube)
    }

    /// Calls `visit` with chords from the source to `t_end`, in order, until it returns `true`. Each strays
    /// from the path by at most 1/32 of its length.
    pub fn for_each_chord(&self, t_end: f64, mut visit: impl FnMut(&Chord) -> bool) {
        for segment in 0..self.tube.segments.len() {
            let start = segment as f64;
            // The extension past the last segment has no end of its own.
            let u_end = if segment == self.tube.n { t_end - start } else { (t_end - start).min(1.0) };
            if u_end <= 0.0 {
                return;
            }
            let ends = [self.at(segment, 0.0), self.at(segment, u_end)];
            if self.halve(segment, [0.0, u_end], ends, 0, &mut visit) {
                return;
            }
        }
    }

    fn halve(
        &self,
        segment: usize,
        u: [f64; 2],
        ends: [DVec3; 2],
        halvings: u32,
        visit: &mut impl FnMut(&Chord) -> bool,
    ) -> bool {
        let chord = Chord { segment, u, ends, bend: self.bend(segment, u) };
        if chord.error() <= CHORD_ERROR * chord.length() || halvings == MAX_HALVINGS {
            return visit(&chord);
        }
        let middle = f64::midpoint(u[0], u[1]);
        let at_middle = self.at(segment, middle);
        self.halve(segment, [u[0], middle], [ends[0], at_middle], halvings + 1, visit)
            || self.halve(segment, [middle, u[1]], [at_middle, ends[1]], halvings + 1, visit)
    }

    /// Bound of `|C''|` over a piece, by u, in world lengths.
    ///
    /// With `e = v v_hat + w w_hat`, `rho = |e|`, `C'' = P'' + R'' e + 2 R' e' + R e''`. The tangent turns by
    /// `omega = |u_hat'| = |d0 x a| / |d|^2`, whose own derivative is at most `2 omega |a| / |d|`. A frame that
    /// twists by `tau` has `e' = -(e.u_hat') u_hat + tau (u_hat x e)`.
    fn bend(&self, segment: usize, [start, end]: [f64; 2]) -> f64 {
        let s = &self.tube.segments[segment];
        let rho = self.v.hypot(self.w);
        let h = end - start;
        // Between its ends a quadratic is at most |R''| h^2 / 8 above the larger of them.
        let radius =
            s.radius(start).max(s.radius(end)) + if s.ar == 0.0 { 0.0 } else { s.ar.abs() * h * h / 4.0 };
        let widening = s.radius_derivative(start).abs().max(s.radius_derivative(end).abs());
        let turn = Turn::of(s, [start, end]);
        let twist = match self.tube.frame {
            Frame::RotationMinimizing => Twist { tau: 0.0, change: 0.0 },
            Frame::Up => Twist::of(self.tube.up, s, [start, end], turn),
        };
        let first = rho * (turn.omega + twist.tau);
        let second = first * turn.omega
            + rho * (turn.change + 2.0 * turn.omega * turn.omega)
            + rho * twist.change
            + twist.tau * (turn.omega * rho + first);
        let bend = 2.0 * s.a.length() + 2.0 * s.ar.abs() * rho + 2.0 * widening * first + radius * second;
        bend * self.tube.placement.world_per_tube
    }
}

/// Bounds of how the tangent turns over a piece, by u.
#[derive(Clone, Copy)]
struct Turn {
    /// Of `|u_hat'|`.
    omega: f64,
    /// Of the derivative of that.
    change: f64,
}

impl Turn {
    fn of(s: &Segment<f64>, [start, end]: [f64; 2]) -> Self {
        let across = s.d0.cross(s.a).length();
        if across == 0.0 {
            return Self { omega: 0.0, change: 0.0 };
        }
        // |d| is least where d . a = 0.
        let nearest = (-s.d0.dot(s.a) / s.a.length_squared()).clamp(start, end);
        let slowest = s.d(nearest).length();
        let omega = across / (slowest * slowest);
        Self { omega, change: 2.0 * omega * s.a.length() / slowest }
    }
}

/// Bounds of how the frame "up" twists about the tangent over a piece, by u.
struct Twist {
    tau: f64,
    change: f64,
}

impl Twist {
    /// From `tau = c (u_hat' . v_hat) / s`, `c = up . u_hat`, `s = |up - c u_hat|`: `|c'| <= s omega` and
    /// `|s'| <= omega`.
    fn of(up: DVec3, segment: &Segment<f64>, [start, end]: [f64; 2], turn: Turn) -> Self {
        let u_hat = segment.u_hat(f64::midpoint(start, end));
        let sine = (up - u_hat * up.dot(u_hat)).length() - turn.omega * (end - start) / 2.0;
        // Where the tangent may meet `up` the frame flips, and nothing bounds that.
        let sine = sine.max(1e-9);
        let tau = turn.omega / sine;
        let change =
            turn.omega * turn.omega * (1.0 + 1.0 / (sine * sine)) + (turn.change + tau * turn.omega) / sine;
        Self { tau, change }
    }
}
