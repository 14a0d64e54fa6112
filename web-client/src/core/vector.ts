// Vectors, unit quaternions [x, y, z, w] and the few operations that curves, cameras and drags need.

/** Also a colour, linear RGB. */
export type Vec3 = [number, number, number];
/** Unit quaternion [x, y, z, w]. */
export type Quat = [number, number, number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, k: number): Vec3 => [a[0] * k, a[1] * k, a[2] * k];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const mix = (a: Vec3, b: Vec3, k: number): Vec3 => add(a, scale(sub(b, a), k));

export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** `a` at length 1; `otherwise` where it has no direction. */
export function unit(a: Vec3, otherwise: Vec3 = [0, 0, 1]): Vec3 {
  const size = length(a);
  return size > 1e-12 ? scale(a, 1 / size) : otherwise;
}

/** A unit vector square to the unit vector `a`. */
export function perpendicular(a: Vec3): Vec3 {
  const least =
    Math.abs(a[0]) <= Math.abs(a[1]) && Math.abs(a[0]) <= Math.abs(a[2])
      ? 0
      : Math.abs(a[1]) <= Math.abs(a[2])
        ? 1
        : 2;
  const axis: Vec3 = [0, 0, 0];
  axis[least] = 1;
  return unit(cross(a, axis));
}

/** `v` turned by the unit quaternion `q`. */
export function rotate(q: Quat, v: Vec3): Vec3 {
  const axis: Vec3 = [q[0], q[1], q[2]];
  const twice = scale(cross(axis, v), 2);
  return add(add(v, scale(twice, q[3])), cross(axis, twice));
}

/** The rotation `b` followed by the rotation `a`. */
export function compose(a: Quat, b: Quat): Quat {
  const [ax, ay, az, aw] = a;
  const [bx, by, bz, bw] = b;
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** The rotation that takes `q` back. */
export const inverse = (q: Quat): Quat => [-q[0], -q[1], -q[2], q[3]];

/** `q` at length 1, so that products of many rotations stay rotations. */
export function unitQuat(q: Quat): Quat {
  const size = Math.hypot(...q);
  return size > 1e-12 ? [q[0] / size, q[1] / size, q[2] / size, q[3] / size] : [0, 0, 0, 1];
}

/** The rotation by `radians` about the unit vector `axis`. */
export function aboutAxis(axis: Vec3, radians: number): Quat {
  const s = Math.sin(radians / 2);
  return [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(radians / 2)];
}

/** The rotation whose columns are the orthonormal, right-handed axes x, y, z. */
export function fromAxes(x: Vec3, y: Vec3, z: Vec3): Quat {
  const trace = x[0] + y[1] + z[2];
  const raw: Quat =
    trace > 0
      ? [y[2] - z[1], z[0] - x[2], x[1] - y[0], trace + 1]
      : x[0] >= y[1] && x[0] >= z[2]
        ? [1 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2], y[2] - z[1]]
        : y[1] >= z[2]
          ? [y[0] + x[1], 1 + y[1] - x[0] - z[2], z[1] + y[2], z[0] - x[2]]
          : [z[0] + x[2], z[1] + y[2], 1 + z[2] - x[0] - y[1], x[1] - y[0]];
  return unitQuat(raw);
}

const RADIANS = Math.PI / 180;

/** Turns about x, then y, then z, in degrees, that make the rotation `q`; y lies between -90 and 90. */
export function toEulerDegrees(q: Quat): Vec3 {
  const [x, y, z] = [rotate(q, [1, 0, 0]), rotate(q, [0, 1, 0]), rotate(q, [0, 0, 1])];
  const pitch = Math.asin(Math.min(1, Math.max(-1, -x[2])));
  const locked = Math.abs(x[2]) > 1 - 1e-9;
  const roll = locked ? Math.atan2(-z[1], y[1]) : Math.atan2(y[2], z[2]);
  const yaw = locked ? 0 : Math.atan2(x[1], x[0]);
  return [roll / RADIANS, pitch / RADIANS, yaw / RADIANS];
}

/** The rotation of {@link toEulerDegrees}. */
export function fromEulerDegrees(degrees: Vec3): Quat {
  const about = (axis: Vec3, angle: number) => aboutAxis(axis, angle * RADIANS);
  const [x, y, z] = degrees;
  return compose(about([0, 0, 1], z), compose(about([0, 1, 0], y), about([1, 0, 0], x)));
}
