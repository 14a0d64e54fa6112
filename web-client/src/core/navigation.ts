// Orbit, pan and zoom: a viewer's own camera turned about a pivot that it looks at.

import { forwardOf, inPlaneOf, type Pixel, type Size, tallerBy, withShape, worldPerPixel } from "./camera";
import type { Bounds, Camera, Projection } from "./protocol";
import { aboutAxis, add, compose, dot, length, mix, rotate, scale, sub, unitQuat, type Vec3 } from "./vector";

/** A camera with a shape of its own, and how far in front of it the pivot lies, world units. */
export interface Orbit {
  camera: Camera;
  distance: number;
}

/** Minimum angle between the camera's direction and the vertical, radians. */
const POLE_MARGIN = 0.02;
/** The pivot's distance stays between these shares of the scene's diagonal. */
const NEAREST = 1e-3;
const FARTHEST = 100;

export const pivotOf = ({ camera, distance }: Orbit): Vec3 =>
  add(camera.translation, scale(forwardOf(camera), distance));

/** Starts from what `camera` frames: the pivot is where it looks nearest to the middle of the scene. */
export function orbitFrom(camera: Camera, bounds: Bounds): Orbit {
  const along = dot(sub(mix(bounds.min, bounds.max, 0.5), camera.translation), forwardOf(camera));
  return { camera: withShape(camera), distance: Math.max(along, 0.05 * diagonal(bounds)) };
}

/** Turns by `yaw` about the world's y and by `pitch` about the camera's x, radians, about a point, by default the pivot. What is
 * there stays where it is in the picture, and the pivot is as far away from then on. */
export function orbit(from: Orbit, yaw: number, pitch: number, about?: Vec3): Orbit {
  const elevation = Math.asin(Math.min(1, Math.max(-1, forwardOf(from.camera)[1])));
  const limit = Math.PI / 2 - POLE_MARGIN;
  const tilt = Math.min(Math.max(pitch, -limit - elevation), limit - elevation);
  const right = rotate(from.camera.rotation, [1, 0, 0]);
  const turn = compose(aboutAxis([0, 1, 0], yaw), aboutAxis(right, tilt));
  const rotation = unitQuat(compose(turn, from.camera.rotation));
  const camera = { ...from.camera, rotation };
  if (about === undefined) {
    const back = scale(forwardOf(camera), -from.distance);
    return { ...from, camera: { ...camera, translation: add(pivotOf(from), back) } };
  }
  const fromThere = sub(from.camera.translation, about);
  const depth = -dot(fromThere, forwardOf(from.camera));
  const distance = depth > 0 ? depth : from.distance;
  return { camera: { ...camera, translation: add(about, rotate(turn, fromThere)) }, distance };
}

/** Moves camera and pivot so that the pivot follows the pointer by `pixels` in a picture of `size`. */
export function pan(from: Orbit, size: Size, pixels: Pixel): Orbit {
  const perPixel = worldPerPixel({ camera: from.camera, ...size }, pivotOf(from));
  const shift = rotate(from.camera.rotation, [-pixels.x * perPixel, pixels.y * perPixel, 0]);
  return { ...from, camera: { ...from.camera, translation: add(from.camera.translation, shift) } };
}

/** Brings the pivot nearer (`factor` below 1) or farther. `still` is a point at the pivot's distance that stays where it is in the
 * picture, by default the pivot. */
export function zoom(from: Orbit, factor: number, bounds: Bounds, still: Vec3 = pivotOf(from)): Orbit {
  const size = diagonal(bounds);
  const clamp = (wanted: number) => Math.min(Math.max(wanted, NEAREST * size), FARTHEST * size);
  const { projection } = from.camera;
  if ("orthographic" in projection) {
    const { orthographic } = projection;
    const ymag = clamp(orthographic.ymag * factor);
    const zoomed: Projection = { orthographic: { ...orthographic, ymag } };
    const translation = add(
      from.camera.translation,
      scale(sub(still, pivotOf(from)), 1 - ymag / orthographic.ymag),
    );
    return { ...from, camera: { ...from.camera, translation, projection: zoomed } };
  }
  const distance = clamp(from.distance * factor);
  const translation = add(still, scale(sub(from.camera.translation, still), distance / from.distance));
  return { camera: { ...from.camera, translation }, distance };
}

/** The same, and what is under `pixel` of a picture of `size` stays there. */
export function zoomTo(from: Orbit, factor: number, bounds: Bounds, size: Size, pixel: Pixel): Orbit {
  return zoom(from, factor, bounds, inPlaneOf({ camera: from.camera, ...size }, pixel, pivotOf(from)));
}

/** Two fingers. */
export type Fingers = readonly [Pixel, Pixel];
/** Fingers nearer to each other than this, in pixels, count as this far apart: there their distance says nothing. */
const LEAST_SPAN_PX = 20;

/** Two fingers went from `before` to `after` in a picture of `size`: the view goes with their middle, and nearer to what is there
 * as they part. */
export function pinch(from: Orbit, size: Size, before: Fingers, after: Fingers, bounds: Bounds): Orbit {
  const span = ([a, b]: Fingers) => Math.max(Math.hypot(a.x - b.x, a.y - b.y), LEAST_SPAN_PX);
  const middle = ([a, b]: Fingers): Pixel => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });
  const [was, is] = [middle(before), middle(after)];
  const panned = pan(from, size, { x: is.x - was.x, y: is.y - was.y });
  return zoomTo(panned, span(before) / span(after), bounds, size, is);
}

/** Length of the box's diagonal. */
export const diagonal = (bounds: Bounds): number => Math.max(length(sub(bounds.max, bounds.min)), 1e-6);

/** Sees all of the ball from where `from` looks, in a picture `aspect` wide by 1 high. */
export function fitBall(from: Orbit, centre: Vec3, radius: number, aspect: number): Orbit {
  const { projection } = from.camera;
  const narrower = Math.min(1, aspect) * tallerBy(from.camera, aspect);
  const facing = (distance: number, camera: Camera): Orbit => ({
    camera: { ...camera, translation: sub(centre, scale(forwardOf(camera), distance)) },
    distance,
  });
  if ("orthographic" in projection) {
    const { orthographic } = projection;
    const fitted: Projection = { orthographic: { ...orthographic, ymag: radius / narrower } };
    return facing(from.distance, { ...from.camera, projection: fitted });
  }
  const halfAngle = Math.atan(Math.tan(projection.perspective.yfov / 2) * narrower);
  return facing(radius / Math.sin(halfAngle), from.camera);
}
