//! Parameter table of lights and control points.
//!
//! Names are those of UsdLux if it has them, else of glTF. A new parameter takes a row here, its formula in f64 and in
//! WGSL, and a test of the formula. Nothing else names it.

use std::ops::Bound::{Excluded, Included, Unbounded};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};

use crate::parameter::{
    MAX_EXTENT, MAX_NAME_BYTES, NumberRange, Parameter, ParameterKey, ParameterKind, ParameterNeeded,
    ParameterNeeds, ParameterOf, ParameterOwner, ParameterScale, ParameterTouches, Setting, Value,
};
use crate::{
    ControlPoint, CrossSection, Decay, DirectionMode, EndMode, FrameMode, Links, PeriodicCurve, ProfileCurve,
};

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

const fn of(owner: ParameterOwner, default: Value<&'static str>, touches: ParameterTouches) -> ParameterOf {
    ParameterOf { owner, default: Some(default), touches }
}

/// Makes the entries of a parameter that all lights have, with the same default.
const fn all_lights_default(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 4] {
    let [spot, bendy, omni] = source_lights_default(default, touches);
    [spot, bendy, omni, of(Directional, default, touches)]
}

/// Makes the entries of a parameter that all lights with a source have, with the same default.
const fn source_lights_default(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 3] {
    let [spot, bendy] = cone_lights_default(default, touches);
    [spot, bendy, of(Omni, default, touches)]
}

/// Makes the entries of a parameter that all lights with a cone have, with the same default.
const fn cone_lights_default(default: Value<&'static str>, touches: ParameterTouches) -> [ParameterOf; 2] {
    [of(Spot, default, touches), of(Bendy, default, touches)]
}

/// Values of the fields that most parameters share.
const ROW: Parameter = Parameter {
    name: "",
    path: "",
    owners: &[],
    kind: ParameterKind::Color,
    animates: true,
    needs: None,
    group: "",
    label: "",
    doc: "",
};

const fn needs_one_of(parameter: &'static str, values: &'static [Value<&'static str>]) -> ParameterNeeds {
    ParameterNeeds { parameter, value: ParameterNeeded::OneOf(values) }
}

const fn needs_none_of(parameter: &'static str, values: &'static [Value<&'static str>]) -> ParameterNeeds {
    ParameterNeeds { parameter, value: ParameterNeeded::NoneOf(values) }
}

const SUPERELLIPSE: ParameterNeeds =
    needs_one_of("crossSection", &[Value::Choice(CrossSection::Superellipse.name())]);
const SHADOWS: ParameterNeeds = needs_one_of("shadowEnable", &[Value::Flag(true)]);

/// Range of a factor by which light is multiplied.
const FACTOR: NumberRange = NumberRange {
    min: Included(0.0),
    max: Included(1e6),
    slider: Some([0.0, 2.0]),
    step: 0.05,
    ..NumberRange::ANY
};

/// Range of a length along a light path.
const LENGTH: NumberRange = NumberRange {
    unit: "world units",
    min: Included(0.0),
    max: Included(MAX_EXTENT),
    slider: Some([0.0, 20.0]),
    step: 0.05,
    ..NumberRange::ANY
};

/// Range of a half extent of a cross-section, in radii.
const HALF_EXTENT: NumberRange =
    NumberRange { min: Excluded(0.0), max: Included(1.0), slider: Some([0.01, 1.0]), ..NumberRange::ANY };

/// Makes the type of the width or height of a directional light's window.
const fn window(absent: &'static str) -> ParameterKind {
    ParameterKind::Number(NumberRange {
        unit: "world units",
        min: Excluded(0.0),
        slider: Some([0.1, 20.0]),
        step: 0.05,
        scale: ParameterScale::Logarithmic,
        absent: Some(absent),
        ..NumberRange::ANY
    })
}

use ParameterOwner::{Bendy, Directional, Omni, Point, Spot};
use ParameterTouches::{Nothing, Radiance, ShadowMap, Weight};

rows! { LIGHT_ROWS:
    NAME: String = "Name for people and for `--light`.", Parameter {
        name: "name",
        path: "name",
        owners: &all_lights_default(Value::Text(""), Nothing),
        kind: ParameterKind::Text { max_bytes: MAX_NAME_BYTES },
        animates: false,
        group: "Light",
        label: "Name",
        ..ROW
    };
    TRANSLATION: DVec3 = "World position of the source; of a directional light, of a point of its axis.", Parameter {
        name: "translation",
        path: "transform.translation",
        owners: &all_lights_default(Value::Vector(DVec3::ZERO), ShadowMap),
        kind: ParameterKind::Vector { unit: "world units", step: 0.01 },
        group: "Light",
        label: "Position",
        ..ROW
    };
    ROTATION: DQuat = "Rotation from light-local to world axes. Spotlights and directional lights shine along their local -Z.", Parameter {
        name: "rotation",
        path: "transform.rotation",
        owners: &all_lights_default(Value::Rotation(DQuat::IDENTITY), ShadowMap),
        kind: ParameterKind::Rotation,
        group: "Light",
        label: "Rotation",
        ..ROW
    };
    SCALE: f64 = "World units per light-local unit. It only matters to a light that is bent.", Parameter {
        name: "scale",
        path: "transform.scale",
        owners: &[
            of(Spot, Value::Number(1.0), Nothing),
            of(Bendy, Value::Number(1.0), ShadowMap),
            of(Omni, Value::Number(1.0), Nothing),
            of(Directional, Value::Number(1.0), Nothing),
        ],
        kind: ParameterKind::Number(NumberRange { min: Excluded(0.0), slider: Some([0.1, 3.0]), ..NumberRange::ANY }),
        group: "Light",
        label: "Scale",
        ..ROW
    };
    ENABLED: bool = "Whether it shines.", Parameter {
        name: "enabled",
        path: "enabled",
        owners: &all_lights_default(Value::Flag(true), Weight),
        kind: ParameterKind::Flag,
        group: "Light",
        label: "Enabled",
        ..ROW
    };
    COLOR: DVec3 = "Linear RGB of all that it emits. That of a BendyLight's control points is a factor of it.", Parameter {
        name: "color",
        path: "color",
        owners: &all_lights_default(Value::Vector(DVec3::ONE), Weight),
        kind: ParameterKind::Color,
        group: "Emission",
        label: "Color",
        ..ROW
    };
    INTENSITY: f64 = "How bright it is: candela with inverse-square decay, lux without. That of a BendyLight's control points is a factor of it.",
    Parameter {
        name: "intensity",
        path: "intensity",
        owners: &all_lights_default(Value::Number(1.0), Weight),
        kind: ParameterKind::Number(NumberRange { slider: Some([0.0, 20.0]), step: 0.05, ..NumberRange::ANY }),
        group: "Emission",
        label: "Intensity",
        ..ROW
    };
    EXPOSURE: f64 = "Stops by which all that it emits is brightened: a factor of 2 to this.", Parameter {
        name: "exposure",
        path: "exposure",
        owners: &all_lights_default(Value::Number(0.0), Weight),
        kind: ParameterKind::Number(NumberRange {
            unit: "stops",
            min: Included(-100.0),
            max: Included(100.0),
            slider: Some([-10.0, 10.0]),
            step: 0.1,
            ..NumberRange::ANY
        }),
        group: "Emission",
        label: "Exposure",
        ..ROW
    };
    ENABLE_COLOR_TEMPERATURE: bool = "Whether the color is multiplied by that of the color temperature.", Parameter {
        name: "enableColorTemperature",
        path: "enableColorTemperature",
        owners: &all_lights_default(Value::Flag(false), Weight),
        kind: ParameterKind::Flag,
        group: "Emission",
        label: "Temperature",
        ..ROW
    };
    COLOR_TEMPERATURE: f64 = "Color of a black body of this temperature, as bright as white. 6500 K is nearly white, less is warmer.",
    Parameter {
        name: "colorTemperature",
        path: "colorTemperature",
        owners: &all_lights_default(Value::Number(6500.0), Weight),
        kind: ParameterKind::Number(NumberRange {
            unit: "K",
            min: Included(1000.0),
            max: Included(10000.0),
            slider: Some([1000.0, 10000.0]),
            step: 50.0,
            ..NumberRange::ANY
        }),
        needs: Some(needs_one_of("enableColorTemperature", &[Value::Flag(true)])),
        group: "Emission",
        label: "Kelvin",
        ..ROW
    };
    DIFFUSE: f64 = "Factor of what surfaces scatter of it.", Parameter {
        name: "diffuse",
        path: "diffuse",
        owners: &all_lights_default(Value::Number(1.0), Weight),
        kind: ParameterKind::Number(FACTOR),
        group: "Emission",
        label: "Diffuse",
        ..ROW
    };
    SPECULAR: f64 = "Factor of what surfaces mirror of it: highlights.", Parameter {
        name: "specular",
        path: "specular",
        owners: &all_lights_default(Value::Number(1.0), Weight),
        kind: ParameterKind::Number(FACTOR),
        group: "Emission",
        label: "Specular",
        ..ROW
    };
    DECAY: Decay = "How irradiance falls with the distance travelled.", Parameter {
        name: "decay",
        path: "decay",
        owners: &[
            of(Spot, Value::Choice(Decay::InverseSquare.name()), Radiance),
            of(Bendy, Value::Choice(Decay::None.name()), Radiance),
            of(Omni, Value::Choice(Decay::InverseSquare.name()), Radiance),
        ],
        kind: ParameterKind::Choice(Decay::CHOICES),
        animates: false,
        group: "Distance",
        label: "Decay",
        ..ROW
    };
    DECAY_START: f64 = "Distance from the source nearer than which irradiance falls no further.", Parameter {
        name: "decayStart",
        path: "decayStart",
        owners: &source_lights_default(Value::Number(0.0), Radiance),
        kind: ParameterKind::Number(LENGTH),
        needs: Some(needs_none_of("decay", &[Value::Choice(Decay::None.name())])),
        group: "Distance",
        label: "Decay start",
        ..ROW
    };
    CUT_ON: Option<f64> = "Distance from the source at which light is there in full; at the source without.", Parameter {
        name: "cutOn",
        path: "cutOn",
        owners: &source_lights_default(Value::Absent, Radiance),
        kind: ParameterKind::Number(NumberRange { absent: Some("No cut-on"), ..LENGTH }),
        group: "Distance",
        label: "Cut on",
        ..ROW
    };
    NEAR_EDGE: f64 = "Distance before the cut-on over which light comes up.", Parameter {
        name: "nearEdge",
        path: "nearEdge",
        owners: &source_lights_default(Value::Number(0.0), Radiance),
        kind: ParameterKind::Number(LENGTH),
        needs: Some(needs_none_of("cutOn", &[Value::Absent])),
        group: "Distance",
        label: "Near edge",
        ..ROW
    };
    CUT_OFF: Option<f64> = "Distance from the source at which light begins to go; never without.", Parameter {
        name: "cutOff",
        path: "cutOff",
        owners: &source_lights_default(Value::Absent, Radiance),
        kind: ParameterKind::Number(NumberRange { absent: Some("No cut-off"), ..LENGTH }),
        group: "Distance",
        label: "Cut off",
        ..ROW
    };
    FAR_EDGE: f64 = "Distance past the cut-off over which light goes.", Parameter {
        name: "farEdge",
        path: "farEdge",
        owners: &source_lights_default(Value::Number(0.0), Radiance),
        kind: ParameterKind::Number(LENGTH),
        needs: Some(needs_none_of("cutOff", &[Value::Absent])),
        group: "Distance",
        label: "Far edge",
        ..ROW
    };
    CONE_ANGLE: f64 = "Half angle of the cone. Of a BendyLight, the angle that the tube's edge stands for in the profile.",
    Parameter {
        name: "coneAngle",
        path: "coneAngle",
        owners: &[of(Spot, Value::Number(25.0), ShadowMap), of(Bendy, Value::Number(25.0), Radiance)],
        kind: ParameterKind::Number(NumberRange {
            unit: "degrees",
            min: Excluded(0.0),
            max: Excluded(90.0),
            slider: Some([1.0, 89.0]),
            step: 0.5,
            ..NumberRange::ANY
        }),
        group: "Shape",
        label: "Cone angle",
        ..ROW
    };
    CONE_SOFTNESS: f64 = "Share of the cone angle over which the profile falls to zero.", Parameter {
        name: "coneSoftness",
        path: "coneSoftness",
        owners: &cone_lights_default(Value::Number(0.2), Radiance),
        kind: ParameterKind::Number(NumberRange {
            min: Included(0.0),
            max: Included(1.0),
            slider: Some([0.0, 1.0]),
            ..NumberRange::ANY
        }),
        needs: Some(needs_none_of("profile", &[Value::Choice(ProfileCurve::Cosine.name())])),
        group: "Shape",
        label: "Softness",
        ..ROW
    };
    PROFILE: ProfileCurve = "How light falls from the inner cone to the edge.", Parameter {
        name: "profile",
        path: "profile",
        owners: &cone_lights_default(Value::Choice(ProfileCurve::Smooth.name()), Radiance),
        kind: ParameterKind::Choice(ProfileCurve::CHOICES),
        animates: false,
        group: "Shape",
        label: "Profile",
        ..ROW
    };
    PROFILE_POWER: f64 = "Exponent of the power and cosine profiles.", Parameter {
        name: "profilePower",
        path: "profilePower",
        owners: &cone_lights_default(Value::Number(1.0), Radiance),
        kind: ParameterKind::Number(NumberRange {
            min: Excluded(0.0),
            max: Included(1000.0),
            slider: Some([0.1, 100.0]),
            step: 0.1,
            scale: ParameterScale::Logarithmic,
            ..NumberRange::ANY
        }),
        needs: Some(needs_one_of(
            "profile",
            &[Value::Choice(ProfileCurve::Power.name()), Value::Choice(ProfileCurve::Cosine.name())],
        )),
        group: "Shape",
        label: "Profile power",
        ..ROW
    };
    CROSS_SECTION: CrossSection = "What the light's outline is.", Parameter {
        name: "crossSection",
        path: "crossSection",
        owners: &cone_lights_default(Value::Choice(CrossSection::Circle.name()), Radiance),
        kind: ParameterKind::Choice(CrossSection::CHOICES),
        animates: false,
        group: "Section",
        label: "Outline",
        ..ROW
    };
    SECTION_WIDTH: f64 = "Half width of a superellipse, in radii.", Parameter {
        name: "sectionWidth",
        path: "sectionWidth",
        owners: &cone_lights_default(Value::Number(1.0), Radiance),
        kind: ParameterKind::Number(HALF_EXTENT),
        needs: Some(SUPERELLIPSE),
        group: "Section",
        label: "Width",
        ..ROW
    };
    SECTION_HEIGHT: f64 = "Half height of a superellipse, in radii.", Parameter {
        name: "sectionHeight",
        path: "sectionHeight",
        owners: &cone_lights_default(Value::Number(1.0), Radiance),
        kind: ParameterKind::Number(HALF_EXTENT),
        needs: Some(SUPERELLIPSE),
        group: "Section",
        label: "Height",
        ..ROW
    };
    SECTION_ROUNDNESS: f64 = "From 0, a rectangle, to 1, an ellipse. What would reach past the light's radius is made smaller as a whole.",
    Parameter {
        name: "sectionRoundness",
        path: "sectionRoundness",
        owners: &cone_lights_default(Value::Number(1.0), Radiance),
        kind: ParameterKind::Number(NumberRange {
            min: Included(0.0),
            max: Included(1.0),
            slider: Some([0.0, 1.0]),
            ..NumberRange::ANY
        }),
        needs: Some(SUPERELLIPSE),
        group: "Section",
        label: "Roundness",
        ..ROW
    };
    RADIAL_FALLOFF: Option<PeriodicCurve> = "How far out the light's edge lies, as a share of the way, over the angle around its axis: degrees from its left over its top, as seen along it.",
    Parameter {
        name: "radialFalloff",
        path: "radialFalloff",
        owners: &cone_lights_default(Value::Absent, Radiance),
        kind: ParameterKind::PeriodicCurve { min: 0.001, max: 1.0, step: 0.01, absent: "Even all around" },
        group: "Section",
        label: "Radial falloff",
        ..ROW
    };
    RANGE: Option<f64> = "World distance at which the light ends, along the axis of a spotlight; endless without.",
    Parameter {
        name: "range",
        path: "range",
        owners: &[of(Spot, Value::Absent, Radiance), of(Omni, Value::Absent, Radiance)],
        kind: ParameterKind::Number(NumberRange {
            unit: "world units",
            min: Excluded(0.0),
            slider: Some([0.1, 20.0]),
            step: 0.05,
            scale: ParameterScale::Logarithmic,
            absent: Some("Endless"),
            ..NumberRange::ANY
        }),
        group: "Shape",
        label: "Range",
        ..ROW
    };
    WIDTH: Option<f64> = "How far it shines across its local X; over all of the scene without.", Parameter {
        name: "width",
        path: "width",
        owners: &[of(Directional, Value::Absent, ShadowMap)],
        kind: window("Any width"),
        group: "Shape",
        label: "Width",
        ..ROW
    };
    HEIGHT: Option<f64> = "How far it shines across its local Y; over all of the scene without.", Parameter {
        name: "height",
        path: "height",
        owners: &[of(Directional, Value::Absent, ShadowMap)],
        kind: window("Any height"),
        group: "Shape",
        label: "Height",
        ..ROW
    };
    END_MODE: EndMode = "What happens past the last control point.", Parameter {
        name: "endMode",
        path: "endMode",
        owners: &[of(Bendy, Value::Choice(EndMode::Cut.name()), ShadowMap)],
        kind: ParameterKind::Choice(EndMode::CHOICES),
        animates: false,
        group: "Shape",
        label: "End",
        ..ROW
    };
    DIRECTION: DirectionMode = "Which direction light arrives from.", Parameter {
        name: "direction",
        path: "direction",
        owners: &[of(Bendy, Value::Choice(DirectionMode::Tube.name()), Radiance)],
        kind: ParameterKind::Choice(DirectionMode::CHOICES),
        animates: false,
        group: "Shape",
        label: "Direction",
        ..ROW
    };
    FRAME: FrameMode = "How the cross-section is oriented along the curve.", Parameter {
        name: "frame",
        path: "frame",
        owners: &[of(Bendy, Value::Choice(FrameMode::RotationMinimizing.name()), ShadowMap)],
        kind: ParameterKind::Choice(FrameMode::CHOICES),
        animates: false,
        group: "Shape",
        label: "Frame",
        ..ROW
    };
    UP: DVec3 = "Light-local direction that orients the cross-section at the source.", Parameter {
        name: "up",
        path: "up",
        owners: &[of(Bendy, Value::Vector(DVec3::Y), ShadowMap)],
        kind: ParameterKind::Vector { unit: "", step: 0.01 },
        group: "Shape",
        label: "Up",
        ..ROW
    };
    SHADOW_ENABLE: bool = "Whether anything shadows it.", Parameter {
        name: "shadowEnable",
        path: "shadowEnable",
        owners: &all_lights_default(Value::Flag(true), Radiance),
        kind: ParameterKind::Flag,
        group: "Shadow",
        label: "Shadows",
        ..ROW
    };
    SHADOW_COLOR: DVec3 = "Linear RGB: the share of the light that reaches what is in its shadow.", Parameter {
        name: "shadowColor",
        path: "shadowColor",
        owners: &all_lights_default(Value::Vector(DVec3::ZERO), Radiance),
        kind: ParameterKind::Color,
        needs: Some(SHADOWS),
        group: "Shadow",
        label: "Shadow color",
        ..ROW
    };
    LIGHT_LINK: Option<Links> = "Nodes that it lights, each with all that is under it. The deepest entry decides, and exclude over include.", Parameter {
        name: "lightLink",
        path: "lightLink",
        owners: &all_lights_default(Value::Absent, Radiance),
        kind: ParameterKind::Links,
        animates: false,
        group: "Links",
        label: "Lights",
        ..ROW
    };
    SHADOW_LINK: Option<Links> = "Nodes that throw shadows in it, each with all that is under it. The deepest entry decides, and exclude over include.", Parameter {
        name: "shadowLink",
        path: "shadowLink",
        owners: &all_lights_default(Value::Absent, ShadowMap),
        kind: ParameterKind::Links,
        animates: false,
        needs: Some(SHADOWS),
        group: "Links",
        label: "Shadows",
        ..ROW
    };
}

rows! { POINT_ROWS:
    POSITION: DVec3 = "Light-local position. The first control point is the source and lies at the origin.", Parameter {
        name: "position",
        path: "points",
        owners: &[ParameterOf { owner: Point, default: None, touches: ShadowMap }],
        kind: ParameterKind::Vector { unit: "light-local units", step: 0.01 },
        group: "Control point",
        label: "Position",
        ..ROW
    };
    RADIUS: f64 = "Radius of the tube, light-local.", Parameter {
        name: "radius",
        path: "radii",
        owners: &[ParameterOf { owner: Point, default: None, touches: ShadowMap }],
        kind: ParameterKind::Number(NumberRange { unit: "light-local units", min: Included(0.0), ..NumberRange::ANY }),
        group: "Control point",
        label: "Radius",
        ..ROW
    };
    POINT_COLOR: DVec3 = "Linear RGB there, as a factor of the whole light's color.", Parameter {
        name: "color",
        path: "colors",
        owners: &[of(Point, Value::Vector(DVec3::ONE), Radiance)],
        kind: ParameterKind::Color,
        group: "Control point",
        label: "Color",
        ..ROW
    };
    POINT_INTENSITY: f64 = "How bright it is there, as a factor of the whole light's intensity.", Parameter {
        name: "intensity",
        path: "intensities",
        owners: &[of(Point, Value::Number(1.0), Radiance)],
        kind: ParameterKind::Number(NumberRange { slider: Some([0.0, 10.0]), step: 0.05, min: Unbounded, ..NumberRange::ANY }),
        group: "Control point",
        label: "Intensity",
        ..ROW
    };
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
