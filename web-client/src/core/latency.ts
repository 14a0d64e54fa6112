// From a change sent to the first picture on the screen that shows it.

/** Counters of frames: their header's `logSeq`, `liveRevision` and `cameraRevision`. */
export type Revision = "logSeq" | "liveRevision" | "cameraRevision";

type FrameRevisions = Readonly<{ [R in Revision]: number }>;

/** Frames that may have come before it was known which revision a change became. */
const REMEMBERED_FRAMES = 32;
/** The median is over so many changes. */
const MEASURED_CHANGES = 15;

export interface LatencyMeter {
  /** A change sent at `sentMs` is in every picture whose `revision` is `value` or more. */
  expect(revision: Revision, value: number, sentMs: number): void;
  /** A picture is on the screen. */
  shown(frame: FrameRevisions, nowMs: number): void;
  /** Median of the latest changes, milliseconds; `null` before the first. */
  medianMs(): number | null;
  /** Forgets what is awaited: revisions mean nothing on another connection. */
  restart(): void;
}

export function latencyMeter(): LatencyMeter {
  let awaited: { revision: Revision; value: number; sentMs: number }[] = [];
  let frames: { frame: FrameRevisions; atMs: number }[] = [];
  let measured: number[] = [];

  const record = (ms: number) => {
    measured = [...measured, ms].slice(-MEASURED_CHANGES);
  };
  return {
    expect(revision, value, sentMs) {
      const seen = frames.find(({ frame, atMs }) => atMs >= sentMs && frame[revision] >= value);
      if (seen !== undefined) record(seen.atMs - sentMs);
      else awaited.push({ revision, value, sentMs });
    },
    shown(frame, nowMs) {
      frames = [...frames, { frame, atMs: nowMs }].slice(-REMEMBERED_FRAMES);
      const isShown = (change: (typeof awaited)[number]) => frame[change.revision] >= change.value;
      for (const change of awaited.filter(isShown)) record(nowMs - change.sentMs);
      awaited = awaited.filter((change) => !isShown(change));
    },
    medianMs() {
      return [...measured].sort((a, b) => a - b)[measured.length >> 1] ?? null;
    },
    restart() {
      [awaited, frames] = [[], []];
    },
  };
}
