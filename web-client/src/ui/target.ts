// What a control changes, apart from how it looks.

import { useRef } from "preact/hooks";

import type { Drag } from "../core/drags";
import type { LightId } from "../core/ids";
import type { Command } from "../core/protocol";
import type { Session } from "../core/session";

/** A value of the document: set at once, or dragged to where it is let go of. */
export interface Target<V> {
  set(value: V): void;
  drag(): ValueDrag<V>;
}

export interface ValueDrag<V> {
  update(value: V): void;
  commit(): void;
  cancel(): void;
}

/** What `command` makes of a light. */
export function lightTarget<V>(session: Session, light: LightId, command: (value: V) => Command): Target<V> {
  return {
    set: (value) => session.edit(command(value)),
    drag() {
      const drag: Drag = session.drag(light);
      return { ...drag, update: (value) => drag.update(command(value)) };
    },
  };
}

/** The target for another kind of value, such as a component; `back` makes the target's value of it. */
export function through<V, W>(target: Target<V>, back: (value: W) => V): Target<W> {
  return {
    set: (value) => target.set(back(value)),
    drag() {
      const drag = target.drag();
      return { ...drag, update: (value) => drag.update(back(value)) };
    },
  };
}

/** A drag for controls whose events only say "changed" and "let go of": it begins with the first change. */
export function useLooseDrag<V>(target: Target<V>): ValueDrag<V> {
  const current = useRef<ValueDrag<V> | null>(null);
  const end = (finish: (drag: ValueDrag<V>) => void) => {
    const drag = current.current;
    current.current = null;
    if (drag !== null) finish(drag);
  };
  return {
    update(value) {
      current.current ??= target.drag();
      current.current.update(value);
    },
    commit: () => end((drag) => drag.commit()),
    cancel: () => end((drag) => drag.cancel()),
  };
}
