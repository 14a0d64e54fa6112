// Pictures of sessions for their cards: those in sight alone, a few at a time, and none twice.

import { type ReadonlySignal, signal, type Signal } from "@preact/signals";

import type { SessionEntry } from "../../core/protocol";
import type { Server } from "./server";

export type Thumbnail = { kind: "none" } | { kind: "shown"; url: string } | { kind: "failed"; why: string };

export interface Thumbnails {
  of(session: string): ReadonlySignal<Thumbnail>;
  /** The card of a session is in sight as it is now. */
  show(session: SessionEntry): void;
  /** It is out of sight: what has not begun is left out. */
  hide(session: string): void;
}

const SIZE = [480, 270] as const;
const MOST_AT_ONCE = 2;
/** One who works on a session changes it all the time; its picture follows at this distance. */
const AGAIN_AFTER_MS = 15_000;

interface Held {
  thumbnail: Signal<Thumbnail>;
  /** Document of the session that it shows. */
  of: string | null;
  askedMs: number;
}

export function startThumbnails(server: Server): Thumbnails {
  const held = new Map<string, Held>();
  const waiting = new Map<string, SessionEntry>();
  let underWay = 0;

  const heldOf = (name: string): Held => {
    const known = held.get(name);
    if (known !== undefined) return known;
    const made: Held = { thumbnail: signal<Thumbnail>({ kind: "none" }), of: null, askedMs: 0 };
    held.set(name, made);
    return made;
  };

  function next(): void {
    for (const [name, session] of waiting) {
      if (underWay >= MOST_AT_ONCE) return;
      waiting.delete(name);
      underWay += 1;
      void draw(session).finally(() => {
        underWay -= 1;
        next();
      });
    }
  }

  async function draw(session: SessionEntry): Promise<void> {
    const own = heldOf(session.name);
    own.of = pictureOf(session);
    own.askedMs = performance.now();
    const before = own.thumbnail.value;
    try {
      const url = URL.createObjectURL(await server.picture(session.name, SIZE));
      own.thumbnail.value = { kind: "shown", url };
    } catch (error) {
      // It may go better the next time that the list comes.
      own.of = null;
      own.thumbnail.value = { kind: "failed", why: error instanceof Error ? error.message : String(error) };
    }
    if (before.kind === "shown") URL.revokeObjectURL(before.url);
  }

  return {
    of: (session) => heldOf(session).thumbnail,
    show(session) {
      const { of, askedMs } = heldOf(session.name);
      const isNew = askedMs === 0 || performance.now() - askedMs > AGAIN_AFTER_MS;
      if (session.seq === 0 || of === pictureOf(session) || !isNew) return;
      waiting.set(session.name, session);
      next();
    },
    hide: (session) => void waiting.delete(session),
  };
}

const pictureOf = ({ epoch, seq }: SessionEntry) => `${epoch} ${seq}`;
