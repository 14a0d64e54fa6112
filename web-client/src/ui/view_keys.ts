// One's own view by keys, where the picture has the focus.

import type { Pixel, View } from "../core/camera";
import { orbit, type Orbit, pan, zoom } from "../core/navigation";
import type { Bounds } from "../core/protocol";
import type { Page } from "./page";

const RADIANS_PER_PRESS = Math.PI / 36;
/** Share of the picture's height that a press pans. */
const PAN_PER_PRESS = 0.05;
const ZOOM_PER_PRESS = 1.1;

/** Directions of the camera for arrow keys, y down. */
const WAYS: { [key: string]: Pixel } = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: -1 },
  ArrowDown: { x: 0, y: 1 },
};

/** Powers of {@link ZOOM_PER_PRESS}; with and without Shift, as keyboards have plus and minus. */
const ZOOMS: { [key: string]: number } = { "+": -1, "=": -1, PageUp: -1, "-": 1, _: 1, PageDown: 1 };

/** Arrows take the camera around what it looks at, with Shift along the picture; plus and minus nearer and farther. */
export function pressView(event: KeyboardEvent, { session }: Page, view: View | null): void {
  if (view === null || event.ctrlKey || event.metaKey || event.altKey) return;
  const change = changeFor(event, view, session.bounds.value);
  if (change === null) return;
  event.preventDefault();
  session.viewer.move(change);
}

function changeFor(
  { key, shiftKey }: KeyboardEvent,
  view: View,
  bounds: Bounds,
): ((from: Orbit) => Orbit) | null {
  const [way, power] = [WAYS[key], ZOOMS[key]];
  if (power !== undefined) return (from) => zoom(from, ZOOM_PER_PRESS ** power, bounds);
  if (way === undefined) return null;
  if (!shiftKey) return (from) => orbit(from, way.x * RADIANS_PER_PRESS, way.y * RADIANS_PER_PRESS);
  // The picture's content moves in the opposite direction.
  const pixels = -PAN_PER_PRESS * view.height;
  return (from) => pan(from, view, { x: way.x * pixels, y: way.y * pixels });
}
