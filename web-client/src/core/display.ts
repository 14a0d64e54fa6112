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
export type Screen<T> = Pick<PictureSink<T>, "decode" | "draw">;

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
/** A picture that cannot be decoded may never be; asking for it is not to take all of a server's time. */
const REQUEST_KEY_FRAME_EVERY_MS = 1000;

export function display<T>({ host, screen, send, notify, latency }: DisplayParts<T>): Display {
  const frame = signal<FrameHeader | null>(null);
  const statistics = signal<Statistics>({ latencyMs: null, roundTripMs: null, framesPerSecond: 0 });
  let shownMs: number[] = [];
  let requestedMs = Number.NEGATIVE_INFINITY;
  let cancelRequest = () => {};

  function shown(header: FrameHeader): void {
    const now = host.nowMs();
    latency.shown(header, now);
    shownMs = [...shownMs.filter((at) => now - at < SECOND_MS), now];
    batch(() => {
      frame.value = header;
      const latencyMs = latency.medianMs();
      statistics.value = { ...statistics.value, latencyMs, framesPerSecond: shownMs.length };
    });
  }

  /** At once where that was not done lately. The server passes over what it has sent a whole picture after. */
  function requestKeyFrame(number: number): void {
    const request = () => {
      requestedMs = host.nowMs();
      send({ type: "requestKeyFrame", frame: number });
    };
    cancelRequest();
    const wait = requestedMs + REQUEST_KEY_FRAME_EVERY_MS - host.nowMs();
    if (wait <= 0) request();
    else cancelRequest = host.after(wait, request);
  }

  const feed = pictures<T>({
    decode: screen.decode,
    beforeRepaint: host.beforeRepaint,
    draw: screen.draw,
    shown,
    ack: (number) => void send({ type: "ack", frame: number }),
    torn: requestKeyFrame,
    failed: notify,
  });
  return {
    frame,
    statistics,
    feed: {
      receive: feed.receive,
      restart() {
        cancelRequest();
        feed.restart();
      },
    },
    roundTrip(ms) {
      statistics.value = { ...statistics.value, roundTripMs: ms };
    },
  };
}
