// The film gate: what `render` will write of the view.

import { gateOf, type Pixel, type View } from "../core/camera";

interface FilmGateProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
}

/** A fine line around what `render` will write; the rest of the stage is dark. */
export function FilmGate({ view, at }: FilmGateProps) {
  const { x, y, width, height } = gateOf(view);
  const box = { left: at.x + x, top: at.y + y, width, height };
  return <div class="gate" aria-hidden="true" style={inPixels(box)} />;
}

const inPixels = (box: { [side: string]: number }) =>
  Object.fromEntries(Object.entries(box).map(([side, length]) => [side, `${length}px`]));
