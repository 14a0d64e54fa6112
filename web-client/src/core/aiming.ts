// Directions of lights from their sources, lights that are turned, and views from their sources.

import { tangentAt } from "./curve";
import type { LightId } from "./ids";
import { diagonal } from "./navigation";
import type { Bounds, Camera, Command, Light } from "./protocol";
import {
  compose,
  cross,
  dot,
  fromAxes,
  length,
  mix,
  perpendicular,
  type Quat,
  rotate,
  scale,
  sub,
  unit,
  unitQuat,
  type Vec3,
} from "./vector";

/** Unit vector in the world along which the middle of the light leaves its source; an omni light's is its local -Z. */
export function axisOf(light: Light): Vec3 {
  const local: Vec3 = light.type === "bendy" ? unit(tangentAt(light.points, 0), [0, 0, -1]) : [0, 0, -1];
  return rotate(light.transform.rotation, local);
}

/** Turns the light the shortest way until its axis points at `target`; `null` for a target at the source. */
export function aimedAt(id: LightId, light: Light, target: Vec3): Command | null {
  const { translation, rotation } = light.transform;
  const way = sub(target, translation);
  if (length(way) < 1e-9) return null;
  const turn = shortestTurn(axisOf(light), unit(way));
  return { type: "placeLight", light: id, rotation: unitQuat(compose(turn, rotation)) };
}

/** The rotation between two unit vectors. */
function shortestTurn(from: Vec3, to: Vec3): Quat {
  const cosine = dot(from, to);
  // Halfway around all ways are as short.
  if (cosine < -1 + 1e-12) return [...perpendicular(from), 0];
  return unitQuat([...cross(from, to), 1 + cosine]);
}

/** The widest that a view can be, and that of an omni light, radians. */
const WIDEST = (170 * Math.PI) / 180;
const OMNI = Math.PI / 2;
/** Share of the scene's diagonal within which nothing is visible. */
const NEAR_SHARE = 1e-4;

/** A camera at the light's source that looks along its axis. It frames the light's cone, of an omni light a quarter turn; of
 * a directional light what it shines on, from outside of the scene. */
export function cameraThrough(light: Light, bounds: Bounds): Camera {
  const from = light.transform.translation;
  const axis = axisOf(light);
  const size = diagonal(bounds);
  const rotation = lookingAlong(axis, light);
  if (light.type === "directional") {
    const { width, height = size } = light;
    const isEndless = width === undefined && light.height === undefined;
    const middle = isEndless ? mix(bounds.min, bounds.max, 0.5) : from;
    const translation = sub(middle, scale(axis, size));
    const aspectRatio = (width ?? size) / height;
    const projection = { orthographic: { ymag: height / 2, aspectRatio, znear: 0, zfar: 3 * size } };
    return { name: "", translation, rotation, projection };
  }
  const angle = light.type === "omni" ? OMNI : (2 * light.coneAngle * Math.PI) / 180;
  const perspective = { yfov: Math.min(angle, WIDEST), aspectRatio: 1, znear: NEAR_SHARE * size };
  return { name: "", translation: from, rotation, projection: { perspective } };
}

/** Looks along `axis`, with what is up in the light upwards. */
function lookingAlong(axis: Vec3, light: Light): Quat {
  const back = scale(axis, -1);
  const up = rotate(light.transform.rotation, light.type === "bendy" ? light.up : [0, 1, 0]);
  const right = unit(cross(up, back), perpendicular(back));
  return fromAxes(right, cross(back, right), back);
}
