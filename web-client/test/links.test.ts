import { expect, test } from "vitest";

import { type LinksValue, pathsOf, textOfLinks, withPaths } from "../src/core/links";

test("paths come and go, and nothing left is null", () => {
  const one = withPaths(null, "exclude", ["room/vase"]);
  expect(one).toEqual({ exclude: ["room/vase"] });
  const both = withPaths(one, "include", ["room", "room"]);
  expect(both).toEqual({ include: ["room"], exclude: ["room/vase"] });
  expect(pathsOf(both, "include")).toEqual(["room"]);
  expect(withPaths(both, "exclude", [])).toEqual({ include: ["room"] });
  expect(withPaths(one, "exclude", [])).toBeNull();
  expect(pathsOf(null, "include")).toEqual([]);
});

test("links are said in words", () => {
  const said: [LinksValue, string][] = [
    [null, "all"],
    [{ include: ["a", "b"] }, "a, b"],
    [{ exclude: ["c"] }, "all without c"],
    [{ include: ["a"], exclude: ["a/c"] }, "a without a/c"],
  ];
  for (const [value, text] of said) expect(textOfLinks(value)).toBe(text);
});
