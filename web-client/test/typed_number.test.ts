import { expect, test } from "vitest";

import { readNumber } from "../src/core/typed_number";

const value = (text: string, now = 40, unit = "") => {
  const read = readNumber(text, now, unit);
  return "value" in read ? read.value : read.problem;
};

test("numbers, sums, factors and shares are read", () => {
  const cases: [string, number][] = [
    ["1+1", 2],
    [" 2 * (3 - 1) / 4 ", 1],
    ["*2", 80],
    ["/4", 10],
    ["*2+1", 81],
    ["50%", 20],
    ["-3", -3],
    ["1,5", 1.5],
    [".5", 0.5],
    ["1e3", 1000],
    ["2--1", 3],
  ];
  for (const [text, expected] of cases) expect(value(text), text).toBeCloseTo(expected, 12);
});

test("a unit is the field's own or is counted in it", () => {
  const cases: [string, string, number][] = [
    ["6500K", "K", 6500],
    ["180°", "degrees", 180],
    ["1 rad", "degrees", 180 / Math.PI],
    ["60cd", "", 60],
    ["30cm + 1m", "world units", 1.3],
    ["50%", "%", 50],
    ["1 stop", "stops", 1],
  ];
  for (const [text, unit, expected] of cases) expect(value(text, 40, unit), text).toBeCloseTo(expected, 12);
});

test("what says nothing is refused with what would", () => {
  for (const text of ["", "abc", "1+", "(1", "1)", "1 2", "1/0", "**2", "2*", "."]) {
    expect(value(text), text).toMatch(/is not understood: type a number/);
  }
  expect(value("6500K", 40, "degrees")).toMatch(/does not count in “K”: it takes °/);
  expect(value("3 apples", 40, "light-local units")).toMatch(/leave the unit out/);
});
