// Drags with the pointer.

import type { Pixel } from "../core/camera";

export interface PointerDrag {
  /** The pointer is at `at`, `by` from where it last was; CSS pixels of the page. */
  move(at: Pixel, by: Pixel, event: PointerEvent): void;
  end?(): void;
  /** Escape, a second finger, or the pointer was taken away. */
  cancel?(): void;
}

/** Follows the pointer of `down` until it is let go of; it stays with the element even outside of it. */
export function followPointer(down: PointerEvent, drag: PointerDrag): void {
  const element = down.currentTarget as Element;
  const listening = new AbortController();
  const { signal } = listening;
  let last: Pixel = { x: down.clientX, y: down.clientY };
  element.setPointerCapture(down.pointerId);
  const stop = (last?: () => void) => {
    listening.abort();
    last?.();
  };
  const on = (type: string, task: (event: PointerEvent) => void) =>
    element.addEventListener(
      type,
      (event) => (event as PointerEvent).pointerId === down.pointerId && task(event as PointerEvent),
      { signal },
    );
  on("pointermove", (event) => {
    const { clientX: x, clientY: y } = event;
    drag.move({ x, y }, { x: x - last.x, y: y - last.y }, event);
    last = { x, y };
  });
  on("pointerup", () => stop(drag.end));
  on("pointercancel", () => stop(drag.cancel));
  const second = (other: PointerEvent) => other.pointerType === "touch" && other.pointerId !== down.pointerId;
  window.addEventListener("pointerdown", (other) => second(other) && stop(drag.cancel), {
    signal,
    capture: true,
  });
  window.addEventListener("keydown", (key) => key.key === "Escape" && stop(drag.cancel), { signal });
}
