// Steps by keys: presses that follow each other within a second are one drag, and so one record.

import type { Host } from "../core/connection";
import type { Session } from "../core/session";
import type { ValueDrag } from "./binding";

/** Whose presses rest for so long has done: longer than a finger takes to press again. */
const REST_MS = 1000;
/** Number of steps of one press with Shift. */
const LARGE_STEPS = 10;

export interface Presses {
  /**
   * A press at `control` takes it a `step` further, at first from `start` in the drag that `begin` gives. The presses of
   * another control are committed before. While the pointer drags something, keys do nothing.
   */
  press<V>(control: unknown, start: V, step: (from: V) => V, begin: () => ValueDrag<V>): void;
  /** Makes one record of the presses that are under way, if any. */
  commit(): void;
  /** Takes them back. */
  cancel(): void;
}

interface Pending<V> {
  control: unknown;
  value: V;
  drag: ValueDrag<V>;
  stopClock(): void;
}

export function startPresses({ after }: Host, { ownDrag }: Session): Presses {
  let pending: Pending<unknown> | null = null;

  function end(finish: (drag: ValueDrag<unknown>) => void): void {
    if (pending === null) return;
    const { drag, stopClock } = pending;
    pending = null;
    stopClock();
    finish(drag);
  }
  const commit = () => end((drag) => drag.commit());

  return {
    press<V>(control: unknown, start: V, step: (from: V) => V, begin: () => ValueDrag<V>) {
      if (pending?.control !== control) commit();
      if (pending === null && ownDrag.value !== null) return;
      const before = pending as Pending<V> | null;
      const value = step(before === null ? start : before.value);
      // At the end of what a number may be.
      if (before === null && value === start) return;
      before?.stopClock();
      const drag = before?.drag ?? begin();
      pending = { control, value, drag, stopClock: after(REST_MS, commit) } as Pending<unknown>;
      drag.update(value);
    },
    commit,
    cancel: () => end((drag) => drag.cancel()),
  };
}

/** `session`, where whatever is asked for next first makes a record of the presses under way. */
export function committing(session: Session, presses: Presses): Session {
  const first =
    <A extends unknown[], R>(task: (...given: A) => R) =>
    (...given: A): R => {
      presses.commit();
      return task(...given);
    };
  const { edit, undo, redo, drag, rename } = session;
  return {
    ...session,
    edit: first(edit),
    undo: first(undo),
    redo: first(redo),
    drag: first(drag),
    rename: first(rename),
  };
}

/** Steps that one press of an arrow key asks for. */
export const stepsOf = (event: KeyboardEvent): number => (event.shiftKey ? LARGE_STEPS : 1);
