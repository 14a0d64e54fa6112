// Two fingers on the stage.

import type { Pixel } from "../core/camera";
import type { Fingers } from "../core/navigation";

/** Listeners for an element that tell each way of two fingers on it. The second finger takes both from whatever lies
 * under them: a drag with the first is cancelled (see followPointer). */
export function twoFingers(moved: (before: Fingers, after: Fingers) => void) {
  const down = new Map<number, Pixel>();
  const lift = ({ pointerId }: PointerEvent) => void down.delete(pointerId);
  const fingers = (): Fingers | null => {
    const [first, second, ...more] = down.values();
    return first === undefined || second === undefined || more.length > 0 ? null : [first, second];
  };
  return {
    onPointerDownCapture(event: PointerEvent) {
      if (event.pointerType !== "touch") return;
      // The first of new fingers: none is left of earlier ones, wherever they were lifted.
      if (event.isPrimary) down.clear();
      down.set(event.pointerId, pixelOf(event));
      if (down.size < 2) return;
      event.stopPropagation();
      (event.currentTarget as Element).setPointerCapture(event.pointerId);
    },
    onPointerMoveCapture(event: PointerEvent) {
      if (!down.has(event.pointerId)) return;
      const before = fingers();
      down.set(event.pointerId, pixelOf(event));
      const after = fingers();
      if (before !== null && after !== null) moved(before, after);
    },
    onPointerUpCapture: lift,
    onPointerCancelCapture: lift,
  };
}

/** From the element's upper left corner. */
function pixelOf({ clientX, clientY, currentTarget }: PointerEvent): Pixel {
  const { x, y } = (currentTarget as Element).getBoundingClientRect();
  return { x: clientX - x, y: clientY - y };
}
