// The splines of a BendyLight (ARCHITECTURE.md, "The light model", section 1).
//
// n segments have n + 2 control points; t runs from 0 to n. On segment i the points i, i + 1 and i + 2 count.

import { add, scale, sub, type Vec3 } from "./vector";

/** Segments of a light with `points` control points. */
export const segmentCount = (points: number): number => points - 2;

/** The fewest control points that make a curve. */
const FEWEST_POINTS = 3;

/** True if a curve of `points` control points can lose `point`; the first is the source. */
export const isRemovable = (points: number, point: number): boolean => point > 0 && points > FEWEST_POINTS;

/** A segment, and how far along it from 0 to 1. */
interface Segment {
  segment: number;
  u: number;
  /** True for the first segment, and for the last: there the spline ends in its control point. */
  first: boolean;
  last: boolean;
}

function segmentAt(points: number, t: number): Segment {
  const n = segmentCount(points);
  const segment = Math.min(n - 1, Math.max(0, Math.floor(t)));
  return { segment, u: t - segment, first: segment === 0, last: segment === n - 1 };
}

/** The first control point that counts at `t`, and the weights of it and the next two; they add up to 1. */
export function weightsAt(points: number, t: number): { from: number; weights: Vec3 } {
  const { segment, u, first, last } = segmentAt(points, t);
  const [b0, b1, b2] = [(1 - u) * (1 - u), 2 * u * (1 - u), u * u];
  const [start, end] = [first ? 1 : 0.5, last ? 1 : 0.5];
  return { from: segment, weights: [b0 * start, b0 * (1 - start) + b1 + b2 * (1 - end), b2 * end] };
}

/** The weight of control point `point` at `t`. */
export function weightOf(points: number, point: number, t: number): number {
  const { from, weights } = weightsAt(points, t);
  return weights[point - from] ?? 0;
}

/** P(t), in the space of `points`. */
export function positionAt(points: readonly Vec3[], t: number): Vec3 {
  const { from, weights } = weightsAt(points.length, t);
  const [a, b, c] = threeFrom(points, from);
  return add(add(scale(a, weights[0]), scale(b, weights[1])), scale(c, weights[2]));
}

/** R(t), or any other spline of numbers. */
export function numberAt(values: readonly number[], t: number): number {
  const { from, weights } = weightsAt(values.length, t);
  const [a, b, c] = threeFrom(values, from);
  return a * weights[0] + b * weights[1] + c * weights[2];
}

/** P'(t); not of length 1. */
export function tangentAt(points: readonly Vec3[], t: number): Vec3 {
  const { segment, u, first, last } = segmentAt(points.length, t);
  const [a, b, c] = threeFrom(points, segment);
  const d0 = scale(sub(b, a), first ? 1 : 0.5);
  const d1 = scale(sub(c, b), last ? 1 : 0.5);
  return scale(add(d0, scale(sub(d1, d0), u)), 2);
}

/** Parameter at which control point `point` pulls most: its Greville abscissa, 0, 1/2, 3/2, ..., n - 1/2, n. */
export function abscissa(points: number, point: number): number {
  return Math.min(segmentCount(points), Math.max(0, point - 0.5));
}

/** `steps` values of t a segment, both ends included. */
export function samplesOf(points: number, steps: number): number[] {
  const n = segmentCount(points);
  return Array.from({ length: n * steps + 1 }, (_, k) => k / steps);
}

function threeFrom<T>(values: readonly T[], from: number): [T, T, T] {
  const [a, b, c] = values.slice(from, from + 3);
  if (a === undefined || b === undefined || c === undefined) {
    throw new Error("A curve needs three control points.");
  }
  return [a, b, c];
}
