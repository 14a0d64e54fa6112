//! The table: all that can be set on lights and control points.
//!
//! Names are UsdLux's where it has them, glTF's next. A new parameter is a row here, its formula in f64 and in WGSL, and a
//! test of that; nothing else names it.

use std::ops::Bound::{Excluded, Included, Unbounded};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};

use crate::parameter::{
    Key, Kind, MAX_EXTENT, MAX_NAME_BYTES, Needed, Needs, Number, Of, Owner, Parameter, Scale, Setting,
    Touches, Value,
};
use crate::{
    ControlPoint, CrossSection, Decay, Direction, EndMode, Frame, Links, PeriodicCurve, ProfileCurve,
};

/// Rows, each with a constant that knows the type of its values.
macro_rules! rows {
    ($list:ident: $($key:ident: $type:ty = $doc:literal, $parameter:expr;)+) => {
        $(
            #[doc = $doc]
            pub const $key: Key<$type> = {
                static PARAMETER: Parameter = Parameter { doc: $doc, ..$parameter };
                Key::new(&PARAMETER)
            };
        )+
        static $list: &[&Parameter] = &[$($key.row()),+];
    };
}

const fn of(owner: Owner, default: Value<&'static str>, touches: Touches) -> Of {
    Of { owner, default: Some(default), touches }
}

/// Lights of every shape, with the same default.
const fn every(default: Value<&'static str>, touches: Touches) -> [Of; 4] {
    let [spot, bendy, omni] = sourced(default, touches);
    [spot, bendy, omni, of(Directional, default, touches)]
}

/// Lights that come from a point, with the same default.
const fn sourced(default: Value<&'static str>, touches: Touches) -> [Of; 3] {
    let [spot, bendy] = conical(default, touches);
    [spot, bendy, of(Omni, default, touches)]
}

/// Lights that have a cone, with the same default.
const fn conical(default: Value<&'static str>, touches: Touches) -> [Of; 2] {
    [of(Spot, default, touches), of(Bendy, default, touches)]
}

/// What most rows are.
const ROW: Parameter = Parameter {
    name: "",
    path: "",
    of: &[],
    kind: Kind::Color,
    animates: true,
    needs: None,
    group: "",
    label: "",
    doc: "",
};

const fn only_with(parameter: &'static str, values: &'static [Value<&'static str>]) -> Needs {
    Needs { parameter, value: Needed::OneOf(values) }
}

const fn not_with(parameter: &'static str, values: &'static [Value<&'static str>]) -> Needs {
    Needs { parameter, value: Needed::NoneOf(values) }
}

const SUPERELLIPSE: Needs = only_with("crossSection", &[Value::Choice(CrossSection::Superellipse.name())]);
const SHADOWS: Needs = only_with("shadowEnable", &[Value::Flag(true)]);

/// A factor of light.
const FACTOR: Number =
    Number { min: Included(0.0), max: Included(1e6), slider: Some([0.0, 2.0]), step: 0.05, ..Number::ANY };

/// A length along light's way.
const LENGTH: Number = Number {
    unit: "world units",
    min: Included(0.0),
    max: Included(MAX_EXTENT),
    slider: Some([0.0, 20.0]),
    step: 0.05,
    ..Number::ANY
};

/// A half extent of a cross-section, in radii.
const HALF_EXTENT: Number =
    Number { min: Excluded(0.0), max: Included(1.0), slider: Some([0.01, 1.0]), ..Number::ANY };

/// A side of a directional light's window.
const fn window(absent: &'static str) -> Kind {
    Kind::Number(Number {
        unit: "world units",
        min: Excluded(0.0),
        slider: Some([0.1, 20.0]),
        step: 0.05,
        scale: Scale::Logarithmic,
        absent: Some(absent),
        ..Number::ANY
    })
}

use Owner::{Bendy, Directional, Omni, Point, Spot};
use Touches::{Nothing, Radiance, ShadowMap, Weight};

rows! { LIGHT_ROWS:
    NAME: String = "Name for people and for `--light`.", Parameter {
        name: "name",
        path: "name",
        of: &every(Value::Text(""), Nothing),
        kind: Kind::Text { max_bytes: MAX_NAME_BYTES },
        animates: false,
        group: "Light",
        label: "Name",
        ..ROW
    };
    TRANSLATION: DVec3 = "World position of the source; of a directional light, of a point of its axis.", Parameter {
        name: "translation",
        path: "transform.translation",
        of: &every(Value::Vector(DVec3::ZERO), ShadowMap),
        kind: Kind::Vector { unit: "world units", step: 0.01 },
        group: "Light",
        label: "Position",
        ..ROW
    };
    ROTATION: DQuat = "Rotation from light-local to world axes. Spotlights and directional lights shine along their local -Z.", Parameter {
        name: "rotation",
        path: "transform.rotation",
        of: &every(Value::Rotation(DQuat::IDENTITY), ShadowMap),
        kind: Kind::Rotation,
        group: "Light",
        label: "Rotation",
        ..ROW
    };
    SCALE: f64 = "World units per light-local unit. It only matters to a light that is bent.", Parameter {
        name: "scale",
        path: "transform.scale",
        of: &[
            of(Spot, Value::Number(1.0), Nothing),
            of(Bendy, Value::Number(1.0), ShadowMap),
            of(Omni, Value::Number(1.0), Nothing),
            of(Directional, Value::Number(1.0), Nothing),
        ],
        kind: Kind::Number(Number { min: Excluded(0.0), slider: Some([0.1, 3.0]), ..Number::ANY }),
        group: "Light",
        label: "Scale",
        ..ROW
    };
    ENABLED: bool = "Whether it shines.", Parameter {
        name: "enabled",
        path: "enabled",
        of: &every(Value::Flag(true), Weight),
        kind: Kind::Flag,
        group: "Light",
        label: "Enabled",
        ..ROW
    };
    COLOR: DVec3 = "Linear RGB of all that it emits. That of a BendyLight's control points is a factor of it.", Parameter {
        name: "color",
        path: "color",
        of: &every(Value::Vector(DVec3::ONE), Weight),
        kind: Kind::Color,
        group: "Emission",
        label: "Color",
        ..ROW
    };
    INTENSITY: f64 = "How bright it is: candela with inverse-square decay, lux without. That of a BendyLight's control points is a factor of it.",
    Parameter {
        name: "intensity",
        path: "intensity",
        of: &every(Value::Number(1.0), Weight),
        kind: Kind::Number(Number { slider: Some([0.0, 20.0]), step: 0.05, ..Number::ANY }),
        group: "Emission",
        label: "Intensity",
        ..ROW
    };
    EXPOSURE: f64 = "Stops by which all that it emits is brightened: a factor of 2 to this.", Parameter {
        name: "exposure",
        path: "exposure",
        of: &every(Value::Number(0.0), Weight),
        kind: Kind::Number(Number {
            unit: "stops",
            min: Included(-100.0),
            max: Included(100.0),
            slider: Some([-10.0, 10.0]),
            step: 0.1,
            ..Number::ANY
        }),
        group: "Emission",
        label: "Exposure",
        ..ROW
    };
    ENABLE_COLOR_TEMPERATURE: bool = "Whether the color is multiplied by that of the color temperature.", Parameter {
        name: "enableColorTemperature",
        path: "enableColorTemperature",
        of: &every(Value::Flag(false), Weight),
        kind: Kind::Flag,
        group: "Emission",
        label: "Temperature",
        ..ROW
    };
    COLOR_TEMPERATURE: f64 = "Color of a black body of this temperature, as bright as white. 6500 K is nearly white, less is warmer.",
    Parameter {
        name: "colorTemperature",
        path: "colorTemperature",
        of: &every(Value::Number(6500.0), Weight),
        kind: Kind::Number(Number {
            unit: "K",
            min: Included(1000.0),
            max: Included(10000.0),
            slider: Some([1000.0, 10000.0]),
            step: 50.0,
            ..Number::ANY
        }),
        needs: Some(only_with("enableColorTemperature", &[Value::Flag(true)])),
        group: "Emission",
        label: "Kelvin",
        ..ROW
    };
    DIFFUSE: f64 = "Factor of what surfaces scatter of it.", Parameter {
        name: "diffuse",
        path: "diffuse",
        of: &every(Value::Number(1.0), Weight),
        kind: Kind::Number(FACTOR),
        group: "Emission",
        label: "Diffuse",
        ..ROW
    };
    SPECULAR: f64 = "Factor of what surfaces mirror of it: highlights.", Parameter {
        name: "specular",
        path: "specular",
        of: &every(Value::Number(1.0), Weight),
        kind: Kind::Number(FACTOR),
        group: "Emission",
        label: "Specular",
        ..ROW
    };
    DECAY: Decay = "How irradiance falls with the distance travelled.", Parameter {
        name: "decay",
        path: "decay",
        of: &[
            of(Spot, Value::Choice(Decay::InverseSquare.name()), Radiance),
            of(Bendy, Value::Choice(Decay::None.name()), Radiance),
            of(Omni, Value::Choice(Decay::InverseSquare.name()), Radiance),
        ],
        kind: Kind::Choice(Decay::CHOICES),
        animates: false,
        group: "Distance",
        label: "Decay",
        ..ROW
    };
    DECAY_START: f64 = "Distance from the source nearer than which irradiance falls no further.", Parameter {
        name: "decayStart",
        path: "decayStart",
        of: &sourced(Value::Number(0.0), Radiance),
        kind: Kind::Number(LENGTH),
        needs: Some(not_with("decay", &[Value::Choice(Decay::None.name())])),
        group: "Distance",
        label: "Decay start",
        ..ROW
    };
    CUT_ON: Option<f64> = "Distance from the source at which light is there in full; at the source without.", Parameter {
        name: "cutOn",
        path: "cutOn",
        of: &sourced(Value::Absent, Radiance),
        kind: Kind::Number(Number { absent: Some("No cut-on"), ..LENGTH }),
        group: "Distance",
        label: "Cut on",
        ..ROW
    };
    NEAR_EDGE: f64 = "Distance before the cut-on over which light comes up.", Parameter {
        name: "nearEdge",
        path: "nearEdge",
        of: &sourced(Value::Number(0.0), Radiance),
        kind: Kind::Number(LENGTH),
        needs: Some(not_with("cutOn", &[Value::Absent])),
        group: "Distance",
        label: "Near edge",
        ..ROW
    };
    CUT_OFF: Option<f64> = "Distance from the source at which light begins to go; never without.", Parameter {
        name: "cutOff",
        path: "cutOff",
        of: &sourced(Value::Absent, Radiance),
        kind: Kind::Number(Number { absent: Some("No cut-off"), ..LENGTH }),
        group: "Distance",
        label: "Cut off",
        ..ROW
    };
    FAR_EDGE: f64 = "Distance past the cut-off over which light goes.", Parameter {
        name: "farEdge",
        path: "farEdge",
        of: &sourced(Value::Number(0.0), Radiance),
        kind: Kind::Number(LENGTH),
        needs: Some(not_with("cutOff", &[Value::Absent])),
        group: "Distance",
        label: "Far edge",
        ..ROW
    };
    CONE_ANGLE: f64 = "Half angle of the cone. Of a BendyLight, the angle that the tube's edge stands for in the profile.",
    Parameter {
        name: "coneAngle",
        path: "coneAngle",
        of: &[of(Spot, Value::Number(25.0), ShadowMap), of(Bendy, Value::Number(25.0), Radiance)],
        kind: Kind::Number(Number {
            unit: "degrees",
            min: Excluded(0.0),
            max: Excluded(90.0),
            slider: Some([1.0, 89.0]),
            step: 0.5,
            ..Number::ANY
        }),
        group: "Shape",
        label: "Cone angle",
        ..ROW
    };
    CONE_SOFTNESS: f64 = "Share of the cone angle over which the profile falls to zero.", Parameter {
        name: "coneSoftness",
        path: "coneSoftness",
        of: &conical(Value::Number(0.2), Radiance),
        kind: Kind::Number(Number {
            min: Included(0.0),
            max: Included(1.0),
            slider: Some([0.0, 1.0]),
            ..Number::ANY
        }),
        needs: Some(not_with("profile", &[Value::Choice(ProfileCurve::Cosine.name())])),
        group: "Shape",
        label: "Softness",
        ..ROW
    };
    PROFILE: ProfileCurve = "How light falls from the inner cone to the edge.", Parameter {
        name: "profile",
        path: "profile",
        of: &conical(Value::Choice(ProfileCurve::Smooth.name()), Radiance),
        kind: Kind::Choice(ProfileCurve::CHOICES),
        animates: false,
        group: "Shape",
        label: "Profile",
        ..ROW
    };
    PROFILE_POWER: f64 = "Exponent of the power and cosine profiles.", Parameter {
        name: "profilePower",
        path: "profilePower",
        of: &conical(Value::Number(1.0), Radiance),
        kind: Kind::Number(Number {
            min: Excluded(0.0),
            max: Included(1000.0),
            slider: Some([0.1, 100.0]),
            step: 0.1,
            scale: Scale::Logarithmic,
            ..Number::ANY
        }),
        needs: Some(only_with(
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
        of: &conical(Value::Choice(CrossSection::Circle.name()), Radiance),
        kind: Kind::Choice(CrossSection::CHOICES),
        animates: false,
        group: "Section",
        label: "Outline",
        ..ROW
    };
    SECTION_WIDTH: f64 = "Half width of a superellipse, in radii.", Parameter {
        name: "sectionWidth",
        path: "sectionWidth",
        of: &conical(Value::Number(1.0), Radiance),
        kind: Kind::Number(HALF_EXTENT),
        needs: Some(SUPERELLIPSE),
        group: "Section",
        label: "Width",
        ..ROW
    };
    SECTION_HEIGHT: f64 = "Half height of a superellipse, in radii.", Parameter {
        name: "sectionHeight",
        path: "sectionHeight",
        of: &conical(Value::Number(1.0), Radiance),
        kind: Kind::Number(HALF_EXTENT),
        needs: Some(SUPERELLIPSE),
        group: "Section",
        label: "Height",
        ..ROW
    };
    SECTION_ROUNDNESS: f64 = "From 0, a rectangle, to 1, an ellipse. What would reach past the light's radius is made smaller as a whole.",
    Parameter {
        name: "sectionRoundness",
        path: "sectionRoundness",
        of: &conical(Value::Number(1.0), Radiance),
        kind: Kind::Number(Number {
            min: Included(0.0),
            max: Included(1.0),
            slider: Some([0.0, 1.0]),
            ..Number::ANY
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
        of: &conical(Value::Absent, Radiance),
        kind: Kind::PeriodicCurve { min: 0.001, max: 1.0, step: 0.01, absent: "Even all around" },
        group: "Section",
        label: "Radial falloff",
        ..ROW
    };
    RANGE: Option<f64> = "World distance at which the light ends, along the axis of a spotlight; endless without.",
    Parameter {
        name: "range",
        path: "range",
        of: &[of(Spot, Value::Absent, Radiance), of(Omni, Value::Absent, Radiance)],
        kind: Kind::Number(Number {
            unit: "world units",
            min: Excluded(0.0),
            slider: Some([0.1, 20.0]),
            step: 0.05,
            scale: Scale::Logarithmic,
            absent: Some("Endless"),
            ..Number::ANY
        }),
        group: "Shape",
        label: "Range",
        ..ROW
    };
    WIDTH: Option<f64> = "How far it shines across its local X; over all of the scene without.", Parameter {
        name: "width",
        path: "width",
        of: &[of(Directional, Value::Absent, ShadowMap)],
        kind: window("Any width"),
        group: "Shape",
        label: "Width",
        ..ROW
    };
    HEIGHT: Option<f64> = "How far it shines across its local Y; over all of the scene without.", Parameter {
        name: "height",
        path: "height",
        of: &[of(Directional, Value::Absent, ShadowMap)],
        kind: window("Any height"),
        group: "Shape",
        label: "Height",
        ..ROW
    };
    END_MODE: EndMode = "What happens past the last control point.", Parameter {
        name: "endMode",
        path: "endMode",
        of: &[of(Bendy, Value::Choice(EndMode::Cut.name()), ShadowMap)],
        kind: Kind::Choice(EndMode::CHOICES),
        animates: false,
        group: "Shape",
        label: "End",
        ..ROW
    };
    DIRECTION: Direction = "Which direction light arrives from.", Parameter {
        name: "direction",
        path: "direction",
        of: &[of(Bendy, Value::Choice(Direction::Tube.name()), Radiance)],
        kind: Kind::Choice(Direction::CHOICES),
        animates: false,
        group: "Shape",
        label: "Direction",
        ..ROW
    };
    FRAME: Frame = "How the cross-section is oriented along the curve.", Parameter {
        name: "frame",
        path: "frame",
        of: &[of(Bendy, Value::Choice(Frame::RotationMinimizing.name()), ShadowMap)],
        kind: Kind::Choice(Frame::CHOICES),
        animates: false,
        group: "Shape",
        label: "Frame",
        ..ROW
    };
    UP: DVec3 = "Light-local direction that orients the cross-section at the source.", Parameter {
        name: "up",
        path: "up",
        of: &[of(Bendy, Value::Vector(DVec3::Y), ShadowMap)],
        kind: Kind::Vector { unit: "", step: 0.01 },
        group: "Shape",
        label: "Up",
        ..ROW
    };
    SHADOW_ENABLE: bool = "Whether anything shadows it.", Parameter {
        name: "shadowEnable",
        path: "shadowEnable",
        of: &every(Value::Flag(true), Radiance),
        kind: Kind::Flag,
        group: "Shadow",
        label: "Shadows",
        ..ROW
    };
    SHADOW_COLOR: DVec3 = "Linear RGB: the share of the light that reaches what is in its shadow.", Parameter {
        name: "shadowColor",
        path: "shadowColor",
        of: &every(Value::Vector(DVec3::ZERO), Radiance),
        kind: Kind::Color,
        needs: Some(SHADOWS),
        group: "Shadow",
        label: "Shadow color",
        ..ROW
    };
    LIGHT_LINK: Option<Links> = "Nodes that it lights, each with all that is under it. The deepest entry decides, and exclude over include.", Parameter {
        name: "lightLink",
        path: "lightLink",
        of: &every(Value::Absent, Radiance),
        kind: Kind::Links,
        animates: false,
        group: "Links",
        label: "Lights",
        ..ROW
    };
    SHADOW_LINK: Option<Links> = "Nodes that throw shadows in it, each with all that is under it. The deepest entry decides, and exclude over include.", Parameter {
        name: "shadowLink",
        path: "shadowLink",
        of: &every(Value::Absent, ShadowMap),
        kind: Kind::Links,
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
        of: &[Of { owner: Point, default: None, touches: ShadowMap }],
        kind: Kind::Vector { unit: "light-local units", step: 0.01 },
        group: "Control point",
        label: "Position",
        ..ROW
    };
    RADIUS: f64 = "Radius of the tube, light-local.", Parameter {
        name: "radius",
        path: "radii",
        of: &[Of { owner: Point, default: None, touches: ShadowMap }],
        kind: Kind::Number(Number { unit: "light-local units", min: Included(0.0), ..Number::ANY }),
        group: "Control point",
        label: "Radius",
        ..ROW
    };
    POINT_COLOR: DVec3 = "Linear RGB there, as a factor of the whole light's color.", Parameter {
        name: "color",
        path: "colors",
        of: &[of(Point, Value::Vector(DVec3::ONE), Radiance)],
        kind: Kind::Color,
        group: "Control point",
        label: "Color",
        ..ROW
    };
    POINT_INTENSITY: f64 = "How bright it is there, as a factor of the whole light's intensity.", Parameter {
        name: "intensity",
        path: "intensities",
        of: &[of(Point, Value::Number(1.0), Radiance)],
        kind: Kind::Number(Number { slider: Some([0.0, 10.0]), step: 0.05, min: Unbounded, ..Number::ANY }),
        group: "Control point",
        label: "Intensity",
        ..ROW
    };
}

static TABLE: OnceLock<Table> = OnceLock::new();

struct Table {
    rows: Vec<&'static Parameter>,
    /// Those of each owner, in the order of [`Owner`].
    by_owner: [Vec<&'static Parameter>; Owner::COUNT],
}

impl Table {
    fn new(more: &[&'static Parameter]) -> Self {
        let rows: Vec<_> = [LIGHT_ROWS, more, POINT_ROWS].concat();
        let of = |owner| rows.iter().copied().filter(|row| row.of(owner).is_some()).collect();
        let by_owner = Owner::ALL.map(of);
        Self { rows, by_owner }
    }
}

/// Adds rows to those of lights, before anything has looked at the table; false where something has. For whoever tries a
/// parameter out, tests above all.
pub fn add_parameters(more: &[&'static Parameter]) -> bool {
    TABLE.set(Table::new(more)).is_ok()
}

/// The rows of lights and control points.
pub fn parameters() -> &'static [&'static Parameter] {
    &TABLE.get_or_init(|| Table::new(&[])).rows
}

/// The rows that an owner has, in order.
pub fn parameters_of(owner: Owner) -> &'static [&'static Parameter] {
    &TABLE.get_or_init(|| Table::new(&[])).by_owner[owner as usize]
}

/// The row of that name that an owner has.
pub fn parameter_of(owner: Owner, name: &str) -> Option<&'static Parameter> {
    parameters_of(owner).iter().copied().find(|row| row.name == name)
}

impl ControlPoint {
    /// The value of a parameter of control points; `None` where it is of something else.
    pub fn value(&self, parameter: &Parameter) -> Option<Value> {
        Some(match parameter.name {
            "position" => Value::Vector(self.position),
            "radius" => Value::Number(self.radius),
            "intensity" => Value::Number(self.intensity),
            "color" => Value::Vector(self.color),
            _ => return None,
        })
    }

    /// Sets what is of control points; what is not changes nothing.
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
