// Bindings of controls to values of the document, apart from their looks.

import { useRef } from "preact/hooks";

import type { Drag } from "../core/drags";
import type { LightId } from "../core/ids";
import type { Command } from "../core/protocol";
import type { Session } from "../core/session";

/** A value of the document: set at once, or dragged to where it is let go of. */
export interface Binding<V> {
  set(value: V): void;
  drag(): ValueDrag<V>;
}

export interface ValueDrag<V> {
  update(value: V): void;
  commit(): void;
  cancel(): void;
}

/** Binds the value of a light that `command` sets. */
export function lightBinding<V>(
  session: Session,
  light: LightId,
  command: (value: V) => Command,
): Binding<V> {
  return {
    set: (value) => session.edit(command(value)),
    drag() {
      const drag: Drag = session.drag(light);
      return { ...drag, update: (value) => drag.update(command(value)) };
    },
  };
}

/** The binding for another kind of value, such as a component; `back` makes the bound value of it. */
export function through<V, W>(binding: Binding<V>, back: (value: W) => V): Binding<W> {
  return {
    set: (value) => binding.set(back(value)),
    drag() {
      const drag = binding.drag();
      return { ...drag, update: (value) => drag.update(back(value)) };
    },
  };
}

/** A drag for controls whose events only say "changed" and "let go of": it begins with the first change. */
export function useLooseDrag<V>(binding: Binding<V>): ValueDrag<V> {
  const current = useRef<ValueDrag<V> | null>(null);
  const end = (finish: (drag: ValueDrag<V>) => void) => {
    const drag = current.current;
    current.current = null;
    if (drag !== null) finish(drag);
  };
  return {
    update(value) {
      current.current ??= binding.drag();
      current.current.update(value);
    },
    commit: () => end((drag) => drag.commit()),
    cancel: () => end((drag) => drag.cancel()),
  };
}
