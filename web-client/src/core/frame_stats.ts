// What the latest pictures came to, as the server tells who asks (SPEC, FRAME-13).

import type { FrameStats } from "./protocol";

/** Of what moved last, and of the lossless picture of it: an edit's own cost would go with the frame after it. */
export interface LatestStats {
  moving: FrameStats | null;
  /** `null` while the view is not at rest. */
  settled: FrameStats | null;
}

export const NO_STATS: LatestStats = { moving: null, settled: null };

/** What is known once `stats` have come. */
export const withStats = (before: LatestStats, stats: FrameStats): LatestStats =>
  stats.quality === "moving" ? { moving: stats, settled: null } : { ...before, settled: stats };
