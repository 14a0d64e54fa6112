//! Cache keys: digests of a light's values.

use std::fmt;

use sha2::{Digest as _, Sha256};

use crate::{Light, Parameter, ParameterOwner, ParameterTouches, Value};

/// SHA-256 over some of a light's values. Equal values give equal digests.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightDigest(pub [u8; 32]);

/// Digests by which caches identify the data that they keep of a light. A change gives new digests to everything that
/// it touches ([`ParameterTouches`]), and an undo restores the earlier digests.
///
/// They are computed from the values themselves. A counter of changes would give one number to two different contents,
/// because a drag and an edit can both start from one document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revisions {
    /// Digest of the values that the shadow map depends on, besides the scene.
    pub shadow_map: LightDigest,
    /// Digest of the values that the radiance towards the eye depends on, the shadow map included, but not on the
    /// factors by which all of the radiance is multiplied
    /// ([`LightProfile::lobe_weights`](crate::LightProfile::lobe_weights)).
    pub radiance: LightDigest,
    /// Digest of the values that the picture depends on, including the factors that `radiance` leaves out.
    pub picture: LightDigest,
    /// Digest of all values.
    pub content: LightDigest,
}

impl Revisions {
    pub(crate) fn of(light: &Light) -> Self {
        let digest = |least| digest(light, least);
        Self {
            shadow_map: digest(ParameterTouches::ShadowMap),
            radiance: digest(ParameterTouches::Radiance),
            picture: digest(ParameterTouches::Weight),
            content: digest(ParameterTouches::Nothing),
        }
    }
}

impl fmt::Debug for LightDigest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(const_hex::const_encode::<32, false>(&self.0).as_str())
    }
}

/// Computes the digest of the shape, by its number in [`ParameterOwner`], and of the values of parameters that touch
/// `least` or more.
///
/// Values at their default are left out, so that a new parameter changes no earlier digest. -0 counts as 0. The length
/// of a value of variable length comes first.
fn digest(light: &Light, least: ParameterTouches) -> LightDigest {
    let owner = light.owner();
    let mut writer = DigestWriter(Sha256::new());
    writer.0.update([owner as u8]);
    let mut values: Vec<_> = light.values().collect();
    values.sort_unstable_by_key(|(row, _)| row.name);
    for (row, value) in values {
        if is_touched(row, owner, least) && row.default(owner).as_ref() != Some(value) {
            writer.text(row.name);
            writer.value(value);
        }
    }
    let points = light.points();
    writer.number(points.len() as u64);
    let mut rows = crate::parameters_of(ParameterOwner::Point).to_vec();
    rows.sort_unstable_by_key(|row| row.name);
    for row in rows.into_iter().filter(|row| is_touched(row, ParameterOwner::Point, least)) {
        let values: Vec<_> = points.iter().filter_map(|point| point.value(row)).collect();
        if values.iter().any(|value| row.default(ParameterOwner::Point).as_ref() != Some(value)) {
            writer.text(row.name);
            for value in &values {
                writer.value(value);
            }
        }
    }
    LightDigest(writer.0.finalize().into())
}

fn is_touched(row: &Parameter, owner: ParameterOwner, least: ParameterTouches) -> bool {
    row.for_owner(owner).is_some_and(|of| of.touches >= least)
}

struct DigestWriter(Sha256);

impl DigestWriter {
    fn number(&mut self, number: u64) {
        self.0.update(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.0.update(text);
    }

    fn reals(&mut self, reals: &[f64]) {
        for real in reals {
            // Adding 0 turns -0 into 0 and changes no other number.
            self.0.update((real + 0.0).to_bits().to_le_bytes());
        }
    }

    fn value(&mut self, value: &Value) {
        match value {
            Value::Number(number) => self.reals(&[*number]),
            // NaN is not a valid value of any parameter.
            Value::Absent => self.reals(&[f64::NAN]),
            Value::Flag(flag) => self.0.update([u8::from(*flag)]),
            Value::Choice(name) => self.text(name),
            Value::Vector(vector) => self.reals(&vector.to_array()),
            Value::Rotation(rotation) => self.reals(&rotation.to_array()),
            Value::Text(text) => self.text(text),
            Value::PeriodicCurve(curve) => {
                self.number(curve.knots().len() as u64);
                curve.knots().iter().for_each(|knot| self.reals(knot));
            }
            Value::Links(links) => {
                for paths in [links.include(), links.exclude()] {
                    self.number(paths.len() as u64);
                    for path in paths {
                        self.text(path);
                    }
                }
            }
        }
    }
}
