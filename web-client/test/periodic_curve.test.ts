import { expect, test } from "vitest";

import {
  clampDegrees,
  type Knot,
  outlineOf,
  valueAt,
  without,
  withOneMore,
} from "../src/core/periodic_curve";

const KNOTS: readonly Knot[] = [
  [30, 1],
  [90, 0.5],
  [300, 0.25],
];

test("a curve is linear between its knots, and around from the last to the first", () => {
  const at = (degrees: number) => valueAt(KNOTS, degrees);
  expect([30, 60, 90, 195].map(at)).toEqual([1, 0.75, 0.5, 0.375]);
  // Ninety degrees from the last on around to the first.
  expect(at(300)).toBe(0.25);
  expect(at(345)).toBeCloseTo(0.25 + 0.75 / 2);
  expect(at(0)).toBeCloseTo(0.25 + (0.75 * 60) / 90);
  expect(valueAt([[70, 0.4]], 200)).toBe(0.4);
  expect(valueAt([], 0)).toBeUndefined();
});

test("one knot more changes nothing, and comes where there is most room", () => {
  expect(withOneMore(null, 1)).toEqual([[0, 1]]);
  expect(withOneMore([[0, 1]], 1)).toEqual([
    [0, 1],
    [180, 1],
  ]);
  const more = withOneMore(KNOTS, 1);
  expect(more[2]).toEqual([195, 0.375]);
  for (let degrees = 0; degrees < 360; degrees += 5) {
    expect(valueAt(more, degrees)).toBeCloseTo(valueAt(KNOTS, degrees) ?? Number.NaN);
  }
  const last = withOneMore([[350, 0.5]], 1);
  expect(last.map(([degrees]) => degrees)).toEqual([170, 350]);
});

test("knots are taken out, and stay in order", () => {
  expect(without(KNOTS, 1)).toEqual([KNOTS[0], KNOTS[2]]);
  expect(without([[0, 1]], 0)).toBeNull();
  expect(clampDegrees(KNOTS, 1, 10)).toBeCloseTo(30.1);
  expect(clampDegrees(KNOTS, 1, 310)).toBeCloseTo(299.9);
  expect(clampDegrees(KNOTS, 0, -5)).toBe(0);
  expect(clampDegrees(KNOTS, 2, 400)).toBeCloseTo(359.9);
});

test("the picture goes from the left over the top", () => {
  const [left, top, right, bottom] = outlineOf(
    [
      [0, 1],
      [90, 0.5],
      [180, 1],
      [270, 0.25],
    ],
    4,
  );
  const near = (point: readonly number[] | undefined, x: number, y: number) => {
    expect(point?.[0]).toBeCloseTo(x);
    expect(point?.[1]).toBeCloseTo(y);
  };
  near(left, -1, 0);
  near(top, 0, -0.5);
  near(right, 1, 0);
  near(bottom, 0, 0.25);
});
