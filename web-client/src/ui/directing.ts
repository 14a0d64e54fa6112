// Aims the selected light at a point of the picture, and moves the viewer to the light's source.

import { aimedAt, cameraThrough } from "../core/aiming";
import { lightName, lightOf } from "../core/document";
import { viewSizeOf } from "../core/frame";
import type { LightId } from "../core/ids";
import { questionAt, type PixelQuestion } from "../core/probing";
import { isFree } from "./light_actions";
import type { Page } from "./page";

/** True if a click in the picture aims a light. */
export const isAiming = ({ aiming, selectedLight }: Page): boolean =>
  aiming.value !== "off" && selectedLight.value !== null;

/** True if the light has a direction, and is free. */
export const canAim = (page: Page, id: LightId): boolean =>
  isFree(page, id) && lightOf(page.session.document.value, id)?.type !== "omni";

/** The next click in the picture aims the selected light, or no longer does. Keys go to the picture too. */
export function toggleAiming({ aiming, linking }: Page): void {
  linking.value = null;
  aiming.value = aiming.value === "off" ? "on" : "off";
  if (aiming.value === "on") document.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
}

/** Aims the selected light at what is seen there, if anything is. */
export function aimAt(page: Page, question: PixelQuestion | null): void {
  const { session, selectedLight, aiming } = page;
  if (question === null) {
    aiming.value = "missed";
    return;
  }
  session.probe("aim", question, (found) => {
    const id = selectedLight.value;
    const light = lightOf(session.document.value, id);
    if (found === null || id === null || light === undefined || aiming.value === "off") return;
    aiming.value = found.seen === null ? "missed" : "off";
    const command = found.seen === null ? null : aimedAt(id, light, found.seen.position);
    if (command !== null && canAim(page, id)) session.edit(command);
  });
}

/** The middle of the picture, for who has no pointer. */
export function middleOf({ session }: Page): PixelQuestion | null {
  const frame = session.frame.value;
  if (frame === null) return null;
  const size = viewSizeOf(frame);
  return questionAt({ x: size.width / 2, y: size.height / 2 }, size, size);
}

/** Looks from the selected light, or where one does, back to where one was. */
export function toggleLookThrough(page: Page): void {
  const { session, selectedLight, excursion } = page;
  const id = selectedLight.value;
  if (excursion.value !== null && excursion.value.light === id) {
    lookBack(page);
    return;
  }
  const light = lightOf(session.document.value, id);
  const before = excursion.value?.before ?? session.viewer.own.value;
  if (id === null || light === undefined || before === null) return;
  const camera = cameraThrough(light, session.bounds.value);
  excursion.value = { light: id, name: lightName(session.document.value, id), camera, before };
  session.viewer.jump(camera);
}

export function lookBack({ session, excursion }: Page): void {
  const { value } = excursion;
  if (value === null) return;
  excursion.value = null;
  session.viewer.move(() => value.before);
}
