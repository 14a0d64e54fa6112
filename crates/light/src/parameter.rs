//! What can be set, a row each: a parameter apart from its value.
//!
//! A row says all that anybody needs to know of a parameter: commands, the undo of them, JSON and its schema, the document's
//! hash, the page's fields and the renderer's caches follow from it. [`crate::parameters`] has the rows.

use std::convert::Infallible;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Bound, Deref, RangeBounds};

use glam::{DQuat, DVec3};

use crate::{LightError, Links, MAX_KNOTS, MAX_LINK_BYTES, MAX_LINKS, PeriodicCurve};

/// Bytes that a name has at most.
pub const MAX_NAME_BYTES: usize = 256;

/// Largest distance from the scene's middle of anything that is drawn, in world units: squares of it, and their
/// products with intensities, stay within f32.
pub const MAX_EXTENT: f64 = 1e15;

/// A row of the table.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// The word for it in commands, files and logs, in camelCase.
    pub name: &'static str,
    /// Where its value stands in its owner's JSON, fields within fields parted by dots. Of a control point, the list that
    /// has one value for each.
    pub path: &'static str,
    /// What has it.
    pub owners: &'static [ParameterOf],
    /// What its values are.
    pub kind: ParameterKind,
    /// Whether keyframes may drive it.
    pub animates: bool,
    /// What another has to be for it to have an effect; `None` where it always has.
    pub needs: Option<ParameterNeeds>,
    /// The heading that it stands under, for people.
    pub group: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// A sentence about it, for people.
    pub doc: &'static str,
}

/// One kind of thing that has a parameter.
#[derive(Clone, Copy, Debug)]
pub struct ParameterOf {
    /// What has it.
    pub owner: ParameterOwner,
    /// The value where none is given; `None` where one has to be. Hashes leave out what has its default, so that a new
    /// parameter changes no old hash: a default never changes.
    pub default: Option<Value<&'static str>>,
    /// What a change of it makes stale.
    pub touches: ParameterTouches,
}

/// What another parameter of the same owner has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterNeeds {
    /// The other's name.
    pub parameter: &'static str,
    /// Its value.
    pub value: ParameterNeeded,
}

/// Values of which one is needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterNeeded {
    /// One of these.
    OneOf(&'static [Value<&'static str>]),
    /// Any but these.
    NoneOf(&'static [Value<&'static str>]),
}

impl ParameterNeeded {
    /// Whether this value will do.
    pub fn is_met_by(&self, value: &Value) -> bool {
        let has = |values: &[Value<&'static str>]| values.iter().any(|one| one.to_value() == *value);
        match self {
            Self::OneOf(values) => has(values),
            Self::NoneOf(values) => !has(values),
        }
    }
}

/// What can have parameters. Hashes of lights begin with its number, so that none ever changes: new ones come last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterOwner {
    /// A spotlight.
    Spot,
    /// A BendyLight.
    Bendy,
    /// A control point of a BendyLight.
    Point,
    /// A camera.
    Camera,
    /// A directional light.
    Directional,
    /// An omni light.
    Omni,
}

impl ParameterOwner {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::Omni as usize + 1;

    /// Every one, in the order of their numbers.
    pub(crate) const ALL: [Self; Self::COUNT] =
        [Self::Spot, Self::Bendy, Self::Point, Self::Camera, Self::Directional, Self::Omni];
}

/// What a change makes stale of what is kept of a light from picture to picture; each includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ParameterTouches {
    /// Nothing: no picture shows it.
    Nothing,
    /// By which factors it adds what it adds to the picture.
    Weight,
    /// What the light adds to the picture.
    Radiance,
    /// Its shadow map.
    ShadowMap,
    /// Everything: the scene is another.
    Scene,
}

/// What the values of a parameter are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A number.
    Number(NumberRange),
    /// Yes or no.
    Flag,
    /// One of several words.
    Choice(&'static [ParameterChoice]),
    /// Linear RGB.
    Color,
    /// Three numbers.
    Vector {
        /// What they count, if anything.
        unit: &'static str,
        /// What a step of a control changes one by.
        step: f64,
    },
    /// A unit quaternion `[x, y, z, w]`.
    Rotation,
    /// Text of at most so many bytes of UTF-8.
    Text {
        /// So many.
        max_bytes: usize,
    },
    /// Some nodes of the scene, or all of them.
    Links,
    /// A number over an angle in degrees, or none.
    PeriodicCurve {
        /// The least that it may be anywhere.
        min: f64,
        /// The most.
        max: f64,
        /// What a step of a control changes one by.
        step: f64,
        /// What it means that there is none, for people.
        absent: &'static str,
    },
    /// How a camera projects, as a whole.
    Projection,
}

/// The numbers that a parameter may have, and how a control offers them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    /// What it counts, if anything.
    pub unit: &'static str,
    /// What is refused below.
    pub min: Bound<f64>,
    /// What is refused above.
    pub max: Bound<f64>,
    /// The ends of a slider, where one makes sense.
    pub slider: Option<[f64; 2]>,
    /// What a step of a control changes it by.
    pub step: f64,
    /// How a slider is divided.
    pub scale: ParameterScale,
    /// What it means that there is none, for people; `None` where there has to be one.
    pub absent: Option<&'static str>,
}

/// How a slider is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterScale {
    /// Evenly.
    Linear,
    /// Evenly in the logarithm.
    Logarithmic,
}

/// One of the words that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterChoice {
    /// As in files.
    pub name: &'static str,
    /// For people.
    pub label: &'static str,
}

/// What holds values that vary in size: memory of their own, or the program, which has text but no lists.
pub trait ValueStorage {
    /// Of [`ParameterKind::Links`].
    type Links;
    /// Of [`ParameterKind::PeriodicCurve`].
    type PeriodicCurve;
}

impl ValueStorage for String {
    type Links = Links;
    type PeriodicCurve = PeriodicCurve;
}

impl ValueStorage for &'static str {
    type Links = Infallible;
    type PeriodicCurve = Infallible;
}

/// A value of any parameter; `S` holds text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<S: ValueStorage = String> {
    /// Of [`ParameterKind::Number`].
    Number(f64),
    /// Of [`ParameterKind::Number`] and [`ParameterKind::PeriodicCurve`], where it is optional and absent; of [`ParameterKind::Links`] all nodes.
    Absent,
    /// Of [`ParameterKind::Flag`].
    Flag(bool),
    /// Of [`ParameterKind::Choice`]: the choice's name.
    Choice(&'static str),
    /// Of [`ParameterKind::Color`] and [`ParameterKind::Vector`].
    Vector(DVec3),
    /// Of [`ParameterKind::Rotation`].
    Rotation(DQuat),
    /// Of [`ParameterKind::Text`].
    Text(S),
    /// Of [`ParameterKind::Links`].
    Links(S::Links),
    /// Of [`ParameterKind::PeriodicCurve`].
    PeriodicCurve(S::PeriodicCurve),
}

impl Value<&'static str> {
    /// The same with text of its own.
    pub fn to_value(self) -> Value {
        match self {
            Self::Number(number) => Value::Number(number),
            Self::Absent => Value::Absent,
            Self::Flag(flag) => Value::Flag(flag),
            Self::Choice(name) => Value::Choice(name),
            Self::Vector(vector) => Value::Vector(vector),
            Self::Rotation(rotation) => Value::Rotation(rotation),
            Self::Text(text) => Value::Text(text.into()),
            Self::Links(never) | Self::PeriodicCurve(never) => match never {},
        }
    }
}

/// A parameter and a value for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What is set.
    pub parameter: &'static Parameter,
    /// What it is set to.
    pub value: Value,
}

impl fmt::Debug for Parameter {
    /// Its path alone: changes and commands carry whole rows.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.path)
    }
}

impl PartialEq for Parameter {
    /// Whether it is the same row; of one owner no two have one name.
    fn eq(&self, other: &Self) -> bool {
        (self.name, self.path) == (other.name, other.path)
    }
}

/// A parameter whose values have the Rust type `T`.
#[derive(Debug)]
pub struct ParameterKey<T> {
    row: &'static Parameter,
    of: PhantomData<fn() -> T>,
}

impl<T> Clone for ParameterKey<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for ParameterKey<T> {}

impl<T> Deref for ParameterKey<T> {
    type Target = Parameter;

    fn deref(&self) -> &Parameter {
        self.row
    }
}

impl<T> ParameterKey<T> {
    /// The values of `row` are of type `T`.
    pub const fn new(row: &'static Parameter) -> Self {
        Self { row, of: PhantomData }
    }

    /// The row itself.
    pub const fn row(self) -> &'static Parameter {
        self.row
    }
}

impl<T: ValueType> ParameterKey<T> {
    /// This parameter, set to `value`.
    pub fn to(self, value: T) -> Setting {
        Setting { parameter: self.row, value: value.into_value() }
    }
}

/// A Rust type that values have.
pub trait ValueType: Sized {
    /// The value.
    fn into_value(self) -> Value;
    /// What a value is; `None` for a value of another type.
    fn from_value(value: &Value) -> Option<Self>;
}

impl ValueType for f64 {
    fn into_value(self) -> Value {
        Value::Number(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Number(number) = value { Some(*number) } else { None }
    }
}

impl ValueType for Option<f64> {
    fn into_value(self) -> Value {
        self.map_or(Value::Absent, Value::Number)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(number) => Some(Some(*number)),
            Value::Absent => Some(None),
            _ => None,
        }
    }
}

impl ValueType for bool {
    fn into_value(self) -> Value {
        Value::Flag(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Flag(flag) = value { Some(*flag) } else { None }
    }
}

impl ValueType for DVec3 {
    fn into_value(self) -> Value {
        Value::Vector(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Vector(vector) = value { Some(*vector) } else { None }
    }
}

impl ValueType for DQuat {
    fn into_value(self) -> Value {
        Value::Rotation(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Rotation(rotation) = value { Some(*rotation) } else { None }
    }
}

impl ValueType for String {
    fn into_value(self) -> Value {
        Value::Text(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Text(text) = value { Some(text.clone()) } else { None }
    }
}

impl ValueType for Option<Links> {
    fn into_value(self) -> Value {
        self.map_or(Value::Absent, Value::Links)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Links(links) => Some(Some(links.clone())),
            Value::Absent => Some(None),
            _ => None,
        }
    }
}

impl ValueType for Option<PeriodicCurve> {
    fn into_value(self) -> Value {
        self.map_or(Value::Absent, Value::PeriodicCurve)
    }

    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::PeriodicCurve(curve) => Some(Some(curve.clone())),
            Value::Absent => Some(None),
            _ => None,
        }
    }
}

/// Gives an enum its words.
macro_rules! choices {
    ($name:ident { $($variant:ident: $word:literal, $label:literal;)+ }) => {
        impl $name {
            /// The words for its variants.
            pub const CHOICES: &'static [$crate::parameter::ParameterChoice] =
                &[$($crate::parameter::ParameterChoice { name: $word, label: $label }),+];

            /// The word for it, as in files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl $crate::parameter::ValueType for $name {
            fn into_value(self) -> $crate::Value {
                $crate::Value::Choice(self.name())
            }

            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $($crate::Value::Choice($word) => Some(Self::$variant),)+
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use choices;

impl Parameter {
    /// Whether a picture shows it of others but not of `owner`.
    pub fn has_no_effect_on(&self, owner: ParameterOwner) -> bool {
        let of_owner = self.for_owner(owner).map(|of| of.touches);
        of_owner == Some(ParameterTouches::Nothing) && self.touches() != ParameterTouches::Nothing
    }

    /// What a change of it makes stale, whatever has it.
    pub fn touches(&self) -> ParameterTouches {
        self.owners.iter().map(|of| of.touches).max().unwrap_or(ParameterTouches::Nothing)
    }

    /// How `owner` has it; `None` where it has no such parameter.
    pub fn for_owner(&self, owner: ParameterOwner) -> Option<&ParameterOf> {
        self.owners.iter().find(|of| of.owner == owner)
    }

    /// The value that `owner` has where none is given; `None` where one has to be, or it has no such parameter.
    pub fn default(&self, owner: ParameterOwner) -> Option<Value> {
        Some(self.for_owner(owner)?.default?.to_value())
    }

    /// Whether a value is of its type, in range or not.
    pub fn accepts_type_of(&self, value: &Value) -> bool {
        !matches!(self.check(value), Err(LightError::WrongType { .. }))
    }

    /// Refuses a value that no owner may have: of another type, not finite, out of range, too long.
    pub fn check(&self, value: &Value) -> Result<(), LightError> {
        let field = self.path;
        match (&self.kind, value) {
            (ParameterKind::Number(number), Value::Absent) if number.absent.is_some() => Ok(()),
            (ParameterKind::Number(number), Value::Number(value)) => number.check(field, *value),
            (ParameterKind::PeriodicCurve { min, max, .. }, Value::PeriodicCurve(curve)) => {
                let number = NumberRange {
                    min: Bound::Included(*min),
                    max: Bound::Included(*max),
                    ..NumberRange::ANY
                };
                let count = curve.knots().len();
                if count > MAX_KNOTS {
                    return Err(LightError::TooManyKnots { field, count, limit: MAX_KNOTS });
                }
                if !curve.is_ascending() {
                    return Err(LightError::UnsortedKnots(field));
                }
                curve.knots().iter().try_for_each(|[_, value]| number.check(field, *value))
            }
            (ParameterKind::Flag, Value::Flag(_))
            | (ParameterKind::Links | ParameterKind::PeriodicCurve { .. }, Value::Absent) => Ok(()),
            (ParameterKind::Choice(choices), Value::Choice(name))
                if choices.iter().any(|c| c.name == *name) =>
            {
                Ok(())
            }
            (ParameterKind::Color | ParameterKind::Vector { .. }, Value::Vector(vector))
                if vector.is_finite() =>
            {
                Ok(())
            }
            (ParameterKind::Color | ParameterKind::Vector { .. }, Value::Vector(_)) => {
                Err(LightError::NotFinite(field))
            }
            (ParameterKind::Rotation, Value::Rotation(rotation)) => {
                if !rotation.is_finite() {
                    return Err(LightError::NotFinite(field));
                }
                // Rounding may leave a unit quaternion a little off; what is far off was meant as something else.
                let length = rotation.length();
                let unit = (0.5..=2.0).contains(&length);
                if unit { Ok(()) } else { Err(LightError::NotARotation { field, length }) }
            }
            (ParameterKind::Text { max_bytes }, Value::Text(text)) if text.len() <= *max_bytes => Ok(()),
            (ParameterKind::Text { max_bytes }, Value::Text(_)) => {
                Err(LightError::TooLong { field, limit: *max_bytes })
            }
            (ParameterKind::Links, Value::Links(links)) => match links.size() {
                (count, _) if count > MAX_LINKS => {
                    Err(LightError::TooManyLinks { field, count, limit: MAX_LINKS })
                }
                (_, bytes) if bytes > MAX_LINK_BYTES => {
                    Err(LightError::TooLong { field, limit: MAX_LINK_BYTES })
                }
                _ => Ok(()),
            },
            _ => Err(LightError::WrongType { field, expected: self.kind.to_string() }),
        }
    }
}

impl NumberRange {
    /// Any number, in steps of 0.01.
    pub const ANY: Self = Self {
        unit: "",
        min: Bound::Unbounded,
        max: Bound::Unbounded,
        slider: None,
        step: 0.01,
        scale: ParameterScale::Linear,
        absent: None,
    };

    /// Refuses a value of `field` that is not finite or out of range.
    fn check(&self, field: &'static str, value: f64) -> Result<(), LightError> {
        if !value.is_finite() {
            return Err(LightError::NotFinite(field));
        }
        if (self.min, self.max).contains(&value) {
            return Ok(());
        }
        Err(LightError::OutOfDomain { field, value, domain: self.domain() })
    }

    /// The range, as the end of a sentence.
    fn domain(&self) -> String {
        use Bound::{Excluded, Included, Unbounded};
        let unit = |x: f64| if self.unit.is_empty() { x.to_string() } else { format!("{x} {}", self.unit) };
        match (self.min, self.max) {
            (Included(min), Included(max)) => format!("it must lie from {min} to {}", unit(max)),
            (Excluded(min), Excluded(max)) => {
                format!("it must be more than {min} and less than {}", unit(max))
            }
            (Included(min), Excluded(max)) => format!("it must be {min} or more and less than {}", unit(max)),
            (Excluded(min), Included(max)) => format!("it must be more than {min} and at most {}", unit(max)),
            (Included(min), Unbounded) => format!("it must be {} or more", unit(min)),
            (Excluded(min), Unbounded) => format!("it must be more than {}", unit(min)),
            (Unbounded, Included(max)) => format!("it must be at most {}", unit(max)),
            (Unbounded, Excluded(max)) => format!("it must be less than {}", unit(max)),
            (Unbounded, Unbounded) => "it must be a number".into(),
        }
    }
}

impl fmt::Display for ParameterKind {
    /// What is expected, as the end of a sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) if number.absent.is_some() => f.write_str("a number or null"),
            Self::Number(_) => f.write_str("a number"),
            Self::Choice(choices) => {
                let names: Vec<_> = choices.iter().map(|choice| format!("\"{}\"", choice.name)).collect();
                let (last, others) = names.split_last().ok_or(fmt::Error)?;
                if others.is_empty() {
                    f.write_str(last)
                } else {
                    write!(f, "{} or {last}", others.join(", "))
                }
            }
            Self::Flag => f.write_str("true or false"),
            Self::Color => f.write_str("three numbers [r, g, b]"),
            Self::Vector { .. } => f.write_str("three numbers [x, y, z]"),
            Self::Rotation => f.write_str("four numbers [x, y, z, w]"),
            Self::Text { .. } => f.write_str("text"),
            Self::Links => f.write_str("null or an object {include, exclude} with lists of nodes' paths"),
            Self::PeriodicCurve { .. } => f.write_str("null or a list of pairs [degrees, number]"),
            Self::Projection => f.write_str(
                r#"{"perspective": {"yfov", "znear"}} or {"orthographic": {"ymag", "znear", "zfar"}}, with numbers"#,
            ),
        }
    }
}
