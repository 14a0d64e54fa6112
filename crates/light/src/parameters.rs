//! Parameter table of lights and control points.
//!
//! Names are those of UsdLux if it has them, else of glTF. A new parameter takes a row here, its formula in f64 and in
//! WGSL, and a test of the formula. Nothing else names it.

use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};

use crate::parameter::{
    MAX_EXTENT, MAX_NAME_BYTES, NumberRange, Parameter, ParameterKey, ParameterKind, ParameterNeeded, ParameterNeeds,
    ParameterOf, ParameterOwner, ParameterScale, ParameterTouches, Setting, Value,
};
use crate::{ControlPoint, CrossSection, Decay, DirectionMode, EndMode, FrameMode, Links, PeriodicCurve, ProfileCurve};

/// Defines parameters of the table, each with a key that has the Rust type of its values.
macro_rules! rows {
    ($list:ident: $($key:ident: $type:ty = $doc:literal, $parameter:expr;)+) => {
        $(
            #[doc = $doc]
            pub const $key: ParameterKey<$type> = {
                static PARAMETER: Parameter = Parameter { doc: $doc, ..$parameter };
                ParameterKey::new(&PARAMETER)
            };
        )+
        static $list: &[&Parameter] = &[$($key.row()),+];
    };
}

/// Makes a row whose path is its name, and which always has an effect. Keyframes drive it unless it is text, a choice
/// or links.
const fn row(
    name: &'static str,
    group: &'static str,
    label: &'static str,
    kind: ParameterKind,
    owners: &'static [ParameterOf],
) -> Parameter {
    let animates = !matches!(kind, ParameterKind::Text { .. } | ParameterKind::Choice(_) | ParameterKind::Links);
    Parameter { name, path: name, owners, kind, animates, needs: None, group, label, doc: "" }
}

impl Parameter {
    /// Returns the row with another path than its name.
    const fn at(self, path: &'static str) -> Self {
        Self { path, ..self }
    }

    /// Returns the row with an effect only if another parameter has one of these values.
    const fn needs_one_of(self, parameter: &'static str, values: &'static [Value<&'static str>]) -> Self {
        Self { needs: Some(ParameterNeeds { parameter, value: ParameterNeeded::OneOf(values) }), ..self }
    }

    /// Returns the row with an effect only if another parameter has none of these values.
    const fn needs_none_of(self, parameter: &'static str, values: &'static [Value<&'static str>]) -> Self {
        Self { needs: Some(ParameterNeeds { parameter, value: ParameterNeeded::NoneOf(values) }), ..self }
    }
}

const SUPERELLIPSE: &[Value<&str>] = &[Value::Choice(CrossSection::Superellipse.name())];

const fn of(owner: ParameterOwner, default: Value<&'static str>, touches: ParameterTouches) -> ParameterOf {
    ParameterOf { owner, default: Some(default), touches }
}

/// Makes the entries of a parameter that all lights have, with the same default.
const fn all_lights(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 4] {
    let [spot, bendy, omni] = source_lights(default, touches);
    [spot, bendy, omni, of(Directional, default, touches)]
}

/// Makes the entries of a parameter that all lights with a source have, with the same default.
const fn source_lights(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 3] {
    let [spot, bendy] = cone_lights(default, touches);
    [spot, bendy, of(Omni, default, touches)]
}

/// Makes the entries of a parameter that all lights with a cone have, with the same default.
const fn cone_lights(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 2] {
    [of(Spot, default, touches), of(Bendy, default, touches)]
}

/// Entry of a parameter that every control point states.
const REQUIRED_OF_POINTS: ParameterOf = ParameterOf { owner: Point, default: None, touches: ShadowMap };

/// Makes the range of a number with a slider, in units of `unit`.
const fn range(unit: &'static str, [min, max]: [Bound<f64>; 2], slider: [f64; 2], step: f64) -> NumberRange {
    NumberRange { unit, min, max, slider: Some(slider), step, ..NumberRange::ANY }
}

/// Range of a share of a whole.
const SHARE: NumberRange = range("", [Included(0.0), Included(1.0)], [0.0, 1.0], 0.01);

/// Range of a factor by which light is multiplied.
const FACTOR: NumberRange = range("", [Included(0.0), Included(1e6)], [0.0, 2.0], 0.05);

/// Range of a length along a light path.
const LENGTH: NumberRange = range("world units", [Included(0.0), Included(MAX_EXTENT)], [0.0, 20.0], 0.05);

/// Range of a half extent of a cross-section, in radii.
const HALF_EXTENT: NumberRange = range("", [Excluded(0.0), Included(1.0)], [0.01, 1.0], 0.01);

/// Makes the type of a size of a light as a whole, which has no limit if it is absent.
const fn size(absent: &'static str) -> ParameterKind {
    let sizes = range("world units", [Excluded(0.0), Unbounded], [0.1, 20.0], 0.05);
    ParameterKind::Number(NumberRange { scale: ParameterScale::Logarithmic, absent: Some(absent), ..sizes })
}

use ParameterKind::{Color, Number, Rotation, Vector};
use ParameterOwner::{Bendy, Directional, Omni, Point, Spot};
use ParameterTouches::{Nothing, Radiance, ShadowMap, Weight};

// Each row: key, type of its values, doc, name, group, label, kind and owners.
rows! { LIGHT_ROWS:
    NAME: String = "Name for people and for `--light`.",
        row("name", "Light", "Name", ParameterKind::Text { max_bytes: MAX_NAME_BYTES },
            &all_lights(Value::Text(""), Nothing));
    TRANSLATION: DVec3 = "World position of the source; of a directional light, of a point of its axis.",
        row("translation", "Light", "Position", Vector { unit: "world units", step: 0.01 },
            &all_lights(Value::Vector(DVec3::ZERO), ShadowMap)).at("transform.translation");
    ROTATION: DQuat = "Rotation from light-local to world axes. Spotlights and directional lights shine along their local -Z.",
        row("rotation", "Light", "Rotation", Rotation,
            &all_lights(Value::Rotation(DQuat::IDENTITY), ShadowMap)).at("transform.rotation");
    SCALE: f64 = "World units per light-local unit. It only matters to a light that is bent.",
        row("scale", "Light", "Scale", Number(range("", [Excluded(0.0), Unbounded], [0.1, 3.0], 0.01)),
            &[
                of(Spot, Value::Number(1.0), Nothing),
                of(Bendy, Value::Number(1.0), ShadowMap),
                of(Omni, Value::Number(1.0), Nothing),
                of(Directional, Value::Number(1.0), Nothing),
            ]).at("transform.scale");
    ENABLED: bool = "Whether it shines.",
        row("enabled", "Light", "Enabled", ParameterKind::Flag, &all_lights(Value::Flag(true), Weight));
    COLOR: DVec3 = "Linear RGB of all that it emits. That of a BendyLight's control points is a factor of it.",
        row("color", "Emission", "Color", Color, &all_lights(Value::Vector(DVec3::ONE), Weight));
    INTENSITY: f64 = "How bright it is: candela with inverse-square decay, lux without. That of a BendyLight's control points is a factor of it.",
        row("intensity", "Emission", "Intensity", Number(range("", [Unbounded, Unbounded], [0.0, 20.0], 0.05)),
            &all_lights(Value::Number(1.0), Weight));
    EXPOSURE: f64 = "Stops by which all that it emits is brightened: a factor of 2 to this.",
        row("exposure", "Emission", "Exposure",
            Number(range("stops", [Included(-100.0), Included(100.0)], [-10.0, 10.0], 0.1)),
            &all_lights(Value::Number(0.0), Weight));
    ENABLE_COLOR_TEMPERATURE: bool = "Whether the color is multiplied by that of the color temperature.",
        row("enableColorTemperature", "Emission", "Temperature", ParameterKind::Flag,
            &all_lights(Value::Flag(false), Weight));
    COLOR_TEMPERATURE: f64 = "Color of a black body of this temperature, as bright as white. 6500 K is nearly white, less is warmer.",
        row("colorTemperature", "Emission", "Kelvin",
            Number(range("K", [Included(1000.0), Included(10000.0)], [1000.0, 10000.0], 50.0)),
            &all_lights(Value::Number(6500.0), Weight)).needs_one_of("enableColorTemperature", &[Value::Flag(true)]);
    DIFFUSE: f64 = "Factor of what surfaces scatter of it.",
        row("diffuse", "Emission", "Diffuse", Number(FACTOR), &all_lights(Value::Number(1.0), Weight));
    SPECULAR: f64 = "Factor of what surfaces mirror of it: highlights.",
        row("specular", "Emission", "Specular", Number(FACTOR), &all_lights(Value::Number(1.0), Weight));
    DECAY: Decay = "How irradiance falls with the distance travelled.",
        row("decay", "Distance", "Decay", ParameterKind::Choice(Decay::CHOICES),
            &[
                of(Spot, Value::Choice(Decay::InverseSquare.name()), Radiance),
                of(Bendy, Value::Choice(Decay::None.name()), Radiance),
                of(Omni, Value::Choice(Decay::InverseSquare.name()), Radiance),
            ]);
    DECAY_START: f64 = "Distance from the source nearer than which irradiance falls no further.",
        row("decayStart", "Distance", "Decay start", Number(LENGTH), &source_lights(Value::Number(0.0), Radiance))
            .needs_none_of("decay", &[Value::Choice(Decay::None.name())]);
    CUT_ON: Option<f64> = "Distance from the source at which light is there in full; at the source without.",
        row("cutOn", "Distance", "Cut on", Number(NumberRange { absent: Some("No cut-on"), ..LENGTH }),
            &source_lights(Value::Absent, Radiance));
    NEAR_EDGE: f64 = "Distance before the cut-on over which light comes up.",
        row("nearEdge", "Distance", "Near edge", Number(LENGTH), &source_lights(Value::Number(0.0), Radiance))
            .needs_none_of("cutOn", &[Value::Absent]);
    CUT_OFF: Option<f64> = "Distance from the source at which light begins to go; never without.",
        row("cutOff", "Distance", "Cut off", Number(NumberRange { absent: Some("No cut-off"), ..LENGTH }),
            &source_lights(Value::Absent, Radiance));
    FAR_EDGE: f64 = "Distance past the cut-off over which light goes.",
        row("farEdge", "Distance", "Far edge", Number(LENGTH), &source_lights(Value::Number(0.0), Radiance))
            .needs_none_of("cutOff", &[Value::Absent]);
    CONE_ANGLE: f64 = "Half angle of the cone. Of a BendyLight, the angle that the tube's edge stands for in the profile.",
        row("coneAngle", "Shape", "Cone angle",
            Number(range("degrees", [Excluded(0.0), Excluded(90.0)], [1.0, 89.0], 0.5)),
            &[of(Spot, Value::Number(25.0), ShadowMap), of(Bendy, Value::Number(25.0), Radiance)]);
    CONE_SOFTNESS: f64 = "Share of the cone angle over which the profile falls to zero.",
        row("coneSoftness", "Shape", "Softness", Number(SHARE), &cone_lights(Value::Number(0.2), Radiance))
            .needs_none_of("profile", &[Value::Choice(ProfileCurve::Cosine.name())]);
    PROFILE: ProfileCurve = "How light falls from the inner cone to the edge.",
        row("profile", "Shape", "Profile", ParameterKind::Choice(ProfileCurve::CHOICES),
            &cone_lights(Value::Choice(ProfileCurve::Smooth.name()), Radiance));
    PROFILE_POWER: f64 = "Exponent of the power and cosine profiles.",
        row("profilePower", "Shape", "Profile power",
            Number(NumberRange {
                scale: ParameterScale::Logarithmic,
                ..range("", [Excluded(0.0), Included(1000.0)], [0.1, 100.0], 0.1)
            }),
            &cone_lights(Value::Number(1.0), Radiance))
            .needs_one_of(
                "profile",
                &[Value::Choice(ProfileCurve::Power.name()), Value::Choice(ProfileCurve::Cosine.name())],
            );
    CROSS_SECTION: CrossSection = "What the light's outline is.",
        row("crossSection", "Section", "Outline", ParameterKind::Choice(CrossSection::CHOICES),
            &cone_lights(Value::Choice(CrossSection::Circle.name()), Radiance));
    SECTION_WIDTH: f64 = "Half width of a superellipse, in radii.",
        row("sectionWidth", "Section", "Width", Number(HALF_EXTENT), &cone_lights(Value::Number(1.0), Radiance))
            .needs_one_of("crossSection", SUPERELLIPSE);
    SECTION_HEIGHT: f64 = "Half height of a superellipse, in radii.",
        row("sectionHeight", "Section", "Height", Number(HALF_EXTENT), &cone_lights(Value::Number(1.0), Radiance))
            .needs_one_of("crossSection", SUPERELLIPSE);
    SECTION_ROUNDNESS: f64 = "From 0, a rectangle, to 1, an ellipse. What would reach past the light's radius is made smaller as a whole.",
        row("sectionRoundness", "Section", "Roundness", Number(SHARE), &cone_lights(Value::Number(1.0), Radiance))
            .needs_one_of("crossSection", SUPERELLIPSE);
    RADIAL_FALLOFF: Option<PeriodicCurve> = "How far out the light's edge lies, as a share of the way, over the angle around its axis: degrees from its left over its top, as seen along it.",
        row("radialFalloff", "Section", "Radial falloff",
            ParameterKind::PeriodicCurve { min: 0.001, max: 1.0, step: 0.01, absent: "Even all around" },
            &cone_lights(Value::Absent, Radiance));
    RANGE: Option<f64> = "World distance at which the light ends, along the axis of a spotlight; endless without.",
        row("range", "Shape", "Range", size("Endless"),
            &[of(Spot, Value::Absent, Radiance), of(Omni, Value::Absent, Radiance)]);
    WIDTH: Option<f64> = "How far it shines across its local X; over all of the scene without.",
        row("width", "Shape", "Width", size("Any width"), &[of(Directional, Value::Absent, ShadowMap)]);
    HEIGHT: Option<f64> = "How far it shines across its local Y; over all of the scene without.",
        row("height", "Shape", "Height", size("Any height"), &[of(Directional, Value::Absent, ShadowMap)]);
    END_MODE: EndMode = "What happens past the last control point.",
        row("endMode", "Shape", "End", ParameterKind::Choice(EndMode::CHOICES),
            &[of(Bendy, Value::Choice(EndMode::Cut.name()), ShadowMap)]);
    DIRECTION: DirectionMode = "Which direction light arrives from.",
        row("direction", "Shape", "Direction", ParameterKind::Choice(DirectionMode::CHOICES),
            &[of(Bendy, Value::Choice(DirectionMode::Tube.name()), Radiance)]);
    FRAME: FrameMode = "How the cross-section is oriented along the curve.",
        row("frame", "Shape", "Frame", ParameterKind::Choice(FrameMode::CHOICES),
            &[of(Bendy, Value::Choice(FrameMode::RotationMinimizing.name()), ShadowMap)]);
    UP: DVec3 = "Light-local direction that orients the cross-section at the source.",
        row("up", "Shape", "Up", Vector { unit: "", step: 0.01 }, &[of(Bendy, Value::Vector(DVec3::Y), ShadowMap)]);
    ALLOW_OVERLAP: bool = "Whether drags and handles may make distant parts of the tube overlap. A point in two parts is lit by one alone.",
        row("allowOverlap", "Shape", "Overlap", ParameterKind::Flag,
            &[of(Bendy, Value::Flag(false), Nothing)]);
    SHADOW_ENABLE: bool = "Whether anything shadows it.",
        row("shadowEnable", "Shadow", "Shadows", ParameterKind::Flag, &all_lights(Value::Flag(true), Radiance));
    SHADOW_COLOR: DVec3 = "Linear RGB: the share of the light that reaches what is in its shadow.",
        row("shadowColor", "Shadow", "Shadow color", Color, &all_lights(Value::Vector(DVec3::ZERO), Radiance))
            .needs_one_of("shadowEnable", &[Value::Flag(true)]);
    LIGHT_LINK: Option<Links> = "Nodes that it lights, each with all that is under it. The deepest entry decides, and exclude over include.",
        row("lightLink", "Links", "Lights", ParameterKind::Links, &all_lights(Value::Absent, Radiance));
    SHADOW_LINK: Option<Links> = "Nodes that throw shadows in it, each with all that is under it. The deepest entry decides, and exclude over include.",
        row("shadowLink", "Links", "Shadows", ParameterKind::Links, &all_lights(Value::Absent, ShadowMap))
            .needs_one_of("shadowEnable", &[Value::Flag(true)]);
}

rows! { POINT_ROWS:
    POSITION: DVec3 = "Light-local position. The first control point is the source and lies at the origin.",
        row("position", "Control point", "Position", Vector { unit: "light-local units", step: 0.01 },
            &[REQUIRED_OF_POINTS]).at("points");
    RADIUS: f64 = "Radius of the tube, light-local.",
        row("radius", "Control point", "Radius",
            Number(NumberRange { unit: "light-local units", min: Included(0.0), ..NumberRange::ANY }),
            &[REQUIRED_OF_POINTS]).at("radii");
    POINT_COLOR: DVec3 = "Linear RGB there, as a factor of the whole light's color.",
        row("color", "Control point", "Color", Color, &[of(Point, Value::Vector(DVec3::ONE), Radiance)]).at("colors");
    POINT_INTENSITY: f64 = "How bright it is there, as a factor of the whole light's intensity.",
        row("intensity", "Control point", "Intensity", Number(range("", [Unbounded, Unbounded], [0.0, 10.0], 0.05)),
            &[of(Point, Value::Number(1.0), Radiance)]).at("intensities");
}

static TABLE: OnceLock<Table> = OnceLock::new();

struct Table {
    rows: Vec<&'static Parameter>,
    /// Parameters of each owner, in the order of [`ParameterOwner`].
    by_owner: [Vec<&'static Parameter>; ParameterOwner::COUNT],
}

impl Table {
    fn new(more: &[&'static Parameter]) -> Self {
        let rows: Vec<_> = [LIGHT_ROWS, more, POINT_ROWS].concat();
        let of = |owner| rows.iter().copied().filter(|row| row.for_owner(owner).is_some()).collect();
        let by_owner = ParameterOwner::ALL.map(of);
        Self { rows, by_owner }
    }
}

/// Adds parameters to those of lights, for experiments and tests. Returns false if the table is already in use, and so
/// cannot change any more.
pub fn add_parameters(more: &[&'static Parameter]) -> bool {
    TABLE.set(Table::new(more)).is_ok()
}

/// Returns all parameters of lights and control points.
pub fn parameters() -> &'static [&'static Parameter] {
    &TABLE.get_or_init(|| Table::new(&[])).rows
}

/// Returns the parameters of an owner, in the order of the table.
pub fn parameters_of(owner: ParameterOwner) -> &'static [&'static Parameter] {
    &TABLE.get_or_init(|| Table::new(&[])).by_owner[owner as usize]
}

/// Finds a parameter of an owner by its name.
///
/// ```
/// use light::{ParameterOwner, Value, parameter_of};
///
/// let angle = parameter_of(ParameterOwner::Spot, "coneAngle").expect("a spotlight has a cone");
/// assert_eq!((angle.label, angle.default(ParameterOwner::Spot)), ("Cone angle", Some(Value::Number(25.0))));
/// assert!(angle.check(&Value::Number(90.0)).is_err());
/// assert_eq!(parameter_of(ParameterOwner::Omni, "coneAngle"), None);
/// ```
pub fn parameter_of(owner: ParameterOwner, name: &str) -> Option<&'static Parameter> {
    parameters_of(owner).iter().copied().find(|row| row.name == name)
}

impl ControlPoint {
    /// Returns the value of a parameter of control points; `None` for other parameters.
    pub fn value(&self, parameter: &Parameter) -> Option<Value> {
        Some(match parameter.name {
            "position" => Value::Vector(self.position),
            "radius" => Value::Number(self.radius),
            "intensity" => Value::Number(self.intensity),
            "color" => Value::Vector(self.color),
            _ => return None,
        })
    }

    /// Sets a parameter of control points. Other parameters are ignored.
    pub fn set(&mut self, Setting { parameter, value }: &Setting) {
        match (parameter.name, value) {
            ("position", Value::Vector(position)) => self.position = *position,
            ("radius", Value::Number(radius)) => self.radius = *radius,
            ("intensity", Value::Number(intensity)) => self.intensity = *intensity,
            ("color", Value::Vector(color)) => self.color = *color,
            _ => {}
        }
    }
}
