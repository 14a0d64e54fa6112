import { expect, test } from "vitest";

import { alternativeOf, featureDrag, type Following, freePoints, nextMode } from "../src/core/following";
import type { DragChoice, Light } from "../src/core/protocol";
import { BENDY, CAMERA, SPOT } from "./examples";

const FOLLOWING: Following = { mode: "best", resting: new Set(), radii: "solve", sourceOutside: true };
const SEEN = { camera: CAMERA, size: { width: 64, height: 36 } };

const drag = (light: Light, following: Following, chosen: DragChoice | null = null) =>
  featureDrag(
    "shadow",
    [7, light],
    following,
    SEEN,
    [
      { x: 1, y: 2 },
      { x: 3, y: 4 },
    ],
    chosen,
  );

test("the best answer is asked for, among the points that do not rest", () => {
  const best = drag(BENDY, FOLLOWING);
  expect(best).toMatchObject({
    alternative: "best",
    radii: "keep",
    from: [1, 2],
    to: [3, 4],
    size: [64, 36],
  });
  expect(best, "all points may move").not.toHaveProperty("points");
  const some = drag(BENDY, { ...FOLLOWING, resting: new Set([2]) });
  expect(some).toMatchObject({ alternative: "best", points: [1, 3], radii: "keep" });
  const gone = drag(BENDY, { ...FOLLOWING, resting: new Set([9]) });
  expect(gone, "a point that is not there does not rest").not.toHaveProperty("points");
  expect(drag(SPOT, { ...FOLLOWING, resting: new Set([2]) })).not.toHaveProperty("points");
});

test("a light follows as a whole, or by the control points that do not rest", () => {
  const whole = drag(BENDY, { ...FOLLOWING, mode: "whole", resting: new Set([2]) });
  expect(whole).toMatchObject({ radii: "keep", sourceOutside: true });
  expect(whole).not.toHaveProperty("points");
  expect(whole).not.toHaveProperty("alternative");
  const bent = drag(BENDY, { ...FOLLOWING, mode: "points", resting: new Set([2]) });
  expect(bent).toMatchObject({ points: [1, 3], radii: "solve" });
  expect(bent).not.toHaveProperty("alternative");
  expect(drag(BENDY, { ...FOLLOWING, mode: "points" })).toMatchObject({ points: [1, 2, 3] });
  expect(drag(BENDY, { ...FOLLOWING, sourceOutside: false })).toMatchObject({ sourceOutside: false });
});

test("an alternative that is chosen takes the mode's place", () => {
  const chosen = drag(BENDY, { ...FOLLOWING, mode: "points", resting: new Set([2]) }, "narrower");
  expect(chosen).toMatchObject({ alternative: "narrower", points: [1, 3], radii: "keep" });
  const whole = drag(BENDY, { ...FOLLOWING, mode: "whole", resting: new Set([2]) }, "pastCaster");
  expect(whole).toMatchObject({ alternative: "pastCaster" });
  expect(whole, "in this mode nobody sees which points rest").not.toHaveProperty("points");
});

test("modes follow one another, and name their alternative", () => {
  expect(nextMode("best")).toBe("whole");
  expect(nextMode("points")).toBe("best");
  expect(alternativeOf("whole")).toBe("wholeLight");
  expect(alternativeOf("best"), "the server says which").toBeNull();
  expect(freePoints(SPOT, new Set())).toBeUndefined();
});
