import { expect, test } from "vitest";

import { abscissa, numberAt, positionAt, tangentAt, weightOf, weightsAt } from "../src/core/curve";
import { add, length, scale, sub, type Vec3 } from "../src/core/vector";
import { difference, seeded, someVector } from "./examples";
import { vectors } from "./vectors";

// Three products and sums of numbers below 10 and weights that add up to 1: at most 10 * 8 * 2^-52.
const ROUNDING = 2e-14;

interface CurveVector {
  light: { points: Vec3[]; radii: number[] };
  t: number;
  position: Vec3;
  radius: number;
  tangent: Vec3;
}

const isMet = ({ light, t, position, radius, tangent }: CurveVector): boolean =>
  difference(positionAt(light.points, t), position) < ROUNDING &&
  Math.abs(numberAt(light.radii, t) - radius) < ROUNDING &&
  difference(tangentAt(light.points, t), tangent) < ROUNDING;

test("the curve is the server's, and another one is noticed", () => {
  const cases = vectors<CurveVector[]>("curve.json");
  expect(cases.length).toBeGreaterThan(0);
  for (const each of cases) {
    expect(isMet(each), JSON.stringify(each)).toBe(true);
    expect(isMet({ ...each, radius: each.radius + 1e-9 })).toBe(false);
    expect(isMet({ ...each, t: each.t + (each.t > 0.5 ? -1e-6 : 1e-6) })).toBe(false);
  }
});

/** Curves of 3 to 9 control points. */
function curves(): Vec3[][] {
  const next = seeded(11);
  return Array.from({ length: 60 }, (_, k) =>
    Array.from({ length: 3 + (k % 7) }, () => someVector(next, 10)),
  );
}

test("weights are positive, add up to one, and are those of single points", () => {
  const next = seeded(12);
  for (const points of curves()) {
    const t = next() * (points.length - 2);
    const { from, weights } = weightsAt(points.length, t);
    expect(Math.min(...weights)).toBeGreaterThanOrEqual(0);
    expect(Math.abs(weights[0] + weights[1] + weights[2] - 1)).toBeLessThan(ROUNDING);
    expect(weights.map((_, k) => weightOf(points.length, from + k, t))).toEqual(weights);
    expect(weightOf(points.length, points.length, t)).toBe(0);
  }
});

test("the curve starts and ends in its control points", () => {
  for (const points of curves()) {
    expect(positionAt(points, 0)).toEqual(points[0]);
    expect(positionAt(points, points.length - 2)).toEqual(points.at(-1));
  }
});

test("segments join without a step or a corner", () => {
  const beside = 1e-9;
  for (const points of curves()) {
    for (let joint = 1; joint < points.length - 2; joint += 1) {
      const [before, after] = [joint - beside, joint + beside];
      // |P'| and |P''| are below 80 here: the steps beside the joint change less than 2 * 80 * 1e-9.
      expect(difference(positionAt(points, before), positionAt(points, after))).toBeLessThan(160 * beside);
      expect(difference(tangentAt(points, before), tangentAt(points, after))).toBeLessThan(160 * beside);
    }
  }
});

test("the tangent is the curve's derivative", () => {
  const h = 1e-4;
  const next = seeded(13);
  for (const points of curves()) {
    // In a segment central differences of a quadratic are exact, up to rounding over the step: 1e-14 / 1e-4.
    const segment = Math.floor(next() * (points.length - 2));
    const t = segment + h + next() * (1 - 2 * h);
    const slope = scale(sub(positionAt(points, t + h), positionAt(points, t - h)), 1 / (2 * h));
    expect(length(sub(slope, tangentAt(points, t)))).toBeLessThan(1e-9);
  }
});

test("linear data at the abscissae makes a linear curve", () => {
  const [start, step]: Vec3[] = [
    [1, 2, 3],
    [0.5, -1, 0.25],
  ] as [Vec3, Vec3];
  for (let count = 3; count < 10; count += 1) {
    const points = Array.from({ length: count }, (_, k) =>
      add(start ?? [0, 0, 0], scale(step ?? [0, 0, 0], abscissa(count, k))),
    );
    for (let t = 0; t <= count - 2; t += 0.125) {
      expect(
        difference(positionAt(points, t), add(start ?? [0, 0, 0], scale(step ?? [0, 0, 0], t))),
      ).toBeLessThan(ROUNDING);
    }
  }
});
