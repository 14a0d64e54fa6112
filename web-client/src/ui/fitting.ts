// Views that show all of something. People read "frame" for it; in code a frame is a picture from the server.

import { shotAspect } from "../core/camera";
import { lightOf } from "../core/document";
import { diagonal, fitBall } from "../core/navigation";
import { tubeOf } from "../core/outline";
import type { Camera } from "../core/protocol";
import { length, mix, sub, type Vec3 } from "../core/vector";
import type { Page } from "./page";

/** Length of a spotlight's cone without range, as a share of the scene's diagonal. */
const CONE_REACH = 0.35;

/** Room around what is fitted in, so that its handles are in sight too. */
const MARGIN = 1.15;

export const coneReach = (page: Page): number => CONE_REACH * diagonal(page.session.bounds.value);

/** Within the film gate, where that is shown. */
export function fitScene(page: Page): void {
  const { min, max } = page.session.bounds.value;
  fitPoints(page, [min, max], page.showGate.value ? shotAspect : () => stageAspect(page));
}

/** The selected light with its control points, which need not be in the shot; the scene where none is selected. */
export function fitLight(page: Page): void {
  const light = lightOf(page.session.document.value, page.selectedLight.value);
  if (light === undefined) fitScene(page);
  else fitPoints(page, tubeOf(light, coneReach(page)).points, () => stageAspect(page));
}

function stageAspect({ session }: Page): number {
  const { width, height } = session.viewer.size.value ?? { width: 1, height: 1 };
  return width / height;
}

/** Fits the points in a picture of the shape that `aspectOf` gives for the camera. */
function fitPoints({ session }: Page, points: readonly Vec3[], aspectOf: (camera: Camera) => number): void {
  const corner = (pick: (...values: number[]) => number): Vec3 => {
    const along = (axis: 0 | 1 | 2) => pick(...points.map((point) => point[axis]));
    return [along(0), along(1), along(2)];
  };
  const [min, max] = [corner(Math.min), corner(Math.max)];
  const radius = Math.max((MARGIN * length(sub(max, min))) / 2, 1e-3);
  session.viewer.move((from) => fitBall(from, mix(min, max, 0.5), radius, aspectOf(from.camera)));
}
