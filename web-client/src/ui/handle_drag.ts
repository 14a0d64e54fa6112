// Drags of handles and arrows with the pointer.

import type { Pixel } from "../core/camera";
import type { Drawn } from "../core/handles";
import type { Command } from "../core/protocol";
import type { Page } from "./page";
import { followPointer } from "./pointer";
import { inPicture } from "./picture_press";

/** What the pointer's positions mean, from where it has grabbed something. */
export type Grab = (from: Pixel) => (pointer: Pixel) => Command;

/** With Shift what is dragged goes this much of the pointer's way. */
const FINE = 0.1;

/** Drags something of a light until the pointer is let go of. */
export function dragHandle(down: PointerEvent, page: Page, drawn: Drawn, grab: Grab): void {
  const stage = (down.currentTarget as Element).closest(".stage");
  if (stage === null) return;
  const command = grab(inPicture(stage, down));
  const drag = page.session.drag(drawn.id);
  /** How far what is dragged stays behind the pointer, for the ways that it went with Shift. */
  const behind: Pixel = { x: 0, y: 0 };
  followPointer(down, {
    move(_, by, event) {
      if (event.shiftKey) {
        behind.x += (1 - FINE) * by.x;
        behind.y += (1 - FINE) * by.y;
      }
      const { x, y } = inPicture(stage, event);
      drag.update(command({ x: x - behind.x, y: y - behind.y }));
    },
    end: drag.commit,
    cancel: drag.cancel,
  });
}
