//! Tests of `bendylights eval` against answers computed with 50 digits (`fixtures/eval.json`), on f64, f32 and
//! the GPU.
//!
//! The bounds come from the light model, section 5, "Conditioning". For a point at offset `r` from the curve
//! the error of its parameter is within
//!
//! ```text
//! |dt| <= 16 eps cond,   cond = (|r| + L) / (|P'| (1 - kappa r.N)) (1 + |world offset| / size),   L = |d0| + |d1|
//! ```
//!
//! with `eps` 2^-52 in f64 and 2^-24 in f32 and on the GPU. `size` is the length of the control polygon. The
//! direction is a unit vector: the length of the difference has the same bound. `v` and `w` are an offset over
//! the radius: they have the same bound times `size / R`. The radius changes by `R'` times the error of t. It
//! is also a sum of products of control radii, none larger than the largest, which adds to its bound. The
//! number of roots, the chosen root, the segment and the inside test have no tolerance.

use glam::{DQuat, DVec3};
use serde_json::{Value, json};

use crate::program::{Folder, json_of};

const EPS_F64: f64 = 1.0 / (1u64 << 52) as f64;
const EPS_F32: f64 = 1.0 / (1u64 << 24) as f64;

/// Curve of a light in light-local space, as far as the bounds need it.
struct Curve {
    points: Vec<DVec3>,
    radii: Vec<f64>,
    translation: DVec3,
    rotation: DQuat,
    scale: f64,
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(number).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

impl Curve {
    fn of(light: &Value) -> Self {
        let transform = &light["transform"];
        Self {
            points: light["points"].as_array().expect("points").iter().map(vector).collect(),
            radii: numbers(&light["radii"]),
            translation: vector(&transform["translation"]),
            rotation: DQuat::from_slice(&numbers(&transform["rotation"])).normalize(),
            scale: number(&transform["scale"]),
        }
    }

    /// Returns the length of the control polygon.
    fn size(&self) -> f64 {
        self.points.windows(2).map(|p| p[0].distance(p[1])).sum()
    }

    /// Returns half the derivatives at both ends of segment `i` of a quantity, from its control values (section
    /// 1).
    fn half_derivatives<T>(c: &[T], i: usize) -> (T, T)
    where
        T: Copy + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
    {
        let first = if i == 0 { 1.0 } else { 0.5 };
        let last = if i + 3 == c.len() { 1.0 } else { 0.5 };
        ((c[i + 1] - c[i]) * first, (c[i + 2] - c[i + 1]) * last)
    }

    fn start(&self, i: usize) -> DVec3 {
        if i == 0 { self.points[0] } else { (self.points[i] + self.points[i + 1]) / 2.0 }
    }

    /// Computes `cond` and `R'` at the root `t` of a world position.
    fn conditioning(&self, point_in_world: DVec3, t: f64) -> (f64, f64) {
        let i = (t as usize).min(self.points.len() - 3);
        let u = t - i as f64;
        let (d0, d1) = Self::half_derivatives(&self.points, i);
        let (e0, e1) = Self::half_derivatives(&self.radii, i);
        let a = d1 - d0;
        let q = self.rotation.inverse() * (point_in_world - self.translation) / self.scale;
        let r = q - self.start(i) - (d0 * 2.0 + a * u) * u;
        let d = d0 + a * u;
        let speed = 2.0 * d.length();
        // kappa r.N = r . u_hat' / |P'|, with u_hat' = (P'' - (P''.u_hat) u_hat) / |P'| and P'' = 2 a.
        let u_hat = d / d.length();
        let kappa_d = r.dot(2.0 * (a - u_hat * a.dot(u_hat)) / speed) / speed;
        let local = (r.length() + d0.length() + d1.length()) / (speed * (1.0 - kappa_d));
        let offset = 1.0 + self.translation.length() / (self.size() * self.scale);
        (local * offset, 2.0 * (e0 + u * (e1 - e0)))
    }
}

/// Returns one sentence for each answer outside its bound. `direction` is the field of the expected direction.
fn disagreements(case: &Value, answers: &Value, direction: &str, eps: f64) -> Vec<String> {
    let curve = Curve::of(&case["light"]);
    let rows = |value: &Value| value.as_array().expect("an array").clone();
    let (points, expected, answers) = (rows(&case["points"]), rows(&case["expected"]), rows(answers));
    if answers.len() != points.len() {
        return vec![format!("{} answers for {} points", answers.len(), points.len())];
    }
    let each = points.iter().zip(&expected).zip(&answers);
    each.enumerate()
        .filter_map(|(i, ((point, expected), answer))| {
            let why = disagreement(&curve, vector(point), expected, answer, direction, eps)?;
            Some(format!("{} point {i}: {why}\n  {expected}\n  {answer}", case["light"]["name"]))
        })
        .collect()
}

fn disagreement(
    curve: &Curve,
    point: DVec3,
    expected: &Value,
    answer: &Value,
    direction: &str,
    eps: f64,
) -> Option<String> {
    let mut errors = Vec::new();
    let mut check = |what: &str, error: f64, bound: f64| {
        // NaN is in no range.
        if !(-bound..=bound).contains(&error) {
            errors.push(format!("{what} off by {error:.3e}, bound {bound:.3e}"));
        }
    };
    let (roots, found) = (numbers(&expected["roots"]), numbers(&answer["roots"]));
    if expected["inside"] != answer["inside"] || roots.len() != found.len() {
        return Some("another number of roots".into());
    }
    for (t, found) in roots.iter().zip(&found) {
        check("root", found - t, 16.0 * eps * curve.conditioning(point, *t).0);
    }
    if expected["inside"] == true {
        if expected["segment"] != answer["segment"] {
            return Some("another segment".into());
        }
        let off = |field: &str| number(&answer[field]) - number(&expected[field]);
        let (cond, radius_derivative) = curve.conditioning(point, number(&expected["t"]));
        let bound = 16.0 * eps * cond;
        check("t", off("t"), bound);
        check("u", off("u"), bound);
        let size_over_radius = curve.size() * curve.scale / number(&expected["radius"]);
        check("v", off("v"), bound * size_over_radius);
        check("w", off("w"), bound * size_over_radius);
        let largest = curve.radii.iter().copied().fold(0.0, f64::max);
        check("radius", off("radius"), curve.scale * (radius_derivative.abs() * bound + 16.0 * eps * largest));
        let turned = vector(&answer["direction"]).distance(vector(&expected[direction]));
        check("direction", turned, bound);
    }
    (!errors.is_empty()).then(|| errors.join(", "))
}

fn cases() -> Vec<Value> {
    let fixture: Value = serde_json::from_str(include_str!("fixtures/eval.json")).expect("the fixture");
    let cases = fixture["cases"].as_array().expect("cases").clone();
    assert!(cases.len() == 36 && cases.iter().all(|case| case["points"].as_array().expect("points").len() == 24));
    cases
}

/// Runs `bendylights eval` on a case's points, with the `direction` of its light set.
fn eval(folder: &Folder, case: &Value, direction: &str, on: &str) -> Value {
    let mut light = case["light"].clone();
    light["direction"] = json!(direction);
    let light = folder.file("light.json", light.to_string());
    let points = folder.file("points.json", case["points"].to_string());
    json_of(&["eval", &light, &points, "--on", on])
}

/// Asserts that every case, with both directions, is within its bounds.
fn agrees(on: &str, eps: f64) {
    let folder = Folder::new();
    let mut wrong = Vec::new();
    for case in cases() {
        for direction in ["tube", "path"] {
            let answers = eval(&folder, &case, direction, on);
            wrong.extend(disagreements(&case, &answers, &format!("direction_{direction}"), eps));
        }
    }
    assert!(wrong.is_empty(), "{} answers on {on} lie outside their bounds:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn f64_agrees_with_50_digits() {
    agrees("f64", EPS_F64);
}

#[test]
fn f32_agrees_with_50_digits() {
    agrees("f32", EPS_F32);
}

#[test]
fn gpu_agrees_with_50_digits() {
    agrees("gpu", EPS_F32);
}

/// The comparison above detects each of these faults.
#[test]
fn planted_faults_are_caught() {
    let folder = Folder::new();
    let case = &cases()[0];
    let (curve, point) = (Curve::of(&case["light"]), vector(&case["points"][0]));
    let right = eval(&folder, case, "tube", "f64");
    assert_eq!(disagreements(case, &right, "direction_tube", EPS_F64), [""; 0]);
    let caught = |what: &str, spoil: &dyn Fn(&mut Value)| {
        let mut answers = right.clone();
        spoil(&mut answers[0]);
        let wrong = disagreements(case, &answers, "direction_tube", EPS_F64);
        assert!(wrong.len() == 1 && wrong[0].contains("point 0"), "{what}: {wrong:?}");
    };
    let nudge = |value: &mut Value, by: f64| *value = json!(number(value) + by);
    let (cond, _) = curve.conditioning(point, number(&right[0]["t"]));
    caught("t is 64 eps cond off", &|answer| nudge(&mut answer["t"], 64.0 * EPS_F64 * cond));
    caught("a root is 64 eps cond off", &|answer| nudge(&mut answer["roots"][0], 64.0 * EPS_F64 * cond));
    caught("the radius is a millionth off", &|answer| nudge(&mut answer["radius"], 1e-6));
    caught("the direction is 64 eps cond off", &|answer| {
        nudge(&mut answer["direction"][0], 64.0 * EPS_F64 * cond);
    });
    caught("w has the other sign", &|answer| answer["w"] = json!(-number(&answer["w"])));
    caught("v is not a number", &|answer| answer["v"] = json!(f64::MAX));
    caught("a root too many", &|answer| answer["roots"] = json!([0.5, number(&answer["t"])]));
    caught("the next segment", &|answer| answer["segment"] = json!(2));
    caught("outside", &|answer| *answer = json!({"inside": false, "roots": []}));
    assert!(!disagreements(case, &right, "direction_path", EPS_F64).is_empty(), "the two directions are told apart");
}
