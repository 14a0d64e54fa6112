//! Rows of the parameter table: a parameter apart from its value.
//!
//! Commands, their undo, JSON and its schema, the document's hash, the page's fields and the renderer's caches all
//! follow from the row. [`crate::parameters`] has the rows.

use std::convert::Infallible;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Bound, Deref, RangeBounds};

use glam::{DQuat, DVec3};

use crate::{LightError, Links, MAX_KNOTS, MAX_LINK_BYTES, MAX_LINKS, PeriodicCurve};

/// Maximum length of a name in bytes.
pub const MAX_NAME_BYTES: usize = 256;

/// Largest distance from the scene's centre of anything that is drawn, in world units. Its square, and products of that
/// with intensities, stay within f32.
pub const MAX_EXTENT: f64 = 1e15;

/// Parameter of lights, control points or cameras: a row of the parameter table (`parameters.rs`).
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Name of the parameter in commands, files and logs, in camelCase.
    pub name: &'static str,
    /// Position of the value in its owner's JSON, with dots between nested fields. For a control point, the name of the
    /// list that has one value for each.
    pub path: &'static str,
    /// Types of lights, or other objects, that have the parameter.
    pub owners: &'static [ParameterOf],
    /// Type and range of the parameter's values.
    pub kind: ParameterKind,
    /// True if keyframes may drive the parameter.
    pub animates: bool,
    /// Condition on another parameter, without which this one has no effect. `None` if it always has an effect.
    pub needs: Option<ParameterNeeds>,
    /// Heading of the group in which the page shows the parameter.
    pub group: &'static str,
    /// Name of the parameter for people.
    pub label: &'static str,
    /// Sentence about the parameter for people.
    pub doc: &'static str,
}

/// Entry of a parameter for one kind of object that has it, with its default there.
#[derive(Clone, Copy, Debug)]
pub struct ParameterOf {
    pub owner: ParameterOwner,
    /// Value of the parameter if none is given; `None` if a value is required. Hashes leave out values at their
    /// default, so that a new parameter changes no earlier hash. A default never changes.
    pub default: Option<Value<&'static str>>,
    /// Caches of such an object that a change of the parameter invalidates.
    pub touches: ParameterTouches,
}

/// Condition on another parameter of the same object, without which a parameter has no effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterNeeds {
    /// Name of the other parameter.
    pub parameter: &'static str,
    pub value: ParameterNeeded,
}

/// Values of the other parameter that meet a `ParameterNeeds` condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterNeeded {
    OneOf(&'static [Value<&'static str>]),
    NoneOf(&'static [Value<&'static str>]),
}

impl ParameterNeeded {
    /// Returns true if the value meets the condition.
    pub fn is_met_by(&self, value: &Value) -> bool {
        let has = |values: &[Value<&'static str>]| values.iter().any(|one| one.to_value() == *value);
        match self {
            Self::OneOf(values) => has(values),
            Self::NoneOf(values) => !has(values),
        }
    }
}

/// Kinds of objects that have parameters. Hashes of lights begin with the number of the light's kind. So these numbers
/// never change, and a new kind gets the last number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterOwner {
    Spot,
    Bendy,
    /// Control point of a BendyLight.
    Point,
    Camera,
    Directional,
    Omni,
}

impl ParameterOwner {
    pub(crate) const COUNT: usize = Self::Omni as usize + 1;

    /// All owners, in the order of their numbers.
    pub(crate) const ALL: [Self; Self::COUNT] =
        [Self::Spot, Self::Bendy, Self::Point, Self::Camera, Self::Directional, Self::Omni];
}

/// Cached data of a light that a change of a parameter invalidates. Each value includes the ones before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ParameterTouches {
    /// Nothing: no picture shows the parameter.
    Nothing,
    /// Weights of the light's layers in the picture.
    Weight,
    /// Layers of the light: its radiance in the picture.
    Radiance,
    /// Shadow map of the light.
    ShadowMap,
    /// Everything: the change gives another scene.
    Scene,
}

/// Types of parameter values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    Number(NumberRange),
    Flag,
    Choice(&'static [ParameterChoice]),
    Color,
    Vector {
        /// Unit, or empty.
        unit: &'static str,
        /// Step of a control.
        step: f64,
    },
    /// Unit quaternion `[x, y, z, w]`.
    Rotation,
    /// Text in UTF-8.
    Text {
        max_bytes: usize,
    },
    /// Some nodes of the scene, or all of them.
    Links,
    /// Number over an angle in degrees, or none.
    PeriodicCurve {
        /// Least number at any angle.
        min: f64,
        /// Largest number at any angle.
        max: f64,
        /// Step of a control.
        step: f64,
        /// Meaning of an absent value, for people.
        absent: &'static str,
    },
    /// Projection of a camera, as a whole.
    Projection,
}

/// Range of a number, with the settings of the control by which people change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    /// Unit, or empty.
    pub unit: &'static str,
    /// Lower bound.
    pub min: Bound<f64>,
    /// Upper bound.
    pub max: Bound<f64>,
    /// Ends of a slider; `None` for no slider.
    pub slider: Option<[f64; 2]>,
    /// Step of a control.
    pub step: f64,
    pub scale: ParameterScale,
    /// Meaning of an absent value, for people; `None` if a value is required.
    pub absent: Option<&'static str>,
}

/// Scale of a slider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterScale {
    Linear,
    Logarithmic,
}

/// One of the words of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterChoice {
    /// Name in files.
    pub name: &'static str,
    /// Name for people.
    pub label: &'static str,
}

/// Types that store values of varying size. `String` allows every kind of value. A static string serves for defaults
/// in constants, which can have text but no lists.
pub trait ValueStorage {
    /// Type that stores values of [`ParameterKind::Links`].
    type Links;
    /// Type that stores values of [`ParameterKind::PeriodicCurve`].
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

/// Value of any parameter. `S` stores text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<S: ValueStorage = String> {
    /// Value of [`ParameterKind::Number`].
    Number(f64),
    /// Value that is left out: of an optional [`ParameterKind::Number`] or [`ParameterKind::PeriodicCurve`]. For
    /// [`ParameterKind::Links`] it means all nodes.
    Absent,
    /// Value of [`ParameterKind::Flag`].
    Flag(bool),
    /// Value of [`ParameterKind::Choice`]: the choice's name.
    Choice(&'static str),
    /// Value of [`ParameterKind::Color`] or [`ParameterKind::Vector`].
    Vector(DVec3),
    /// Value of [`ParameterKind::Rotation`].
    Rotation(DQuat),
    /// Value of [`ParameterKind::Text`].
    Text(S),
    /// Value of [`ParameterKind::Links`].
    Links(S::Links),
    /// Value of [`ParameterKind::PeriodicCurve`].
    PeriodicCurve(S::PeriodicCurve),
}

impl Value<&'static str> {
    /// Converts to a value with owned text.
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

/// Parameter, with a value to set it to.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    pub parameter: &'static Parameter,
    pub value: Value,
}

impl fmt::Debug for Parameter {
    /// Writes the path alone, because output of changes and commands would otherwise contain all fields of each
    /// parameter.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.path)
    }
}

impl PartialEq for Parameter {
    /// Compares name and path, which together identify a parameter.
    fn eq(&self, other: &Self) -> bool {
        (self.name, self.path) == (other.name, other.path)
    }
}

/// Parameter whose values have the Rust type `T`.
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
    /// Makes a key. The values of `row` must have the type `T`.
    pub const fn new(row: &'static Parameter) -> Self {
        Self { row, of: PhantomData }
    }

    pub const fn row(self) -> &'static Parameter {
        self.row
    }
}

impl<T: ValueType> ParameterKey<T> {
    /// Pairs the parameter with a value to set it to.
    pub fn to(self, value: T) -> Setting {
        Setting { parameter: self.row, value: value.into_value() }
    }
}

/// Rust type of parameter values.
pub trait ValueType: Sized {
    fn into_value(self) -> Value;
    /// Converts a value; `None` if it has another type.
    fn from_value(value: &Value) -> Option<Self>;
}

/// Implements [`ValueType`] for the types of some kinds of [`Value`].
macro_rules! value_types {
    ($($type:ty => $kind:ident;)+) => {$(
        impl ValueType for $type {
            fn into_value(self) -> Value {
                Value::$kind(self)
            }

            fn from_value(value: &Value) -> Option<Self> {
                if let Value::$kind(value) = value { Some(Self::clone(value)) } else { None }
            }
        }
    )+};
}

value_types! {
    f64 => Number;
    bool => Flag;
    DVec3 => Vector;
    DQuat => Rotation;
    String => Text;
    Links => Links;
    PeriodicCurve => PeriodicCurve;
}

impl<T: ValueType> ValueType for Option<T> {
    fn into_value(self) -> Value {
        self.map_or(Value::Absent, T::into_value)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if *value == Value::Absent { Some(None) } else { T::from_value(value).map(Some) }
    }
}

/// Defines the name and the label of each variant of an enum.
macro_rules! choices {
    ($name:ident { $($variant:ident: $word:literal, $label:literal;)+ }) => {
        impl $name {
            /// Words of all variants.
            pub const CHOICES: &'static [$crate::parameter::ParameterChoice] =
                &[$($crate::parameter::ParameterChoice { name: $word, label: $label }),+];

            /// Returns the word of the variant in files.
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
    /// Returns true if pictures show the parameter for other owners but not for `owner`.
    pub fn has_no_effect_on(&self, owner: ParameterOwner) -> bool {
        let of_owner = self.for_owner(owner).map(|of| of.touches);
        of_owner == Some(ParameterTouches::Nothing) && self.touches() != ParameterTouches::Nothing
    }

    /// Returns the caches that a change of the parameter invalidates for any of its owners: the maximum over all.
    pub fn touches(&self) -> ParameterTouches {
        self.owners.iter().map(|of| of.touches).max().unwrap_or(ParameterTouches::Nothing)
    }

    /// Returns the parameter's entry for an owner; `None` if the owner does not have the parameter.
    pub fn for_owner(&self, owner: ParameterOwner) -> Option<&ParameterOf> {
        self.owners.iter().find(|of| of.owner == owner)
    }

    /// Returns the default for an owner; `None` if the owner requires a value or does not have the parameter.
    pub fn default(&self, owner: ParameterOwner) -> Option<Value> {
        Some(self.for_owner(owner)?.default?.to_value())
    }

    /// Returns true if a value has the parameter's type, in range or not.
    pub fn accepts_type_of(&self, value: &Value) -> bool {
        !matches!(self.check(value), Err(LightError::WrongType { .. }))
    }

    /// Checks that a value has the right type, is finite, in range and not too long.
    pub fn check(&self, value: &Value) -> Result<(), LightError> {
        let field = self.path;
        match (&self.kind, value) {
            (ParameterKind::Number(number), Value::Absent) if number.absent.is_some() => Ok(()),
            (ParameterKind::Number(number), Value::Number(value)) => number.check(field, *value),
            (ParameterKind::PeriodicCurve { min, max, .. }, Value::PeriodicCurve(curve)) => {
                let number = NumberRange { min: Bound::Included(*min), max: Bound::Included(*max), ..NumberRange::ANY };
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
            (ParameterKind::Choice(choices), Value::Choice(name)) if choices.iter().any(|c| c.name == *name) => Ok(()),
            (ParameterKind::Color | ParameterKind::Vector { .. }, Value::Vector(vector)) => {
                if vector.is_finite() {
                    Ok(())
                } else {
                    Err(LightError::NotFinite(field))
                }
            }
            (ParameterKind::Rotation, Value::Rotation(rotation)) if !rotation.is_finite() => {
                Err(LightError::NotFinite(field))
            }
            (ParameterKind::Rotation, Value::Rotation(rotation)) => {
                // Rounding may leave a unit quaternion slightly off. A larger deviation cannot be due to rounding.
                let length = rotation.length();
                let is_unit = (0.5..=2.0).contains(&length);
                if is_unit { Ok(()) } else { Err(LightError::NotARotation { field, length }) }
            }
            (ParameterKind::Text { max_bytes }, Value::Text(text)) => {
                if text.len() <= *max_bytes {
                    Ok(())
                } else {
                    Err(LightError::TooLong { field, limit: *max_bytes })
                }
            }
            (ParameterKind::Links, Value::Links(links)) => match links.size() {
                (count, _) if count > MAX_LINKS => Err(LightError::TooManyLinks { field, count, limit: MAX_LINKS }),
                (_, bytes) if bytes > MAX_LINK_BYTES => Err(LightError::TooLong { field, limit: MAX_LINK_BYTES }),
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

    /// Checks that a value of `field` is finite and in range.
    fn check(&self, field: &'static str, value: f64) -> Result<(), LightError> {
        if !value.is_finite() {
            return Err(LightError::NotFinite(field));
        }
        if (self.min, self.max).contains(&value) {
            return Ok(());
        }
        Err(LightError::OutOfDomain { field, value, domain: self.domain() })
    }

    /// Describes the range, as the end of a sentence.
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
    /// Describes the expected type, as the end of a sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) if number.absent.is_some() => f.write_str("a number or null"),
            Self::Number(_) => f.write_str("a number"),
            Self::Choice(choices) => {
                let names: Vec<_> = choices.iter().map(|choice| format!("\"{}\"", choice.name)).collect();
                let (last, others) = names.split_last().ok_or(fmt::Error)?;
                if others.is_empty() { f.write_str(last) } else { write!(f, "{} or {last}", others.join(", ")) }
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
