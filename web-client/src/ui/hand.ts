// The hand at a handle or an arrow: the light that it drags, and its place in the picture.

import type { Pixel } from "../core/camera";
import type { Drag } from "../core/drags";
import type { Drawn } from "../core/handles";
import type { Page } from "./page";

/** `drag` with the hand at it for as long as it goes on; `at` is its place now. */
export function withHand(
  page: Page,
  { id, light }: Drawn,
  drag: Drag,
  at: () => Pixel | null,
  byFinger = false,
): Drag {
  const { hand } = page.toolbox;
  const leave = () => (hand.value = null);
  return {
    update(command) {
      const now = at();
      hand.value = now === null ? null : { id, before: light, at: now, byFinger };
      drag.update(command);
    },
    commit(done) {
      leave();
      drag.commit(done);
    },
    cancel() {
      leave();
      drag.cancel();
    },
  };
}
