// Handles by keys. Arrows move what has the focus, page keys move it away from the eye and back.

import { type Pixel, project } from "../core/camera";
import { isRemovable } from "../core/curve";
import { lightOf } from "../core/document";
import { type Drawn, type Handle, positionOf } from "../core/handles";
import { NO_STEPS, nudge, type Steps } from "../core/nudge";
import { tubeOf } from "../core/outline";
import { coneReach } from "./fitting";
import { withHand } from "./hand";
import { type Page, reachFor } from "./page";
import { removeLight } from "./removing";
import { stepsOf } from "./presses";

const WAYS: { [key: string]: Steps } = {
  ArrowRight: { ...NO_STEPS, right: 1 },
  ArrowLeft: { ...NO_STEPS, right: -1 },
  ArrowUp: { ...NO_STEPS, up: 1 },
  ArrowDown: { ...NO_STEPS, up: -1 },
  PageUp: { ...NO_STEPS, away: 1 },
  PageDown: { ...NO_STEPS, away: -1 },
};

/** The same key on two kinds of keyboards. */
const REMOVERS = ["Delete", "Backspace"];

/** Carries out a key at `handle`; other keys are the page's. */
export function pressHandle(event: KeyboardEvent, page: Page, handle: Handle, drawn: Drawn): void {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Enter") page.presses.commit();
  // The pointer's drag ends with Escape too.
  if (event.key === "Escape") page.presses.cancel();
  const way = WAYS[event.key];
  if (way === undefined && !REMOVERS.includes(event.key)) return;
  event.preventDefault();
  event.stopPropagation();
  if (!reachFor(page, drawn.id)) return;
  if (way === undefined) remove(event, page, handle, drawn);
  else press(event, page, handle, drawn, way);
}

function press(event: KeyboardEvent, page: Page, handle: Handle, drawn: Drawn, way: Steps): void {
  const count = stepsOf(event);
  const further = ({ right, up, away }: Steps): Steps => ({
    right: right + count * way.right,
    up: up + count * way.up,
    away: away + count * way.away,
  });
  page.presses.press(event.currentTarget, NO_STEPS, further, () => {
    const drag = withHand(page, drawn, page.session.drag(drawn.id), () => placeNow(page, handle, drawn));
    const command = nudge(handle, drawn);
    return { ...drag, update: (steps) => drag.update(command(steps)) };
  });
}

/** Pixel at which the handle is by now. */
function placeNow(page: Page, handle: Handle, drawn: Drawn): Pixel | null {
  const light = lightOf(page.session.document.value, drawn.id) ?? drawn.light;
  const now: Drawn = { ...drawn, light, tube: tubeOf(light, coneReach(page)) };
  return project(drawn.view, positionOf(handle, now));
}

/** Removes the control point, or at its source the light; both can be undone. */
function remove(event: KeyboardEvent, page: Page, handle: Handle, { id, light }: Drawn): void {
  const stage = (event.currentTarget as Element).closest<HTMLElement>(".stage");
  // The focus returns to the stage, because the focused element disappears.
  const leave = () => stage?.focus();
  if (handle.kind === "source") removeLight(page, id, leave);
  if (handle.kind !== "point" || light.type !== "bendy") return;
  if (!isRemovable(light.points.length, handle.point)) return;
  leave();
  page.session.edit({ type: "removePoint", light: id, point: handle.point });
}
