// Drags that lay a control point or the source on the surface under the pointer.

import type { Pixel } from "./camera";
import { type Drawn, type Movable, positionOf, pulled } from "./handles";
import { diagonal } from "./navigation";
import type { OnProbed } from "./probing";
import type { Bounds, Command, ProbedSurface } from "./protocol";
import { add, scale, sub } from "./vector";

/** A source lies this much of the scene's diagonal above its surface: in it, it would light one side or the other. */
const SOURCE_LIFT = 1e-4;

/** Command that lays `handle` on `surface`. */
export function laidOn(handle: Movable, drawn: Drawn, surface: ProbedSurface, bounds: Bounds): Command {
  const lift = handle.kind === "source" ? SOURCE_LIFT * diagonal(bounds) : 0;
  const to = add(surface.position, scale(surface.normal, lift));
  return pulled(handle, drawn, sub(to, positionOf(handle, drawn)));
}

export interface Snapping {
  /** To the surface at `pixel`, once it is known; where nothing is, what was last laid stays. */
  to(pixel: Pixel): void;
  /** From now on no answer counts. */
  stop(): void;
  /** Runs `task` once the answer to the latest question is there. */
  afterLast(task: () => void): void;
}

/** `ask` asks what is seen at a pixel, the latest question of all; `lay` is told the surfaces. */
export function snapping(
  ask: (pixel: Pixel, onProbed: OnProbed) => void,
  lay: (surface: ProbedSurface) => void,
): Snapping {
  let asked = 0;
  let stoppedAt = 0;
  let isWaiting = false;
  let last: (() => void) | null = null;
  return {
    to(pixel) {
      asked += 1;
      isWaiting = true;
      const number = asked;
      ask(pixel, (found) => {
        if (number <= stoppedAt) return;
        if (found?.seen) lay(found.seen);
        if (number !== asked) return;
        isWaiting = false;
        last?.();
      });
    },
    stop() {
      stoppedAt = asked;
      isWaiting = false;
    },
    afterLast(task) {
      if (isWaiting) last = task;
      else task();
    },
  };
}
