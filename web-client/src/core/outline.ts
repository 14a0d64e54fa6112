// A light's shape in the world, as the page draws it over the picture.

import { towardsEye } from "./camera";
import { numberAt, positionAt, samplesOf, tangentAt } from "./curve";
import type { Camera, Light } from "./protocol";
import { add, cross, inverse, length, perpendicular, rotate, scale, sub, unit, type Vec3 } from "./vector";

/** Control points and radii in the world. */
export interface Tube {
  points: Vec3[];
  radii: number[];
}

/** Samples of the curve a segment, and points of a ring: smooth to the eye at any size of the page. */
const STEPS = 20;
const RING_POINTS = 96;

/** Position, rotation and scale of a light. */
export type Transform = Light["transform"];

export const toWorld = (transform: Transform, local: Vec3): Vec3 =>
  add(transform.translation, rotate(transform.rotation, scale(local, transform.scale)));

export const toLocal = (transform: Transform, world: Vec3): Vec3 =>
  scale(rotate(inverse(transform.rotation), sub(world, transform.translation)), 1 / transform.scale);

/** Half the width of what is drawn of a directional light that shines everywhere, and the radius of an omni light without
 * a range, as shares of the reach. */
const ENDLESS_SHARE = 0.05;

/** The light's tube; a spotlight's is its cone, drawn `reach` long where it has no range, and a directional light's as
 * wide as it shines. An omni light's has no length and the radius of its range. */
export function tubeOf(light: Light, reach: number): Tube {
  const { transform } = light;
  if (light.type === "bendy") {
    return {
      points: light.points.map((point) => toWorld(transform, point)),
      radii: light.radii.map((radius) => radius * transform.scale),
    };
  }
  const axis = rotate(transform.rotation, [0, 0, -1]);
  const [end, radiusAt] = straightTube(light, reach);
  const distances = [0, end / 2, end];
  return {
    points: distances.map((along) => add(transform.translation, scale(axis, along))),
    radii: distances.map(radiusAt),
  };
}

/** Length and width of a straight light's tube. */
function straightTube(
  light: Exclude<Light, { type: "bendy" }>,
  reach: number,
): [number, (along: number) => number] {
  switch (light.type) {
    case "spot": {
      const spread = Math.tan((light.coneAngle * Math.PI) / 180);
      return [light.range ?? reach, (along) => along * spread];
    }
    case "directional":
      return [reach, () => (light.width ?? light.height ?? 2 * ENDLESS_SHARE * reach) / 2];
    case "omni":
      return [0, () => light.range ?? ENDLESS_SHARE * reach];
  }
}

/** Three circles of a sphere around an omni light, along its axes. */
export function sphereOf({ points, radii }: Tube, rotation: Transform["rotation"]): Vec3[][] {
  const centre: Vec3 = points[0] ?? [0, 0, 0];
  const axes: Vec3[] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  return axes.map((axis) => circle(centre, rotate(rotation, axis), radii[0] ?? 0));
}

/** The head of an arrow at the tube's end, across what the eye sees. */
export function arrowHead(tube: Tube, camera: Camera): Vec3[] {
  const end = tube.points.length - 2;
  const [tip, size] = [positionAt(tube.points, end), numberAt(tube.radii, end) / 2];
  const back = scale(unit(tangentAt(tube.points, end)), -size);
  const aside = scale(sideways(tube, end, camera), size / 2);
  return [add(tip, add(back, aside)), tip, add(tip, sub(back, aside))];
}

export const centreLine = (tube: Tube): Vec3[] =>
  samplesOf(tube.points.length, STEPS).map((t) => positionAt(tube.points, t));

/** Unit vector across the tube at `t` to the edge that the eye sees, to the right of where light goes. */
export function sideways(tube: Tube, t: number, camera: Camera): Vec3 {
  const tangent = unit(tangentAt(tube.points, t));
  const across = cross(tangent, towardsEye(camera, positionAt(tube.points, t)));
  return length(across) > 1e-6 ? unit(across) : perpendicular(tangent);
}

/** Visible edges of the tube, `R` sideways of the curve on either side. */
export function silhouette(tube: Tube, camera: Camera): { right: Vec3[]; left: Vec3[] } {
  const edge = (sign: number) =>
    samplesOf(tube.points.length, STEPS).map((t) => {
      const offset = scale(sideways(tube, t, camera), sign * numberAt(tube.radii, t));
      return add(positionAt(tube.points, t), offset);
    });
  return { right: edge(1), left: edge(-1) };
}

/** The tube's cross-section at `t`, closed. */
export function ringAt(tube: Tube, t: number): Vec3[] {
  return circle(positionAt(tube.points, t), unit(tangentAt(tube.points, t)), numberAt(tube.radii, t));
}

/** A closed circle square to the unit vector `axis`. */
export function circle(centre: Vec3, axis: Vec3, radius: number): Vec3[] {
  const x = perpendicular(axis);
  const y = cross(axis, x);
  return Array.from({ length: RING_POINTS + 1 }, (_, k) => {
    const angle = (k / RING_POINTS) * 2 * Math.PI;
    return add(centre, add(scale(x, radius * Math.cos(angle)), scale(y, radius * Math.sin(angle))));
  });
}
