// Handles that are moved by keys: so many steps to the right, upwards and away from the eye.

import { forwardOf, worldPerPixel } from "./camera";
import { abscissa } from "./curve";
import { type Drawn, type Handle, positionOf, pulled, turnAxis, turned } from "./handles";
import { sideways } from "./outline";
import type { Command } from "./protocol";
import { add, rotate, scale, type Vec3 } from "./vector";

/** Steps since the first key; negative ones go to the left, downwards, towards the eye. */
export interface Steps {
  right: number;
  up: number;
  away: number;
}

export const NO_STEPS: Steps = { right: 0, up: 0, away: 0 };

/** A step at the depth of what is moved, pixels. */
export const STEP_PX = 2;
/** A step of a ring that turns the light: half a degree, as in the fields of the rotation. */
const STEP_RADIANS = Math.PI / 360;

/**
 * Command for steps of `handle` from its present position. A point moves in the picture's plane, or away from the eye; a
 * size grows to the right and upwards, and shrinks to the left and downwards.
 */
export function nudge(handle: Handle, drawn: Drawn): (steps: Steps) => Command {
  const { light, tube, view } = drawn;
  const step = STEP_PX * worldPerPixel(view, positionOf(handle, drawn));
  switch (handle.kind) {
    case "source":
    case "point":
      return ({ right, up, away }) => {
        const inPicture = rotate(view.camera.rotation, [right * step, up * step, 0]);
        return pulled(handle, drawn, add(inPicture, scale(forwardOf(view.camera), away * step)));
      };
    case "radius":
    case "cone": {
      const t = handle.kind === "cone" ? 1 : abscissa(tube.points.length, handle.point);
      const outwards: Vec3 = sideways(tube, t, view.camera);
      return ({ right, up }) => pulled(handle, drawn, scale(outwards, (right + up) * step));
    }
    case "turn": {
      const axis = turnAxis(light, handle.axis);
      return ({ right, up }) => turned(drawn, axis, (right + up) * STEP_RADIANS);
    }
  }
}
