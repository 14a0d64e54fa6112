import { expect, test } from "vitest";

import { NO_STATS, withStats } from "../src/core/frame_stats";
import type { FrameStats, PassRun } from "../src/core/protocol";
import { passText } from "../src/ui/stats_texts";
import { DOCUMENT, STATS } from "./examples";

const said = (run: Partial<PassRun>) =>
  passText(DOCUMENT, { pass: "display", light: null, cause: "notKept", runs: 1, ...run });

test("a pass says of which light it is, why it ran and how often", () => {
  expect(said({ pass: "shadowMap", light: 1, cause: "light" })).toBe(
    "Shadow map of key: the light changed, 1",
  );
  expect(said({ pass: "layer", light: 99, cause: "first" })).toBe("Layer of light 99: there was none yet, 1");
  expect(said({ pass: "sum", cause: "light", runs: 2 })).toBe("Sum of layers: a light changed, 2");
  expect(said({})).toBe("Display: drawn every time, 1");
});

test("what moved last stays beside the lossless picture of it", () => {
  const stats = (frame: number, quality: FrameStats["quality"]): FrameStats => ({ ...STATS, frame, quality });
  const [first, atRest, next] = [stats(1, "moving"), stats(2, "settled"), stats(3, "moving")];
  const known = withStats(withStats(NO_STATS, first), atRest);
  expect(known).toEqual({ moving: first, settled: atRest });
  expect(withStats(known, next)).toEqual({ moving: next, settled: null });
});
