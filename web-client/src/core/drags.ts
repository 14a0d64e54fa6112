// This page's own drag: a gesture (SPEC, section 7) with at most one update a frame, the latest.

import { type ReadonlySignal, signal } from "@preact/signals-core";

import type { Host } from "./connection";
import type { LightId } from "./ids";
import type { LatencyMeter } from "./latency";
import type { Change, ClientMessage, Command, DragOutcome, GestureState, Record } from "./protocol";

/** Own drag as the page shows it before the server has answered. */
export interface OwnDrag {
  light: LightId;
  command: Command;
  /** The latest command that the server took; `null` before its first answer. */
  taken: Command | null;
  /** Changes that the server computed for it. */
  changes: readonly Change[];
  /** Result of the drag of a feature so far; `null` before the first answer, and for other drags. */
  outcome: DragOutcome | null;
  /** Why the server keeps an earlier state (SPEC, GEST-4); `null` where it took the latest. */
  refusal: string | null;
}

/** One drag. After commit, cancel or the end of its lock nothing has an effect any more. */
export interface Drag {
  update(command: Command): void;
  /** Makes a record of it; `done` is told that. */
  commit(done?: (record: Record) => void): void;
  cancel(): void;
}

export interface Dragging {
  own: ReadonlySignal<OwnDrag | null>;
  begin(light: LightId): Drag;
  /** The server on this page's own gesture. */
  answered(state: GestureState): void;
  /** The connection is gone, and with it the gesture (SPEC, GEST-3). */
  lost(): void;
}

export interface DragParts {
  host: Host;
  send(message: ClientMessage): boolean;
  notify(message: string): void;
  latency: LatencyMeter;
  baseSeq(): number;
  /** Name of a light in sentences. */
  lightName(light: LightId): string;
  /**
   * Asks for the record; `edit` says the same on a later connection, where the gesture is gone. `changes` are what the
   * server made of the drag so far, `done` is told the record.
   */
  commit(
    edit: ClientMessage & { type: "edit" },
    commit: ClientMessage,
    changes: readonly Change[],
    done?: (record: Record) => void,
  ): void;
}

/** An update that the server has not answered. */
interface Sent {
  atMs: number;
  command: Command;
}

interface Gesture {
  id: string;
  light: LightId;
  baseSeq: number;
  /** The latest update that was sent, counted from 1; 0 before the gesture is begun. */
  update: number;
  sent: Map<number, Sent>;
  waiting: Command | null;
}

/** After the light's name. */
const ENDINGS = {
  cancelled: "the drag was cancelled.",
  expired: "the drag was held still for too long and has ended. Drag again.",
  rejected: "the server refused the drag.",
} as const;

export function dragging({ host, send, notify, latency, baseSeq, lightName, commit }: DragParts): Dragging {
  const own = signal<OwnDrag | null>(null);
  let gesture: Gesture | null = null;

  function flush(): void {
    if (gesture === null || gesture.waiting === null) return;
    if (gesture.update === 0) {
      send({ type: "gestureBegin", gesture: gesture.id, light: gesture.light, baseSeq: gesture.baseSeq });
    }
    gesture.update += 1;
    gesture.sent.set(gesture.update, { atMs: host.nowMs(), command: gesture.waiting });
    send({ type: "gestureUpdate", gesture: gesture.id, update: gesture.update, command: gesture.waiting });
    gesture.waiting = null;
  }

  function end(): void {
    gesture = null;
    own.value = null;
  }

  function begin(light: LightId): Drag {
    if (gesture !== null) cancel();
    const current: Gesture = {
      id: host.newId(),
      light,
      baseSeq: baseSeq(),
      update: 0,
      sent: new Map(),
      waiting: null,
    };
    gesture = current;
    const isCurrent = () => gesture === current;
    return {
      update(command) {
        if (!isCurrent()) return;
        if (current.waiting === null) host.beforeRepaint(() => isCurrent() && flush());
        current.waiting = command;
        const before = own.value ?? { taken: null, changes: [], outcome: null, refusal: null };
        own.value = { ...before, light, command };
      },
      commit(done) {
        if (!isCurrent()) return;
        flush();
        const latest = own.value;
        end();
        if (latest === null) return;
        const opId = host.newId();
        const edit = { type: "edit", opId, baseSeq: current.baseSeq, command: latest.command } as const;
        commit(edit, { type: "gestureCommit", gesture: current.id, opId }, latest.changes, done);
      },
      cancel: () => isCurrent() && cancel(),
    };
  }

  function cancel(): void {
    if (gesture !== null && gesture.update > 0) send({ type: "gestureCancel", gesture: gesture.id });
    end();
  }

  /** The server has come as far as the state's update; the command of that, where it is news and the server took it. */
  function keptUp(
    sent: Map<number, Sent>,
    { update, code, liveRevision }: GestureState,
  ): Command | undefined {
    const taken = code === undefined ? sent.get(update) : undefined;
    if (taken !== undefined) latency.expect("liveRevision", liveRevision, taken.atMs);
    for (const earlier of sent.keys()) if (earlier <= update) sent.delete(earlier);
    return taken?.command;
  }

  return {
    own,
    begin,
    answered(state) {
      if (gesture === null || gesture.id !== state.gesture) return;
      if (state.ended === undefined) {
        const taken = keptUp(gesture.sent, state);
        if (own.value === null) return;
        const { changes, outcome = null, message = null } = state;
        own.value = { ...own.value, taken: taken ?? own.value.taken, changes, outcome, refusal: message };
        return;
      }
      if (state.ended !== "committed") {
        notify(state.message ?? `${lightName(gesture.light)}: ${ENDINGS[state.ended]}`);
      }
      end();
    },
    lost() {
      if (own.value !== null) {
        notify(`${lightName(own.value.light)}: the connection was lost, and the drag with it.`);
      }
      end();
    },
  };
}
