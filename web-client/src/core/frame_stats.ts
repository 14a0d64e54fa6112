// Statistics of the latest pictures, as the server sends them on request (SPEC, FRAME-13).

import type { FrameStats } from "./protocol";

/** Statistics of the last moving picture and of its lossless one: without both, an edit's cost would be lost at the next frame. */
export interface LatestStats {
  moving: FrameStats | null;
  /** `null` while the view is not at rest. */
  settled: FrameStats | null;
}

export const NO_STATS: LatestStats = { moving: null, settled: null };

/** Adds new `stats`. */
export const withStats = (before: LatestStats, stats: FrameStats): LatestStats =>
  stats.quality === "moving" ? { moving: stats, settled: null } : { ...before, settled: stats };
