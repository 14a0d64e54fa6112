// Frames to the screen: decoded one at a time, the latest wins, acknowledged once shown (SPEC, FRAME-2).

import { type FrameHeader, HEADER_BYTES, readHeader } from "./frame";

/** How a frame gets from bytes to the screen; `T` is what lies between. */
export interface PictureSink<T> {
  decode(header: FrameHeader, payload: ArrayBuffer): Promise<T>;
  /** Runs `task` when a picture may be drawn. */
  beforeRepaint(task: () => void): void;
  /** Puts a decoded picture on the screen. */
  show(header: FrameHeader, picture: T): void;
  /** The frame was shown, or another one later than it. */
  ack(frame: number): void;
  failed(message: string): void;
}

/** Takes frames as they arrive. */
export interface Pictures {
  receive(message: ArrayBuffer): void;
  /** Forgets what is under way: frame numbers start again with each connection. */
  restart(): void;
}

/** Feeds `sink`. A frame that a later one overtakes is neither decoded nor shown, only acknowledged. */
export function pictures<T>(sink: PictureSink<T>): Pictures {
  let waiting: { header: FrameHeader; payload: ArrayBuffer } | null = null;
  let unacknowledged: number[] = [];
  let busy = false;
  let connection = 0;

  async function drain(): Promise<void> {
    busy = true;
    while (waiting !== null) {
      const { header, payload } = waiting;
      const current = connection;
      waiting = null;
      try {
        const picture = await sink.decode(header, payload);
        await new Promise<void>((resolve) => sink.beforeRepaint(resolve));
        if (current === connection) sink.show(header, picture);
      } catch (error) {
        sink.failed(`A frame could not be decoded: ${String(error)}`);
      }
      if (current === connection) acknowledgeUpTo(header.frame);
    }
    busy = false;
  }

  function acknowledgeUpTo(frame: number): void {
    unacknowledged.filter((f) => f <= frame).forEach(sink.ack);
    unacknowledged = unacknowledged.filter((f) => f > frame);
  }

  return {
    receive(message) {
      try {
        const header = readHeader(message);
        waiting = { header, payload: message.slice(HEADER_BYTES) };
        unacknowledged.push(header.frame);
      } catch (error) {
        sink.failed(error instanceof Error ? error.message : String(error));
        return;
      }
      if (!busy) void drain();
    },
    restart() {
      connection += 1;
      waiting = null;
      unacknowledged = [];
    },
  };
}
