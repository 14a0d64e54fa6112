//! Insertion and removal of control points.

use light::parameters::{POSITION, RADIUS};
use light::{ControlPoint, Light, LightId, Parameter, Tube};

use crate::{Change, Command, ControlPoints, Document, EditError, NumberedLight, PointNumbering};

/// Makes the change that inserts or removes a control point. `placed` has control points.
pub fn renumbering_change(
    document: &Document,
    id: LightId,
    placed: &NumberedLight,
    command: &Command,
) -> Result<Change, EditError> {
    let points = placed.light.light().points();
    let count = points.len();
    let no_point = |point| EditError::NoPoint { light: document.light_name(id), point, count };
    let new = match *command {
        Command::InsertPoint { point: 0, .. } | Command::RemovePoint { point: 0, .. } => {
            return Err(EditError::Source);
        }
        Command::InsertPoint { point, .. } if point > count => return Err(no_point(point)),
        Command::InsertPoint { point, position, radius, color, intensity, .. } => {
            let set = |mut points: Vec<ControlPoint>| {
                let new = &mut points[point];
                new.position = position.unwrap_or(new.position);
                new.radius = radius.unwrap_or(new.radius);
                new.color = color.unwrap_or(new.color);
                new.intensity = intensity.unwrap_or(new.intensity);
                points
            };
            let near = if position.is_some() || point == count {
                InsertedPoint::Between { at: point }
            } else {
                InsertedPoint::Corner { at: point.min(count - 2) }
            };
            let (new, spread) =
                (set(with_inserted_point(points, near)), set(with_inserted_point(points, InsertedPoint::Respaced)));
            // A bend at its limit has no room for another point. Spreading all points makes room.
            let folds = |points: &[ControlPoint]| is_invalid_with(placed.light.light(), points);
            if position.is_none() && folds(&new) && !folds(&spread) { spread } else { new }
        }
        Command::RemovePoint { point, .. } if point < count => {
            let mut fewer = points.to_vec();
            fewer.remove(point);
            fewer
        }
        Command::RemovePoint { point, .. } => return Err(no_point(point)),
        _ => return Err(EditError::NoLight(id)),
    };
    let old = ControlPoints { layout: placed.layout, points: points.to_vec() };
    let new = ControlPoints { layout: PointNumbering(document.next_number()), points: new };
    Ok(Change::ControlPoints { light: id, old, new })
}

/// Makes the changes that move a light's control points to those of `moved`, with their radii. The source has no
/// position to change.
pub fn point_move_changes(light: LightId, placed: &NumberedLight, moved: &[ControlPoint]) -> Vec<Change> {
    let points = placed.light.light().points();
    let change = |point: usize, parameter: &'static Parameter| {
        let (old, new) = (points[point].value(parameter)?, moved.get(point)?.value(parameter)?);
        Some(Change::Point { light, layout: placed.layout, point, parameter, old, new })
    };
    let positions = (1..points.len()).filter_map(|point| change(point, POSITION.row()));
    positions.chain((0..points.len()).filter_map(|point| change(point, RADIUS.row()))).collect()
}

/// Way in which the values of an inserted control point, and of the points beside it, are chosen.
#[derive(Clone, Copy)]
enum InsertedPoint {
    /// Halfway between the adjacent values or, past the last, extrapolated.
    Between { at: usize },
    /// The value at a corner becomes two, a quarter of the way to each adjacent value, as Chaikin's subdivision cuts
    /// corners. A curve that bends there keeps nearly the same bend.
    Corner { at: usize },
    /// All control points are spread evenly along the polyline through them. That makes the curve smoother.
    Respaced,
}

/// Inserts a control point into three or more.
fn with_inserted_point(points: &[ControlPoint], insertion: InsertedPoint) -> Vec<ControlPoint> {
    let mut more = points.to_vec();
    match insertion {
        InsertedPoint::Between { at } if at == points.len() => {
            more.push(extrapolated_point(points[at - 2], points[at - 1]));
        }
        InsertedPoint::Between { at } => more.insert(at, blend(points[at - 1], points[at], 0.5)),
        InsertedPoint::Corner { at } => {
            more[at] = blend(points[at], points[at - 1], 0.25);
            more.insert(at + 1, blend(points[at], points[at + 1], 0.25));
        }
        InsertedPoint::Respaced => {
            let last = points.len() - 1;
            more = (0..=points.len())
                .map(|index| {
                    // Index of the point before, and the share of the distance to the next, in whole numbers.
                    let (before, part) = (index * last / points.len(), index * last % points.len());
                    blend(points[before], points[(before + 1).min(last)], part as f64 / points.len() as f64)
                })
                .collect();
        }
    }
    more
}

/// Interpolates linearly between `a` at `t` = 0 and `b` at `t` = 1.
fn blend(a: ControlPoint, b: ControlPoint, t: f64) -> ControlPoint {
    let level = |a: f64, b: f64| a + (b - a) * t;
    ControlPoint {
        position: a.position.lerp(b.position, t),
        radius: level(a.radius, b.radius).max(0.0),
        color: a.color.lerp(b.color, t),
        intensity: level(a.intensity, b.intensity),
    }
}

/// Extrapolates position and radius past the last point `b`. Colour and intensity are those of `b`.
fn extrapolated_point(a: ControlPoint, b: ControlPoint) -> ControlPoint {
    let ControlPoint { position, radius, .. } = blend(a, b, 2.0);
    let ControlPoint { color, intensity, .. } = blend(a, b, 1.0);
    ControlPoint { position, radius, color, intensity }
}

/// Returns true if `light` cannot be evaluated with these control points.
fn is_invalid_with(light: &Light, points: &[ControlPoint]) -> bool {
    let mut other = light.clone();
    if let Some(own) = other.points_mut() {
        *own = points.to_vec();
    }
    Tube::<f64>::new(&other).is_err()
}
