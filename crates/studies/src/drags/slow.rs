//! A slow solver with restarts: it searches any light within the limits that puts a feature under the cursor.
//!
//! It applies the Levenberg-Marquardt method to the equations and to the violations of the limits, from dozens of
//! random lights. It shares nothing with the product's solver: no path from start to end, no continuation of roots, no
//! quadratic program. Results are checked with the light's own `locate` and with the reference's shadows, and so are
//! hard pins.

use bench::drag::{EquationError, Trial, TrialScene};
use drag::{Feature, PinKind};
use fastrand::Rng;
use glam::{DMat3, DQuat, DVec3};
use light::parameters::{ROTATION, TRANSLATION};
use light::{CheckedLight, Light, Tube};
use raycast::SeenPoint;

use super::pins::StudyPin;
use super::relaxed::nearest_coords;

/// Number of lights from which the search starts.
const RESTARTS: usize = 60;

/// Maximum number of steps from each of these lights.
const STEPS: usize = 60;

/// Number of steps in a row that reduce the norm of the residuals by less than a hundredth, after which a start is
/// abandoned.
const MAX_STALLED_STEPS: usize = 8;

/// Step of finite differences, in the units of the unknowns.
const DIFFERENCE: f64 = 1e-7;

/// Limit of `R kappa`, if the light had less before the drag.
const MAX_R_KAPPA: f64 = 0.97;

/// Minimum of `1 - kappa r.N` at the feature.
const MIN_FOLD_FACTOR: f64 = 0.02;

/// Minimum distance of the feature from the tube's rim, in radii.
const INSIDE: f64 = 1e-4;

/// Margin to the limits at which the search aims, so that its results are within them.
const LIMIT_MARGIN: f64 = 1e-6;

/// Weight of a limit's violation relative to the equations.
const WEIGHT: f64 = 3.0;

/// A drag as equations.
struct DragEquations<'a> {
    stage: &'a TrialScene,
    trial: &'a Trial,
    /// The hard pins. The others yield to the drag.
    pins: Vec<&'a StudyPin>,
    to: SeenPoint,
    /// Limit of `R kappa` for each segment.
    max_r_kappa: Vec<f64>,
    /// World units per unit of an unknown: the length of the control polygon, or for a whole light its distance from
    /// the cursor.
    unit: f64,
}

/// Light with the feature under the cursor.
pub struct FoundLight {
    /// Index of the start of its search: 0 is the light before the drag, the others are random.
    pub restart: usize,
    pub light: CheckedLight,
}

/// Searches a light within the limits with the feature under the cursor, in which hard pins hold.
pub fn feasible(stage: &TrialScene, trial: &Trial, pins: &[StudyPin], seed: u64) -> Option<FoundLight> {
    let equations = DragEquations::new(stage, trial, pins)?;
    let mut rng = Rng::with_seed(seed);
    (0..RESTARTS).find_map(|restart| {
        let x = equations.start(restart, &mut rng)?;
        let x = equations.descend(x)?;
        let light = CheckedLight::new(equations.light(&x)).ok()?;
        equations.is_within_limits(&light).then_some(FoundLight { restart, light })
    })
}

impl<'a> DragEquations<'a> {
    fn new(stage: &'a TrialScene, trial: &'a Trial, pins: &'a [StudyPin]) -> Option<Self> {
        let to = stage.seen(trial.drag.to)?;
        let tube = trial.light.tube()?;
        let points = trial.light.light().points();
        let unit = if trial.kind.deforms {
            points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
        } else {
            (tube.placement.translation - stage.origin()).distance(to.position)
        };
        let folds = tube.r_kappa_max().into_iter().map(|fold| fold.max(MAX_R_KAPPA)).collect();
        let pins = pins.iter().filter(|pinned| pinned.pin.is_hard).collect();
        Some(Self { stage, trial, pins, to, max_r_kappa: folds, unit })
    }

    /// Returns the number of unknowns.
    fn count(&self) -> usize {
        self.trial.drag.points.as_ref().map_or(6, |points| 3 * points.len())
    }

    fn light(&self, x: &[f64]) -> Light {
        let begun = self.trial.light.light().clone();
        let vector = |k: usize| DVec3::from_slice(&x[3 * k..][..3]);
        match &self.trial.drag.points {
            None => {
                let turn = DQuat::from_scaled_axis(vector(1));
                let (translation, rotation) = (begun.get(TRANSLATION), begun.get(ROTATION));
                let light = begun.with(TRANSLATION, translation + self.unit * vector(0));
                light.with(ROTATION, (turn * rotation).normalize())
            }
            Some(chosen) => begun.map_points(|index, point| {
                if let Some(k) = chosen.iter().position(|&chosen| chosen == index) {
                    point.position += self.unit * vector(k);
                }
            }),
        }
    }

    fn tube(&self, x: &[f64]) -> Option<Tube<f64>> {
        let light = self.light(x);
        if self.trial.kind.deforms {
            return Tube::new(&light).ok();
        }
        let mut tube = self.trial.light.tube()?.clone();
        tube.placement.translation = light.get(TRANSLATION);
        tube.placement.rotation = DMat3::from_quat(light.get(ROTATION));
        Some(tube)
    }

    /// Returns the values that must become 0: the two equations, and the violation of each limit. `None` if the light
    /// is invalid.
    fn residuals(&self, x: &[f64]) -> Option<Vec<f64>> {
        let tube = self.tube(x)?;
        let origin = self.stage.origin();
        let coords = nearest_coords(&tube, self.to.position + origin)?;
        let over = |value: f64| WEIGHT * (value + LIMIT_MARGIN).max(0.0);
        let mut all = vec![
            over(coords.across.length() - (1.0 - INSIDE)),
            over(MIN_FOLD_FACTOR - coords.fold_factor),
            WEIGHT * coords.beyond,
        ];
        if self.trial.kind.deforms {
            all.extend(tube.r_kappa_max().iter().zip(&self.max_r_kappa).map(|(fold, most)| over(fold - most)));
        }
        let turned = |wanted: DVec3| turned(coords.direction, wanted);
        for pinned in &self.pins {
            let here = nearest_coords(&tube, pinned.surface.position + origin)?;
            all.extend([over(here.across.length() - (1.0 - INSIDE)), WEIGHT * here.beyond]);
            match (pinned.pin.kind, pinned.pivot) {
                (PinKind::Direction, _) => all.extend(self::turned(here.direction, pinned.coords.direction)),
                (PinKind::Shadow, Some(pivot)) => {
                    let pivot = nearest_coords(&tube, pivot + origin)?;
                    all.extend([over(pivot.t - here.t + 1e-5), WEIGHT * pivot.beyond]);
                    all.extend((pivot.across - here.across).to_array());
                }
                // Visibility has no gradient, so restarts have to satisfy such pins.
                _ => {}
            }
        }
        let equations = match self.trial.kind.feature {
            Feature::Shadow => {
                let pivot = nearest_coords(&tube, self.trial.pivot_in_scene? + origin)?;
                all.push(over(pivot.t - coords.t + 1e-5));
                all.push(WEIGHT * pivot.beyond);
                (pivot.across - coords.across).to_array()
            }
            Feature::Hotspot => [coords.across.x - self.trial.from.v, coords.across.y - self.trial.from.w],
            Feature::Highlight => turned(self.to.mirror_direction()),
            Feature::Diffuse => turned(self.to.normal),
        };
        all.extend(equations);
        all.iter().all(|residual| residual.is_finite()).then_some(all)
    }

    /// Returns the start of a restart: the light before the drag, a random change of it of any size, or a light whose
    /// moving points are spread along a straight line.
    fn start(&self, restart: usize, rng: &mut Rng) -> Option<Vec<f64>> {
        const SIZES: [f64; 7] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.2];
        if restart == 0 {
            return Some(vec![0.0; self.count()]);
        }
        (0..100).find_map(|_| {
            let size = SIZES[restart % SIZES.len()];
            let mut x: Vec<f64> = (0..self.count()).map(|_| size * normal(rng)).collect();
            if !self.trial.kind.deforms {
                // Rotations of any size.
                x[3..].iter_mut().for_each(|turn| *turn *= 2.0);
            } else if restart % 3 == 2 {
                self.straighten(&mut x, rng);
            }
            self.residuals(&x).map(|_| x)
        })
    }

    /// Puts the moving points near a random line from the source, offset by half of `x`.
    fn straighten(&self, x: &mut [f64], rng: &mut Rng) {
        let all = self.trial.light.light().points();
        let Some(chosen) = &self.trial.drag.points else { return };
        let end = all[all.len() - 1].position;
        let aside = DVec3::from_array(std::array::from_fn(|_| 0.4 * self.unit * normal(rng)));
        let axis = (end + aside - all[0].position) * (0.6 + 0.8 * rng.f64());
        for (k, &point) in chosen.iter().enumerate() {
            let share = point as f64 / (all.len() - 1) as f64;
            let to = (all[0].position + axis * share - all[point].position) / self.unit;
            x[3 * k..][..3].iter_mut().zip(to.to_array()).for_each(|(x, to)| *x = 0.5 * *x + to);
        }
    }

    /// Minimizes the residuals, from `x` on, by the Levenberg-Marquardt method. Returns `None` if not all residuals
    /// become almost zero.
    fn descend(&self, mut x: Vec<f64>) -> Option<Vec<f64>> {
        let mut residuals = self.residuals(&x)?;
        let (mut damping, mut stalled) = (1e-3, 0);
        for _ in 0..STEPS {
            let size = squared(&residuals);
            if size < 1e-24 || stalled >= MAX_STALLED_STEPS {
                break;
            }
            let (matrix, gradient) = self.normal_equations(&x, &residuals);
            let mut is_better = false;
            for _ in 0..12 {
                let step = solve(&matrix, &gradient, damping);
                let next: Vec<f64> = x.iter().zip(&step).map(|(x, step)| x - step).collect();
                match self.residuals(&next).filter(|next| squared(next) < size) {
                    Some(found) => {
                        (x, residuals, is_better) = (next, found, true);
                        damping = (damping * 0.2).max(1e-15);
                        break;
                    }
                    None => damping = (damping * 5.0).max(1e-12),
                }
            }
            if !is_better {
                break;
            }
            stalled = if squared(&residuals) > 0.98 * size { stalled + 1 } else { 0 };
        }
        // The light's own measures judge later if that is close enough.
        (squared(&residuals) < 1e-4).then_some(x)
    }

    /// Returns `J^T J` and `J^T r`, by finite differences.
    fn normal_equations(&self, x: &[f64], residuals: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let columns: Vec<Vec<f64>> = (0..x.len())
            .map(|k| {
                let side = |step: f64| {
                    let mut beside = x.to_vec();
                    beside[k] += step;
                    self.residuals(&beside).filter(|beside| beside.len() == residuals.len())
                };
                let (found, step) = match side(DIFFERENCE) {
                    Some(found) => (found, DIFFERENCE),
                    None => (side(-DIFFERENCE).unwrap_or_else(|| residuals.to_vec()), -DIFFERENCE),
                };
                found.iter().zip(residuals).map(|(found, at)| (found - at) / step).collect()
            })
            .collect();
        let matrix = columns.iter().map(|a| columns.iter().map(|b| product(a, b)).collect()).collect();
        let gradient = columns.iter().map(|column| product(column, residuals)).collect();
        (matrix, gradient)
    }

    /// True if the light is a solution by its own `locate`: the feature is under the cursor, and the light keeps the
    /// limits and the pins.
    fn is_within_limits(&self, light: &CheckedLight) -> bool {
        let Some(tube) = light.tube() else { return false };
        let do_not_fold = !self.trial.kind.deforms
            || tube.r_kappa_max().iter().zip(&self.max_r_kappa).all(|(fold, most)| fold <= most);
        let Some(there) = self.stage.locate(light, self.to.position) else { return false };
        let curve = &tube.segments[there.segment].curve;
        let (v_hat, w_hat) = tube.cross_section(curve, curve.u_hat(there.u));
        let r = (v_hat * there.v + w_hat * there.w) * curve.radius(there.u);
        let turn = curve.u_hat_derivative(there.u, curve.u_hat(there.u));
        let spread = 1.0 - r.dot(turn) / (2.0 * curve.d(there.u).length());
        do_not_fold
            && spread > MIN_FOLD_FACTOR
            && there.v.hypot(there.w) <= 1.0 - INSIDE
            && EquationError::at_target(self.stage, self.trial, light)
                .is_some_and(|off| off.is_landed(self.trial.kind.feature))
            && self.pins.iter().all(|pinned| pinned.holds(self.stage, light))
    }
}

/// Components of the sine between a direction and the direction `wanted`. In the opposite half space they are replaced
/// by larger values.
fn turned(direction: DVec3, wanted: DVec3) -> [f64; 2] {
    let (right, up) = wanted.any_orthonormal_pair();
    let (x, y) = (direction.dot(right), direction.dot(up));
    if direction.dot(wanted) > 0.0 { [x, y] } else { [2.0 - x.abs(), 2.0 - y.abs()] }
}

/// Returns a random number from the normal distribution, by the Box-Muller method.
fn normal(rng: &mut Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (std::f64::consts::TAU * rng.f64()).cos()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn squared(a: &[f64]) -> f64 {
    product(a, a)
}

/// Solves `(A + damping (diag A + 1e-9 trace A)) x = b` for a symmetric A, by Cholesky's method.
fn solve(matrix: &[Vec<f64>], right: &[f64], damping: f64) -> Vec<f64> {
    let count = right.len();
    let trace: f64 = (0..count).map(|k| matrix[k][k]).sum();
    let mut lower = vec![vec![0.0; count]; count];
    for row in 0..count {
        for column in 0..=row {
            let known = product(&lower[row][..column], &lower[column][..column]);
            let more = if row == column { damping * (matrix[row][row] + 1e-3 * trace) + 1e-300 } else { 0.0 };
            let left = matrix[row][column] + more - known;
            lower[row][column] = if row == column { left.max(1e-300).sqrt() } else { left / lower[column][column] };
        }
    }
    let mut x = right.to_vec();
    for row in 0..count {
        let known = product(&lower[row][..row], &x[..row]);
        x[row] = (x[row] - known) / lower[row][row];
    }
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|k| lower[k][row] * x[k]).sum();
        x[row] = (x[row] - known) / lower[row][row];
    }
    x
}
