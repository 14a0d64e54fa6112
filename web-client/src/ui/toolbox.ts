// State of the page's tools.

import { type Signal, signal } from "@preact/signals";

import type { Pixel } from "../core/camera";
import type { LightId } from "../core/ids";
import type { DragKind, Light } from "../core/protocol";
import type { Following, PinChoice, Seen, Tool } from "../core/tools";

/** A feature that is being dragged, in pixels of the picture that the server sends. */
export interface Dragged {
  kind: DragKind;
  id: LightId;
  /** Light at the start of the drag. */
  light: Light;
  from: Pixel;
  to: Pixel;
  seen: Seen;
}

export interface Toolbox {
  tool: Signal<Tool>;
  following: Signal<Following>;
  nextPin: Signal<PinChoice>;
  selectedPin: Signal<number | null>;
  dragged: Signal<Dragged | null>;
  /** Reason why the last press had no effect; `null` if it had one. */
  said: Signal<string | null>;
}

export function startTools(): Toolbox {
  return {
    tool: signal<Tool>("select"),
    following: signal<Following>({ bends: false, resting: new Set(), radii: "follow", sourceOutside: true }),
    nextPin: signal<PinChoice>({ kind: "look", hard: true, ofObject: true }),
    selectedPin: signal<number | null>(null),
    dragged: signal<Dragged | null>(null),
    said: signal<string | null>(null),
  };
}
