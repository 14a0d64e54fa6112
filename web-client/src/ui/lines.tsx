// Lines of the world over the picture.

import { project, type View } from "../core/camera";
import type { Vec3 } from "../core/vector";

/** A line with a dark rim, so that it is seen on any picture. */
export function Line({ view, points, kind }: { view: View; points: readonly Vec3[]; kind: string }) {
  const path = pathOf(view, points);
  return (
    <>
      <path class="rim" d={path} />
      <path class={`line ${kind}`} d={path} />
    </>
  );
}

/** An SVG path through `points` as seen in `view`; it has gaps where they lie behind the camera. */
export function pathOf(view: View, points: readonly Vec3[]): string {
  let drawing = false;
  const steps = points.map((point) => {
    const pixel = project(view, point);
    const step = pixel === null ? "" : `${drawing ? "L" : "M"}${pixel.x.toFixed(1)} ${pixel.y.toFixed(1)}`;
    drawing = pixel !== null;
    return step;
  });
  return steps.join("");
}
