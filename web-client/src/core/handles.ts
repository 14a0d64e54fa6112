// What can be grabbed on a light, and the command that each place of the pointer then means.
//
// A drag's command depends on where it began and where the pointer is now, never on the way between.

import { depthOf, inPlaneOf, type Pixel, project, type View, worldPerPixel } from "./camera";
import { abscissa, numberAt, positionAt, weightOf } from "./curve";
import type { LightId } from "./ids";
import { circle, sideways, toLocal, type Tube } from "./outline";
import type { Command, Light } from "./protocol";
import {
  aboutAxis,
  add,
  compose,
  cross,
  dot,
  length,
  rotate,
  scale,
  sub,
  unitQuat,
  type Vec3,
} from "./vector";

export type Axis = 0 | 1 | 2;

export type Handle =
  /** Moves the whole light. */
  | { kind: "source" }
  | { kind: "point"; point: number }
  /** The edge of the tube where a control point pulls most. */
  | { kind: "radius"; point: number }
  /** Turns the light about one of its own axes through its source. */
  | { kind: "turn"; axis: Axis }
  /** The edge of a spotlight's cone. */
  | { kind: "cone" };

/** Radius of the rings that turn a light, pixels. */
export const TURN_RADIUS_PX = 58;
/** Cone angles that the model takes, degrees. */
const CONE_ANGLES = { least: 0.1, most: 89.9 };

/** How much nearer to the pointer a ring's far half must be than its near half to be grabbed, pixels. */
const BEHIND_PX = 5;

/** A light as it is drawn, and from where. */
export interface Drawn {
  id: LightId;
  light: Light;
  tube: Tube;
  view: View;
}

/** The control points' and edges' handles of a light; its source and turning rings come with every light. */
export function handlesOf(light: Light): Handle[] {
  if (light.type === "spot") return [{ kind: "cone" }];
  const points = light.points.map((_, point) => point);
  return [
    ...points.map((point): Handle => ({ kind: "radius", point })),
    ...points.slice(1).map((point): Handle => ({ kind: "point", point })),
  ];
}

/** The handle's name in the page. */
export function handleName(handle: Handle): string {
  switch (handle.kind) {
    case "point":
    case "radius":
      return `${handle.kind}-${handle.point}`;
    case "turn":
      return `turn-${"xyz"[handle.axis]}`;
    default:
      return handle.kind;
  }
}

/** Where in the world a point handle is; a turning ring's is the source. */
export function placeOf(handle: Handle, { light, tube, view }: Drawn): Vec3 {
  switch (handle.kind) {
    case "source":
    case "turn":
      return light.transform.translation;
    case "point":
      return tube.points[handle.point] ?? light.transform.translation;
    case "radius":
      return edgeAt(tube, abscissa(tube.points.length, handle.point), view);
    case "cone":
      return edgeAt(tube, 1, view);
  }
}

/** Grabs `handle` with the pointer at `from`: the answer says what each later place of the pointer means. */
export function grab(handle: Handle, drawn: Drawn, from: Pixel): (pointer: Pixel) => Command {
  const { id, light, tube, view } = drawn;
  const place = placeOf(handle, drawn);
  const grabbed = inPlaneOf(view, from, place);
  const moved = (pointer: Pixel): Vec3 => sub(inPlaneOf(view, pointer, place), grabbed);
  switch (handle.kind) {
    case "source":
      return (pointer) => ({ type: "placeLight", light: id, translation: add(place, moved(pointer)) });
    case "point": {
      const { point } = handle;
      const position = (pointer: Pixel) => toLocal(light.transform, add(place, moved(pointer)));
      return (pointer) => ({
        type: "setPoint",
        light: id,
        point,
        parameter: { position: position(pointer) },
      });
    }
    case "radius": {
      const { point } = handle;
      const t = abscissa(tube.points.length, point);
      const side = sideways(tube, t, view.camera);
      const weight = weightOf(tube.points.length, point, t);
      const radius = (pointer: Pixel) => {
        const wanted = (tube.radii[point] ?? 0) + dot(moved(pointer), side) / weight;
        return Math.max(0, wanted / light.transform.scale);
      };
      return (pointer) => ({ type: "setPoint", light: id, point, parameter: { radius: radius(pointer) } });
    }
    case "turn": {
      const axis = turnAxis(light, handle.axis);
      const angle = turning(drawn, axis, from);
      const rotation = (pointer: Pixel) =>
        unitQuat(compose(aboutAxis(axis, angle(pointer)), light.transform.rotation));
      return (pointer) => ({ type: "placeLight", light: id, rotation: rotation(pointer) });
    }
    case "cone": {
      const side = sideways(tube, 1, view.camera);
      const reach = length(sub(positionAt(tube.points, 1), light.transform.translation));
      const coneAngle = (pointer: Pixel) => {
        const radius = numberAt(tube.radii, 1) + dot(moved(pointer), side);
        const degrees = (Math.atan2(radius, reach) * 180) / Math.PI;
        return Math.min(Math.max(degrees, CONE_ANGLES.least), CONE_ANGLES.most);
      };
      return (pointer) => ({ type: "setLight", light: id, parameter: { coneAngle: coneAngle(pointer) } });
    }
  }
}

/** The light's own axis in the world. */
export function turnAxis(light: Light, axis: Axis): Vec3 {
  const local: Vec3 = [0, 0, 0];
  local[axis] = 1;
  return rotate(light.transform.rotation, local);
}

/** Radius of the turning rings in the world. */
export const turnRadius = ({ light, view }: Drawn): number =>
  TURN_RADIUS_PX * worldPerPixel(view, light.transform.translation);

/**
 * Radians for each place of the pointer: how far it went along the ring's tangent, as the camera sees it,
 * where the ring was grabbed.
 */
function turning(drawn: Drawn, axis: Vec3, from: Pixel): (pointer: Pixel) => number {
  const { light, view } = drawn;
  const centre = light.transform.translation;
  const grabbed = nearestOnRing(view, circle(centre, axis, turnRadius(drawn)), centre, from);
  const step = 0.01;
  const ahead = add(grabbed, scale(cross(axis, sub(grabbed, centre)), step));
  const [a, b] = [project(view, grabbed), project(view, ahead)];
  if (a === null || b === null) return () => 0;
  const perRadian: Pixel = { x: (b.x - a.x) / step, y: (b.y - a.y) / step };
  const squared = perRadian.x ** 2 + perRadian.y ** 2;
  // Where a ring runs towards the camera it hardly moves on the screen: this is how fast it turns there.
  const least = (TURN_RADIUS_PX / 3) ** 2;
  return ({ x, y }) => ((x - from.x) * perRadian.x + (y - from.y) * perRadian.y) / Math.max(squared, least);
}

/** The point of the ring that is seen nearest to `pixel`; of its two halves rather the one in front. */
function nearestOnRing(view: View, ring: readonly Vec3[], centre: Vec3, pixel: Pixel): Vec3 {
  const middle = depthOf(view.camera, centre);
  const distance = (point: Vec3): number => {
    const seen = project(view, point);
    if (seen === null) return Infinity;
    const behind = depthOf(view.camera, point) > middle ? BEHIND_PX : 0;
    return Math.hypot(seen.x - pixel.x, seen.y - pixel.y) + behind;
  };
  return ring.reduce((best, point) => (distance(point) < distance(best) ? point : best));
}

function edgeAt(tube: Tube, t: number, view: View): Vec3 {
  return add(positionAt(tube.points, t), scale(sideways(tube, t, view.camera), numberAt(tube.radii, t)));
}
