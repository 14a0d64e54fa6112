import { expect, test } from "vitest";

import { clipMiddle, halvesOf } from "../src/core/clipping";

test("a long name keeps its end, and loses nothing while it has room", () => {
  expect(halvesOf("key")).toEqual({ start: "key", end: "" });
  const long = "set/dressing/kitchen/table_0042_take_7";
  const { start, end } = halvesOf(long);
  expect([start + end, end]).toEqual([long, "take_7"]);
});

test("what people take for one character is not cut", () => {
  const family = "👨‍👩‍👧";
  expect(halvesOf(`${family}${"x".repeat(12)}${family.repeat(6)}`).end).toBe(family.repeat(6));
  expect(clipMiddle(family.repeat(9), 5)).toBe(`${family.repeat(2)}…${family.repeat(2)}`);
});

test("a name is cut to a length", () => {
  expect(clipMiddle("a name", 6)).toBe("a name");
  expect(clipMiddle("a longer name 12", 9)).toBe("a lo…e 12");
  expect([...clipMiddle("x".repeat(256), 40)]).toHaveLength(40);
});
