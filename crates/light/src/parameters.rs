//! The table: all that can be set on lights and control points.
//!
//! Names are UsdLux's where it has them, glTF's next. A new parameter is a row here, its formula in f64 and in WGSL, and a
//! test of that; nothing else names it.

use std::ops::Bound::{Excluded, Included, Unbounded};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};

use crate::parameter::{
    Key, Kind, MAX_NAME_BYTES, Number, Of, Owner, Parameter, Scale, Setting, Touches, Value,
};
use crate::{ControlPoint, Decay, Direction, EndMode, Frame};

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
const fn every(default: Value<&'static str>, touches: Touches) -> [Of; 2] {
    [of(Spot, default, touches), of(Bendy, default, touches)]
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
    group: "",
    label: "",
    doc: "",
};

use Owner::{Bendy, Point, Spot};
use Touches::{Nothing, Radiance, ShadowMap};

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
    TRANSLATION: DVec3 = "World position of the source.", Parameter {
        name: "translation",
        path: "transform.translation",
        of: &every(Value::Vector(DVec3::ZERO), ShadowMap),
        kind: Kind::Vector { unit: "world units", step: 0.01 },
        group: "Light",
        label: "Position",
        ..ROW
    };
    ROTATION: DQuat = "Rotation from light-local to world axes. A spotlight shines along its local -Z.", Parameter {
        name: "rotation",
        path: "transform.rotation",
        of: &every(Value::Rotation(DQuat::IDENTITY), ShadowMap),
        kind: Kind::Rotation,
        group: "Light",
        label: "Rotation",
        ..ROW
    };
    SCALE: f64 = "World units per light-local unit. To a spotlight it only matters once it is bent.", Parameter {
        name: "scale",
        path: "transform.scale",
        of: &[of(Spot, Value::Number(1.0), Nothing), of(Bendy, Value::Number(1.0), ShadowMap)],
        kind: Kind::Number(Number { min: Excluded(0.0), slider: Some([0.1, 3.0]), ..Number::ANY }),
        group: "Light",
        label: "Scale",
        ..ROW
    };
    ENABLED: bool = "Whether it shines.", Parameter {
        name: "enabled",
        path: "enabled",
        of: &every(Value::Flag(true), Radiance),
        kind: Kind::Flag,
        group: "Light",
        label: "Enabled",
        ..ROW
    };
    COLOR: DVec3 = "Linear RGB.", Parameter {
        name: "color",
        path: "color",
        of: &[of(Spot, Value::Vector(DVec3::ONE), Radiance)],
        kind: Kind::Color,
        group: "Emission",
        label: "Color",
        ..ROW
    };
    INTENSITY: f64 = "How bright it is: candela with inverse-square decay.", Parameter {
        name: "intensity",
        path: "intensity",
        of: &[of(Spot, Value::Number(1.0), Radiance)],
        kind: Kind::Number(Number { slider: Some([0.0, 20.0]), step: 0.05, ..Number::ANY }),
        group: "Emission",
        label: "Intensity",
        ..ROW
    };
    EXPOSURE: f64 = "Stops by which all that it emits is brightened: a factor of 2 to this.", Parameter {
        name: "exposure",
        path: "exposure",
        of: &[of(Spot, Value::Number(0.0), Radiance), of(Bendy, Value::Number(0.0), Radiance)],
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
    DECAY: Decay = "How irradiance falls with the distance travelled.", Parameter {
        name: "decay",
        path: "decay",
        of: &[
            of(Spot, Value::Choice(Decay::InverseSquare.name()), Radiance),
            of(Bendy, Value::Choice(Decay::None.name()), Radiance),
        ],
        kind: Kind::Choice(Decay::CHOICES),
        animates: false,
        group: "Emission",
        label: "Decay",
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
        group: "Shape",
        label: "Softness",
        ..ROW
    };
    RANGE: Option<f64> = "World distance along the axis at which the light ends; endless without.", Parameter {
        name: "range",
        path: "range",
        of: &[of(Spot, Value::Absent, Radiance)],
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
    POINT_COLOR: DVec3 = "Linear RGB there.", Parameter {
        name: "color",
        path: "colors",
        of: &[of(Point, Value::Vector(DVec3::ONE), Radiance)],
        kind: Kind::Color,
        group: "Control point",
        label: "Color",
        ..ROW
    };
    POINT_INTENSITY: f64 = "How bright it is there: candela with inverse-square decay.", Parameter {
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
    by_owner: [Vec<&'static Parameter>; 4],
}

impl Table {
    fn new(more: &[&'static Parameter]) -> Self {
        let rows: Vec<_> = [LIGHT_ROWS, more, POINT_ROWS].concat();
        let of = |owner| rows.iter().copied().filter(|row| row.of(owner).is_some()).collect();
        let by_owner = [Owner::Spot, Owner::Bendy, Owner::Point, Owner::Camera].map(of);
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
