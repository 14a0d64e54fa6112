// A camera's picture: from the world to pixels and back.

import type { Camera } from "./protocol";
import { add, dot, inverse, rotate, scale, sub, unit, type Vec3 } from "./vector";

/** Pixels. */
export interface Size {
  width: number;
  height: number;
}

/** A camera and the size of its picture. Pixels count from the picture's upper left corner, y down. */
export interface View extends Size {
  camera: Camera;
}

export interface Pixel {
  x: number;
  y: number;
}

/** A rectangle by its upper left corner and its size. */
export interface Box extends Pixel, Size {}

/** Width over height of a picture of a camera that does not say what it frames; the server's default too. */
const DEFAULT_ASPECT = 16 / 9;

/** Width over height of what the camera frames, where it says so. */
export const aspectOf = ({ projection }: Camera): number | undefined =>
  "perspective" in projection ? projection.perspective.aspectRatio : projection.orthographic.aspectRatio;

/** Width over height of what `render` writes of the camera. */
export const shotAspect = (camera: Camera): number => aspectOf(camera) ?? DEFAULT_ASPECT;

/** `camera` with a shape of its own: all of its shot is in a picture of any shape (SPEC, DOC-3), also when that
 * changes. */
export function withShape(camera: Camera): Camera {
  return withAspect(camera, shotAspect(camera));
}

/** `camera` with all of a shot of that width over height in its pictures. */
export function withAspect(camera: Camera, aspectRatio: number): Camera {
  const { projection } = camera;
  return "perspective" in projection
    ? { ...camera, projection: { perspective: { ...projection.perspective, aspectRatio } } }
    : { ...camera, projection: { orthographic: { ...projection.orthographic, aspectRatio } } };
}

/** Part of the view's picture that `render` writes: the film gate. It is in the middle, and may reach beyond
 * the sides of the picture of a camera without a shape. */
export function gateOf({ camera, width, height }: View): Box {
  const gateHeight = height / tallerBy(camera, width / height);
  const gateWidth = gateHeight * shotAspect(camera);
  return { x: (width - gateWidth) / 2, y: (height - gateHeight) / 2, width: gateWidth, height: gateHeight };
}

/** True if both show the same in pictures of every size; names do not count. */
export function seeTheSame(a: Camera, b: Camera): boolean {
  const [first, second] = [numbersOf(a), numbersOf(b)];
  return first.length === second.length && first.every((number, k) => number === second[k]);
}

function numbersOf(camera: Camera): (number | undefined)[] {
  const { projection } = camera;
  const lens =
    "perspective" in projection
      ? [projection.perspective.yfov, projection.perspective.znear, projection.perspective.zfar]
      : [0, projection.orthographic.ymag, projection.orthographic.znear, projection.orthographic.zfar];
  return [...camera.translation, ...camera.rotation, shotAspect(camera), ...lens];
}

/** Height of the view divided by the height that the camera frames, in a picture `aspect` wide by 1 high, which has
 * the whole width. */
export const tallerBy = (camera: Camera, aspect: number): number =>
  Math.max(1, (aspectOf(camera) ?? 0) / aspect);

/** Height of the view at distance 1 (perspective), or everywhere (orthographic), halved. */
function halfHeight({ camera, width, height }: View): { perspective: boolean; size: number } {
  const taller = tallerBy(camera, width / height);
  return "perspective" in camera.projection
    ? { perspective: true, size: Math.tan(camera.projection.perspective.yfov / 2) * taller }
    : { perspective: false, size: camera.projection.orthographic.ymag * taller };
}

function nearOf(camera: Camera): number {
  return "perspective" in camera.projection
    ? camera.projection.perspective.znear
    : camera.projection.orthographic.znear;
}

/** The direction in which the camera looks, in the world. */
export const forwardOf = (camera: Camera): Vec3 => rotate(camera.rotation, [0, 0, -1]);

/** Distance of `point` from the camera's own plane, positive in front of it. */
export const depthOf = (camera: Camera, point: Vec3): number =>
  dot(sub(point, camera.translation), forwardOf(camera));

/** Pixel of `point` in the world; `null` before the near plane. */
export function project(view: View, point: Vec3): Pixel | null {
  const { camera, width, height } = view;
  const local = rotate(inverse(camera.rotation), sub(point, camera.translation));
  const depth = -local[2];
  if (depth < nearOf(camera)) return null;
  const { perspective, size } = halfHeight(view);
  const pixels = height / 2 / (size * (perspective ? depth : 1));
  return { x: width / 2 + local[0] * pixels, y: height / 2 - local[1] * pixels };
}

/** True if `pixel` lies in the picture. */
export const isInPicture = ({ width, height }: View, { x, y }: Pixel): boolean =>
  x >= 0 && x <= width && y >= 0 && y <= height;

/** World units a pixel at `point`. */
export function worldPerPixel(view: View, point: Vec3): number {
  const { perspective, size } = halfHeight(view);
  const depth = Math.max(depthOf(view.camera, point), nearOf(view.camera));
  return (2 * size * (perspective ? depth : 1)) / view.height;
}

/** Velocity of `point` on the screen, pixels for each unit along `direction`. */
export function screenVelocity(view: View, point: Vec3, direction: Vec3): Pixel {
  const { camera } = view;
  const turned = inverse(camera.rotation);
  const [at, by] = [rotate(turned, sub(point, camera.translation)), rotate(turned, direction)];
  const perPixel = worldPerPixel(view, point);
  // A point that comes nearer moves away from the middle of the picture.
  const nearing = "perspective" in camera.projection ? by[2] / Math.max(-at[2], nearOf(camera)) : 0;
  return { x: (by[0] + at[0] * nearing) / perPixel, y: -(by[1] + at[1] * nearing) / perPixel };
}

/** The point under `pixel` in the plane through `through` that is parallel to the picture. */
export function inPlaneOf(view: View, pixel: Pixel, through: Vec3): Vec3 {
  const { camera, width, height } = view;
  const depth = depthOf(camera, through);
  const perPixel = worldPerPixel(view, through);
  const local: Vec3 = [(pixel.x - width / 2) * perPixel, (height / 2 - pixel.y) * perPixel, -depth];
  return add(camera.translation, rotate(camera.rotation, local));
}

/** Unit vector from `point` to the eye. */
export function towardsEye(camera: Camera, point: Vec3): Vec3 {
  const back = scale(forwardOf(camera), -1);
  return "perspective" in camera.projection ? unit(sub(camera.translation, point), back) : back;
}
