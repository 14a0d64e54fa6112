// Drags of handles and arrows with the pointer.

import type { Pixel } from "../core/camera";
import type { Drawn, Movable } from "../core/handles";
import type { Command } from "../core/protocol";
import { laidOn, snapping } from "../core/snapping";
import { withHand } from "./hand";
import type { Page } from "./page";
import { inPicture, questionOn } from "./picture_press";
import { followPointer } from "./pointer";

export interface Grabbed {
  drawn: Drawn;
  /** Begins a drag at `from`. Returns the command for each position of the pointer. */
  grab(from: Pixel): (pointer: Pixel) => Command;
  /** Dragged thing that can be laid on surfaces, if it is one. */
  movable: Movable | null;
}

/** With Shift what is dragged goes this much of the pointer's way. */
const FINE = 0.1;

/** Drags something of a light until the pointer is let go of. */
export function dragHandle(down: PointerEvent, page: Page, { drawn, grab, movable }: Grabbed): void {
  const stage = (down.currentTarget as Element).closest(".stage");
  if (stage === null) return;
  let at = inPicture(stage, down);
  const command = grab(at);
  const { session } = page;
  const byFinger = down.pointerType === "touch";
  const drag = withHand(page, drawn, session.drag(drawn.id), () => at, byFinger);
  /** Distance of the dragged thing behind the pointer, from moves with Shift. */
  const behind: Pixel = { x: 0, y: 0 };
  const snap = snapping(
    (pixel, onProbed) => {
      const question = questionOn(stage, page, pixel);
      if (question === null) onProbed(null);
      else session.probe("snap", question, onProbed);
    },
    (surface) => {
      if (movable !== null) drag.update(laidOn(movable, drawn, surface, session.bounds.value));
    },
  );
  followPointer(down, {
    move(_, by, event) {
      const pixel = inPicture(stage, event);
      at = pixel;
      // The key turns the page's choice around.
      if (movable !== null && page.snaps.value !== (event.ctrlKey || event.metaKey)) {
        snap.to(pixel);
        return;
      }
      snap.stop();
      if (event.shiftKey) {
        behind.x += (1 - FINE) * by.x;
        behind.y += (1 - FINE) * by.y;
      }
      drag.update(command({ x: pixel.x - behind.x, y: pixel.y - behind.y }));
    },
    end: () => snap.afterLast(() => drag.commit()),
    cancel() {
      snap.stop();
      drag.cancel();
    },
  });
}
