// Views that show all of something.

import { lightOf } from "../core/document";
import { diagonal, frameBall } from "../core/navigation";
import { tubeOf } from "../core/outline";
import { length, mix, sub, type Vec3 } from "../core/vector";
import type { Page } from "./page";

/** Length of a spotlight's cone without range, as a share of the scene's diagonal. */
const CONE_REACH = 0.35;

/** Room around what is framed, so that its handles are in sight too. */
const MARGIN = 1.15;

export const coneReach = (page: Page): number => CONE_REACH * diagonal(page.session.bounds.value);

export function frameScene(page: Page): void {
  const { min, max } = page.session.bounds.value;
  frame(page, [min, max]);
}

/** The selected light with its control points; the scene where none is selected. */
export function frameLight(page: Page): void {
  const light = lightOf(page.session.document.value, page.selectedLight.value);
  if (light === undefined) frameScene(page);
  else frame(page, tubeOf(light, coneReach(page)).points);
}

function frame({ session }: Page, points: readonly Vec3[]): void {
  const corner = (pick: (...values: number[]) => number): Vec3 => {
    const along = (axis: 0 | 1 | 2) => pick(...points.map((point) => point[axis]));
    return [along(0), along(1), along(2)];
  };
  const [min, max] = [corner(Math.min), corner(Math.max)];
  const { width, height } = session.frame.value ?? { width: 16, height: 9 };
  const radius = Math.max((MARGIN * length(sub(max, min))) / 2, 1e-3);
  session.viewer.move((from) => frameBall(from, mix(min, max, 0.5), radius, width / height));
}
