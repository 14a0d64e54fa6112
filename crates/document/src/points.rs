//! One control point more or less.

use glam::DVec3;
use light::{BendyLight, Tube};

use crate::{Change, Command, ControlPoints, Document, EditError, Layout, PlacedLight};
use light::LightId;

/// The control points after one is inserted or removed, as a change.
pub fn renumbered(
    document: &Document,
    id: LightId,
    (placed, bendy): (&PlacedLight, &BendyLight),
    command: &Command,
) -> Result<Change, EditError> {
    let count = bendy.points.len();
    let Some(old) = ControlPoints::of(placed) else { return Err(EditError::NoLight(id)) };
    let mut new = ControlPoints { layout: Layout(document.next_number()), ..old.clone() };
    let no_point = |point| EditError::NoPoint { light: document.light_name(id), point, count };
    match *command {
        Command::InsertPoint { point: 0, .. } | Command::RemovePoint { point: 0, .. } => {
            return Err(EditError::Source);
        }
        Command::InsertPoint { point, .. } if point > count => return Err(no_point(point)),
        Command::InsertPoint { point, position, radius, color, intensity, .. } => {
            let set = |mut new: ControlPoints| {
                new.points[point] = position.unwrap_or(new.points[point]);
                new.radii[point] = radius.unwrap_or(new.radii[point]);
                new.colors[point] = color.unwrap_or(new.colors[point]);
                new.intensities[point] = intensity.unwrap_or(new.intensities[point]);
                new
            };
            let near = if position.is_some() || point == count {
                Place::Between { at: point }
            } else {
                Place::Corner { at: point.min(count - 2) }
            };
            let spread = set(with_another(&new, Place::Spread));
            new = set(with_another(&new, near));
            // Where a bend is as tight as it may be there is no room for a point; all of them spread anew make some.
            if position.is_none() && folds(bendy, &new) && !folds(bendy, &spread) {
                new = spread;
            }
        }
        Command::RemovePoint { point, .. } if point < count => {
            new.points.remove(point);
            new.radii.remove(point);
            new.colors.remove(point);
            new.intensities.remove(point);
        }
        Command::RemovePoint { point, .. } => return Err(no_point(point)),
        _ => return Err(EditError::NoLight(id)),
    }
    Ok(Change::ControlPoints { light: id, old, new })
}

/// How one value more comes among those of the control points.
#[derive(Clone, Copy)]
enum Place {
    /// Halfway between its neighbours or, past the last, as far again.
    Between { at: usize },
    /// The value at a corner becomes two, a quarter of the way to each neighbour, as Chaikin's subdivision cuts corners: a
    /// curve that bends there bends nearly as before.
    Corner { at: usize },
    /// All values are spread evenly along the line through them. The curve grows smoother.
    Spread,
}

/// The control points with one more.
fn with_another(now: &ControlPoints, place: Place) -> ControlPoints {
    let level = |a: f64, b: f64, t: f64| a + (b - a) * t;
    ControlPoints {
        layout: now.layout,
        // Past the last point position and radius go on as they were going, colour and intensity as they are.
        points: another(&now.points, place, 2.0, DVec3::lerp),
        radii: another(&now.radii, place, 2.0, |a, b, t| level(a, b, t).max(0.0)),
        colors: another(&now.colors, place, 1.0, DVec3::lerp),
        intensities: another(&now.intensities, place, 1.0, level),
    }
}

/// `values`, three or more, with one more. `blend(a, b, t)` is `a` at 0 and `b` at 1; past the last, t is `beyond`.
fn another<T: Copy>(values: &[T], place: Place, beyond: f64, blend: impl Fn(T, T, f64) -> T) -> Vec<T> {
    let mut more = values.to_vec();
    match place {
        Place::Between { at } if at == values.len() => {
            more.push(blend(values[at - 2], values[at - 1], beyond));
        }
        Place::Between { at } => more.insert(at, blend(values[at - 1], values[at], 0.5)),
        Place::Corner { at } => {
            more[at] = blend(values[at], values[at - 1], 0.25);
            more.insert(at + 1, blend(values[at], values[at + 1], 0.25));
        }
        Place::Spread => {
            let last = values.len() - 1;
            more = (0..=values.len())
                .map(|index| {
                    // Index of the value before, and the share of the way to the next, in whole numbers.
                    let (before, part) = (index * last / values.len(), index * last % values.len());
                    let next = values[(before + 1).min(last)];
                    blend(values[before], next, part as f64 / values.len() as f64)
                })
                .collect();
        }
    }
    more
}

/// Whether the light cannot be evaluated with these control points.
fn folds(bendy: &BendyLight, points: &ControlPoints) -> bool {
    let ControlPoints { points, radii, colors, intensities, .. } = points.clone();
    Tube::<f64>::new(&BendyLight { points, radii, colors, intensities, ..bendy.clone() }).is_err()
}
