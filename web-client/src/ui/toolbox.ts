// State of the page's tools.

import { type Signal, signal } from "@preact/signals";

import type { Pixel } from "../core/camera";
import type { Following, Seen } from "../core/following";
import type { LightId } from "../core/ids";
import type { DragAlternative, DragKind, Light } from "../core/protocol";
import type { PinSight } from "../core/pin_state";
import type { PinChoice } from "../core/pins";
import type { Tool } from "../core/tools";
import type { Vec3 } from "../core/vector";

/** A feature that is being dragged, in pixels of the picture that the server sends. */
export interface Dragged {
  kind: DragKind;
  id: LightId;
  /** Light at the start of the drag. */
  light: Light;
  from: Pixel;
  to: Pixel;
  seen: Seen;
  /** Alternative that was chosen during the drag; `null` for that of the mode. */
  chosen: DragAlternative | null;
  /** True if a finger drags it, which hides what is below. */
  byFinger: boolean;
}

/** The hand at a handle or an arrow: the light that it drags, and its place in the picture. */
export interface Hand {
  id: LightId;
  /** Light at the start of the drag. */
  before: Light;
  at: Pixel;
  /** True if a finger drags it, which hides what is below. */
  byFinger: boolean;
}

/** Facts about pins that the document does not have, by their ids. */
export interface PinFacts {
  /** First sights of the pinned points. */
  sights: ReadonlyMap<number, PinSight>;
  broken: ReadonlySet<number>;
}

/** A pin that was chosen in the list, for as long as its mark flashes. */
export interface Flash {
  pin: number;
}

export interface Toolbox {
  tool: Signal<Tool>;
  following: Signal<Following>;
  nextPin: Signal<PinChoice>;
  selectedPin: Signal<number | null>;
  /** Points of the pinned objects that the page knows. */
  pinPlaces: Signal<ReadonlyMap<number, Vec3>>;
  pinFacts: Signal<PinFacts>;
  flash: Signal<Flash | null>;
  dragged: Signal<Dragged | null>;
  /** Alternative that the latest drag ended in; `null` where it is not known. */
  answered: Signal<DragAlternative | null>;
  /** The hand at a handle or an arrow; `null` where it drags none. */
  hand: Signal<Hand | null>;
  /** Reason why the last press had no effect; `null` if it had one. */
  said: Signal<string | null>;
}

export function startTools(): Toolbox {
  return {
    tool: signal<Tool>("select"),
    following: signal<Following>({ mode: "best", resting: new Set(), radii: "follow", sourceOutside: true }),
    nextPin: signal<PinChoice>({ kind: "look", hard: true, ofObject: true }),
    selectedPin: signal<number | null>(null),
    pinPlaces: signal<ReadonlyMap<number, Vec3>>(new Map()),
    pinFacts: signal<PinFacts>({ sights: new Map(), broken: new Set() }),
    flash: signal<Flash | null>(null),
    dragged: signal<Dragged | null>(null),
    answered: signal<DragAlternative | null>(null),
    hand: signal<Hand | null>(null),
    said: signal<string | null>(null),
  };
}
