// Position of a new light: visible, beside the line from the eye to its target, and as bright there as a lit scene is.

import type { Camera, Spot } from "./protocol";
import { add, cross, fromAxes, length, rotate, scale, sub, unit, type Quat, type Vec3 } from "./vector";

/** Falloff of irradiance with distance. */
export type Decay = Spot["decay"];

/** A light's place, and how far it is from what it is aimed at. */
export interface Placement {
  translation: Vec3;
  rotation: Quat;
  distance: number;
}

/** Ways from what it is aimed at, each better than the next: to the right, upwards and towards the eye, in halves of the
 * picture's height there. */
const ASIDE: readonly Vec3[] = [
  [-0.4, 0.65, 0.65],
  [0.4, 0.65, 0.65],
  [0, 0.75, 0.6],
  [-0.65, 0.3, 0.7],
  [0.65, 0.3, 0.7],
  [0, 0.3, 0.95],
];
/** A wide lens sees far to all sides: a half is no more than this share of the way to the eye. */
const WIDEST_HALF = 0.5;
/** Irradiance that gives a white surface a radiance of 1: all of the screen's range, and no more. */
const IRRADIANCE = Math.PI;

/** Sources in sight of `camera`, aimed at `aim`, in the order in which they are to be tried: something may stand between. */
export function besideTheEye(camera: Camera, aim: Vec3): Placement[] {
  const away = length(sub(camera.translation, aim));
  const { projection } = camera;
  const half =
    "perspective" in projection
      ? Math.min(Math.tan(projection.perspective.yfov / 2), WIDEST_HALF) * away
      : Math.min(projection.orthographic.ymag, away);
  return ASIDE.map((way) => aimedFrom(camera, add(aim, rotate(camera.rotation, scale(way, half))), aim));
}

function aimedFrom(camera: Camera, translation: Vec3, aim: Vec3): Placement {
  const back = unit(sub(translation, aim));
  const right = unit(cross(rotate(camera.rotation, [0, 1, 0]), back), rotate(camera.rotation, [1, 0, 0]));
  const rotation = fromAxes(right, cross(back, right), back);
  return { translation, rotation, distance: length(sub(translation, aim)) };
}

/** A camera at the source that looks where the light shines. */
export const cameraOf = ({ translation, rotation, distance }: Placement): Camera => ({
  name: "",
  translation,
  rotation,
  projection: { perspective: { yfov: 0.5, znear: distance * 1e-3 } },
});

/** Brightness that makes what is `distance` away as bright as a lit scene is. */
export function brightnessFor(decay: Decay, distance: number): number {
  const falls: { [D in Decay]: number } = { none: 1, linear: distance, inverseSquare: distance * distance };
  return Number((IRRADIANCE * falls[decay]).toPrecision(3));
}
