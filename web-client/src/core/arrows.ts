// Arrows that pull a control point or the source along one way alone: a world axis, or towards the eye and away from it.

import { depthOf, type Pixel, project, screenVelocity, towardsEye, type View, worldPerPixel } from "./camera";
import { type Axis, type Drawn, type Movable, positionOf, pulled, TURN_RADIUS_PX } from "./handles";
import type { Command, Light } from "./protocol";
import { add, length, scale, sub, type Vec3 } from "./vector";

/** A world axis, or the way to the eye. */
export type Way = Axis | "depth";

export interface Arrow {
  moves: Movable;
  way: Way;
}

/** Ends of an arrow in the picture. */
export interface ArrowSpan {
  tail: Pixel;
  tip: Pixel;
}

const WAYS: readonly Way[] = [0, 1, 2, "depth"];
/** From what an arrow moves to its tail, and its length where it is seen from the side, pixels. */
const TAIL_PX = { point: 13, source: TURN_RADIUS_PX + 13 };
const LENGTH_PX = 36;
/** An axis that is seen so nearly end on has no arrow: a pixel along it would be a leap. */
const LEAST_SHARE = 0.25;
/** Ways of the depth arrow on the screen: the first that leaves this much of a turn to the axes' arrows, if one does. */
const DEPTH_WAYS: readonly Pixel[] = [
  [-1, 1],
  [1, 1],
  [-1, -1],
  [1, -1],
  [0, 1],
].map(([x = 0, y = 0]) => ({ x: x / Math.hypot(x, y), y: y / Math.hypot(x, y) }));
const APART_RADIANS = 0.45;
/** Towards its vanishing point an axis runs at most so many times as fast as where it was grabbed. */
const FASTEST = 10;

/** The arrows of what is selected: a control point, or with `null` and at point 0 the light as a whole. */
export function arrowsOf(light: Light, point: number | null): Arrow[] {
  const isPoint = light.type === "bendy" && point !== null && point > 0 && point < light.points.length;
  const moves: Movable = isPoint ? { kind: "point", point } : { kind: "source" };
  return WAYS.map((way) => ({ moves, way }));
}

/** The arrow's name in the page. */
export const arrowName = ({ way }: Arrow): string => `pull-${way === "depth" ? way : "xyz"[way]}`;

/** Ends of the arrow in the picture; `null` if its origin is not visible, or its axis is seen end on. */
export function spanOf({ moves, way }: Arrow, drawn: Drawn): ArrowSpan | null {
  const { view } = drawn;
  const at = positionOf(moves, drawn);
  const middle = project(view, at);
  if (middle === null) return null;
  const tail = TAIL_PX[moves.kind];
  const from = (by: Pixel, px: number): Pixel => ({ x: middle.x + by.x * px, y: middle.y + by.y * px });
  if (way === "depth") {
    const by = depthWay(view, at);
    return { tail: from(by, tail), tip: from(by, tail + LENGTH_PX) };
  }
  const shown = shownAxis(view, at, way);
  return shown === null ? null : { tail: from(shown, tail), tip: from(shown, tail + LENGTH_PX) };
}

/** Grabs `arrow` with the pointer at `from`: the answer says what each later position of the pointer means. */
export function grabArrow(arrow: Arrow, drawn: Drawn, from: Pixel): (pointer: Pixel) => Command {
  const { moves, way } = arrow;
  const { view } = drawn;
  const at = positionOf(moves, drawn);
  const pull = way === "depth" ? towardsAndAway(view, at) : alongAxis(view, at, way);
  return (pointer) => pulled(moves, drawn, pull({ x: pointer.x - from.x, y: pointer.y - from.y }));
}

/** Moves along the axis until the thing is seen beside the pointer, square to the axis on the screen. */
function alongAxis(view: View, at: Vec3, axis: Axis): (by: Pixel) => Vec3 {
  const direction = unitAxis(axis);
  const velocity = screenVelocity(view, at, direction);
  const speed = Math.hypot(velocity.x, velocity.y);
  // On the screen it goes s speed / (1 + s k) along the axis for s in the world, k being how fast its depth grows.
  const deepening = isPerspective(view) ? depthRate(view, at, direction) : 0;
  return ({ x, y }) => {
    const gone = (x * velocity.x + y * velocity.y) / speed;
    return scale(direction, gone / Math.max(speed - gone * deepening, speed / FASTEST));
  };
}

/** Down its arrow it comes nearer, up it goes away: always under the same pixel, and never behind the eye. */
function towardsAndAway(view: View, at: Vec3): (by: Pixel) => Vec3 {
  const eye = towardsEye(view.camera, at);
  const by = depthWay(view, at);
  const perPixel = worldPerPixel(view, at);
  const distance = length(sub(view.camera.translation, at));
  return ({ x, y }) => {
    const nearer = (x * by.x + y * by.y) * perPixel;
    return scale(eye, isPerspective(view) ? distance * (1 - Math.exp(-nearer / distance)) : nearer);
  };
}

/** The axis on the screen, at length 1; `null` where it is seen end on. */
function shownAxis(view: View, at: Vec3, axis: Axis): Pixel | null {
  const { x, y } = screenVelocity(view, at, unitAxis(axis));
  const speed = Math.hypot(x, y);
  return speed * worldPerPixel(view, at) < LEAST_SHARE ? null : { x: x / speed, y: y / speed };
}

/** The way to the eye has none on the screen, so it is given one of its own, off the axes. */
function depthWay(view: View, at: Vec3): Pixel {
  const shown = ([0, 1, 2] as const).flatMap((axis) => shownAxis(view, at, axis) ?? []);
  const apart = (way: Pixel) =>
    Math.min(Math.PI, ...shown.map(({ x, y }) => Math.acos(Math.min(1, x * way.x + y * way.y))));
  const [first = { x: 0, y: 1 }, ...others] = DEPTH_WAYS;
  const best = others.reduce((best, way) => (apart(way) > apart(best) + 1e-9 ? way : best), first);
  return DEPTH_WAYS.find((way) => apart(way) >= APART_RADIANS) ?? best;
}

const isPerspective = ({ camera }: View): boolean => "perspective" in camera.projection;

/** By how much of itself its depth grows for each unit along `direction`. */
const depthRate = (view: View, at: Vec3, direction: Vec3): number =>
  depthOf(view.camera, add(view.camera.translation, direction)) / depthOf(view.camera, at);

function unitAxis(axis: Axis): Vec3 {
  const direction: Vec3 = [0, 0, 0];
  direction[axis] = 1;
  return direction;
}
