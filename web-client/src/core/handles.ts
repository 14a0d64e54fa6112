// Handles of a light, and the command for each position of the pointer.
//
// A drag's command depends on where it began and where the pointer is now, never on the way between.

import { depthOf, inPlaneOf, type Pixel, project, type View, worldPerPixel } from "./camera";
import { abscissa, numberAt, positionAt, weightOf } from "./curve";
import type { LightId } from "./ids";
import { circle, sideways, toLocal, type Tube } from "./outline";
import type { Command, DragRadii, Light } from "./protocol";
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

/** Pixels by which a ring's far half must be nearer to the pointer than its near half to be grabbed. */
const BEHIND_PX = 5;

/** A light as it is drawn, and from where. */
export interface Drawn {
  id: LightId;
  light: Light;
  tube: Tube;
  view: View;
  /** Treatment of radii when a control point is dragged. */
  radii: DragRadii;
}

/** The control points' and edges' handles of a light; its source and turning rings come with every light. */
export function handlesOf(light: Light): Handle[] {
  if (light.type === "spot") return [{ kind: "cone" }];
  if (light.type !== "bendy") return [];
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

/** World position of a point handle; that of a turning ring is the source. */
export function positionOf(handle: Handle, { light, tube, view }: Drawn): Vec3 {
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

/** A handle that is pulled along, rather than turned. */
export type Pulled = Exclude<Handle, { kind: "turn" }>;

/** A handle that goes wherever it is taken. */
export type Movable = Extract<Handle, { kind: "source" | "point" }>;

export const isMovable = (handle: Handle): handle is Movable =>
  handle.kind === "source" || handle.kind === "point";

/** Grabs `handle` with the pointer at `from`: the answer says what each later position of the pointer means. */
export function grab(handle: Handle, drawn: Drawn, from: Pixel): (pointer: Pixel) => Command {
  const { light, view } = drawn;
  if (handle.kind === "turn") {
    const axis = turnAxis(light, handle.axis);
    const angle = turning(drawn, axis, from);
    return (pointer) => turned(drawn, axis, angle(pointer));
  }
  const at = positionOf(handle, drawn);
  const grabbed = inPlaneOf(view, from, at);
  return (pointer) => pulled(handle, drawn, sub(inPlaneOf(view, pointer, at), grabbed));
}

/** Command for a pull of `handle` by `way`, in the world. For an edge only the part across the tube counts. */
export function pulled(handle: Pulled, drawn: Drawn, way: Vec3): Command {
  const { id, light, tube, view, radii } = drawn;
  switch (handle.kind) {
    case "source":
      return { type: "placeLight", light: id, translation: add(light.transform.translation, way) };
    case "point": {
      const position = toLocal(light.transform, add(positionOf(handle, drawn), way));
      return { type: "dragPoint", light: id, point: handle.point, position, radii };
    }
    case "radius": {
      const { point } = handle;
      const t = abscissa(tube.points.length, point);
      const weight = weightOf(tube.points.length, point, t);
      const wanted = (tube.radii[point] ?? 0) + dot(way, sideways(tube, t, view.camera)) / weight;
      const radius = Math.max(0, wanted / light.transform.scale);
      return { type: "setPoint", light: id, point, parameter: { radius } };
    }
    case "cone": {
      const reach = length(sub(positionAt(tube.points, 1), light.transform.translation));
      const radius = numberAt(tube.radii, 1) + dot(way, sideways(tube, 1, view.camera));
      const degrees = (Math.atan2(radius, reach) * 180) / Math.PI;
      const coneAngle = Math.min(Math.max(degrees, CONE_ANGLES.least), CONE_ANGLES.most);
      return { type: "setLight", light: id, parameter: { coneAngle } };
    }
  }
}

/** Turns the light by `radians` about the unit vector `axis` in the world. */
export function turned({ id, light }: Drawn, axis: Vec3, radians: number): Command {
  const rotation = unitQuat(compose(aboutAxis(axis, radians), light.transform.rotation));
  return { type: "placeLight", light: id, rotation };
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
 * Radians for each position of the pointer: how far it went along the ring's tangent, as the camera sees it,
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
  // A ring hardly moves on the screen while it runs towards the camera: this is its speed of rotation there.
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
