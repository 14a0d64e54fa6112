// Frames to the screen: tile by tile, what a whole picture overtakes is passed over, acknowledged once shown (SPEC, FRAME-2
// and FRAME-12).

import { type FrameHeader, HEADER_BYTES, isWhole, readHeader } from "./frame";

/** Decoded tile of a frame. */
export interface DecodedTile<T> {
  header: FrameHeader;
  picture: T;
}

/** Path of a frame from bytes to the screen; `T` is the form between them. */
export interface PictureSink<T> {
  decode(header: FrameHeader, payload: ArrayBuffer): Promise<T>;
  /** Runs `task` when a picture may be drawn. */
  beforeRepaint(task: () => void): void;
  /** Puts decoded tiles of a frame on the screen, on what is there. */
  draw(tiles: readonly DecodedTile<T>[]): void;
  /** All of a frame is on the screen, by the header of its last tile. */
  shown(header: FrameHeader): void;
  /** The frame was shown, or another one later than it. */
  ack(frame: number): void;
  /** A frame could not be decoded: what is on the screen is not what others go onto. */
  torn(frame: number): void;
  failed(message: string): void;
}

/** Takes messages as they arrive. */
export interface Pictures {
  receive(message: ArrayBuffer): void;
  /** Forgets what is under way: frame numbers start again with each connection. */
  restart(): void;
}

interface Waiting {
  header: FrameHeader;
  payload: ArrayBuffer;
}

/** Feeds `sink`. What a whole picture overtakes is neither decoded nor shown, only acknowledged; parts of pictures go onto what
 * was before them, and so are all shown. */
export function pictures<T>(sink: PictureSink<T>): Pictures {
  let waiting: Waiting[] = [];
  let unacknowledged: number[] = [];
  let busy = false;
  let connection = 0;
  /** The frame that could not be decoded, until a whole one comes. */
  let tornBy: number | null = null;

  /** The tiles that can be shown at once: all of a moving frame, of a lossless one what has come. */
  function take(): Waiting[] {
    const [first] = waiting;
    if (first === undefined) return [];
    const { frame, settle } = first.header;
    const rest = waiting.findIndex(({ header }) => header.frame !== frame);
    const tiles = rest < 0 ? waiting : waiting.slice(0, rest);
    const isComplete = tiles.at(-1)?.header.lastTile === true;
    if (!(isComplete || settle)) return [];
    waiting = waiting.slice(tiles.length);
    return tiles;
  }

  async function drain(): Promise<void> {
    busy = true;
    for (let tiles = take(); tiles.length > 0; tiles = take()) await present(tiles);
    busy = false;
  }

  async function present(tiles: readonly Waiting[]): Promise<void> {
    const current = connection;
    const decode = async ({ header, payload }: Waiting) => ({
      header,
      picture: await sink.decode(header, payload),
    });
    const last = tiles.map(({ header }) => header).find(({ lastTile }) => lastTile);
    try {
      if (isLacking(tiles)) return;
      const decoded = await Promise.all(tiles.map(decode));
      await new Promise<void>((resolve) => sink.beforeRepaint(resolve));
      if (current !== connection) return;
      sink.draw(decoded);
      if (last !== undefined) sink.shown(last);
    } catch (error) {
      sink.failed(`A frame could not be decoded: ${String(error)}`);
      if (current === connection) tear(tiles);
    } finally {
      if (last !== undefined && current === connection) acknowledgeUpTo(last.frame);
    }
  }

  /** Asks for a whole picture, once a frame, before the frame is acknowledged. */
  function tear(tiles: readonly Waiting[]): void {
    const frame = tiles[0]?.header.frame ?? 0;
    if (tornBy !== frame) sink.torn(frame);
    tornBy = frame;
  }

  /** True if the picture under the tiles could not be decoded, or another of these tiles. */
  function isLacking(tiles: readonly Waiting[]): boolean {
    const needsNothing = ({ header }: Waiting) =>
      header.frame !== tornBy && (header.key || header.settle || isWhole(header));
    if (tiles.some(needsNothing)) tornBy = null;
    return tornBy !== null;
  }

  function acknowledgeUpTo(frame: number): void {
    unacknowledged.filter((f) => f <= frame).forEach(sink.ack);
    unacknowledged = unacknowledged.filter((f) => f > frame);
  }

  return {
    receive(message) {
      try {
        const header = readHeader(message);
        if (isWhole(header)) waiting = [];
        waiting.push({ header, payload: message.slice(HEADER_BYTES) });
        if (unacknowledged.at(-1) !== header.frame) unacknowledged.push(header.frame);
      } catch (error) {
        sink.failed(error instanceof Error ? error.message : String(error));
        return;
      }
      if (!busy) void drain();
    },
    restart() {
      connection += 1;
      waiting = [];
      unacknowledged = [];
      tornBy = null;
    },
  };
}
