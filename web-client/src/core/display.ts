// The picture on the screen and how fast pictures come.

import { batch, type ReadonlySignal, signal } from "@preact/signals-core";

import type { Host } from "./connection";
import type { FrameHeader } from "./frame";
import type { LatencyMeter } from "./latency";
import { type Pictures, pictures, type PictureSink } from "./pictures";
import type { ClientMessage } from "./protocol";

export interface Statistics {
  /** From a change to its picture, median; `null` before the first. */
  latencyMs: number | null;
  roundTripMs: number | null;
  /** Pictures shown in the last second. */
  framesPerSecond: number;
}

/** Decodes pictures and draws them. */
export type Screen<T> = Pick<PictureSink<T>, "decode" | "show">;

export interface Display {
  /** Header of the picture on the screen. */
  frame: ReadonlySignal<FrameHeader | null>;
  statistics: ReadonlySignal<Statistics>;
  feed: Pictures;
  roundTrip(ms: number): void;
}

export interface DisplayParts<T> {
  host: Host;
  screen: Screen<T>;
  send(message: ClientMessage): boolean;
  notify(message: string): void;
  latency: LatencyMeter;
}

const SECOND_MS = 1000;

export function display<T>({ host, screen, send, notify, latency }: DisplayParts<T>): Display {
  const frame = signal<FrameHeader | null>(null);
  const statistics = signal<Statistics>({ latencyMs: null, roundTripMs: null, framesPerSecond: 0 });
  let shownMs: number[] = [];

  function show(header: FrameHeader, picture: T): void {
    screen.show(header, picture);
    const now = host.nowMs();
    latency.shown(header, now);
    shownMs = [...shownMs.filter((at) => now - at < SECOND_MS), now];
    batch(() => {
      frame.value = header;
      const latencyMs = latency.medianMs();
      statistics.value = { ...statistics.value, latencyMs, framesPerSecond: shownMs.length };
    });
  }

  const feed = pictures<T>({
    decode: screen.decode,
    beforeRepaint: host.beforeRepaint,
    show,
    ack: (number) => void send({ type: "ack", frame: number }),
    failed: notify,
  });
  return {
    frame,
    statistics,
    feed,
    roundTrip(ms) {
      statistics.value = { ...statistics.value, roundTripMs: ms };
    },
  };
}
