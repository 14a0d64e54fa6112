// Actions on a light as a whole, by buttons and by keys.

import { copyName, lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import type { Light } from "../core/protocol";
import { canEdit, holderOf, type Page } from "./page";

/** True if the light is switched off, for everybody. */
export const isMuted = (light: Light): boolean => light.enabled === false;

/** True if nobody else drags the light, and edits can be made. */
export const isFree = (page: Page, id: LightId): boolean => canEdit(page) && holderOf(page, id) === null;

/** Switches the light off, or on again, for everybody. */
export function toggleMute({ session }: Page, id: LightId): void {
  const light = lightOf(session.document.value, id);
  if (light === undefined) return;
  session.edit({ type: "setLight", light: id, parameter: { enabled: isMuted(light) } });
}

/** Adds the light to those that shine alone in one's own view, or takes it out. */
export function toggleSolo({ session: { viewer } }: Page, id: LightId): void {
  const { solo } = viewer.settings.value;
  viewer.set({ solo: solo.includes(id) ? solo.filter((other) => other !== id) : [...solo, id] });
}

/** Adds a light and selects it once it is there. */
export function addAndSelect(page: Page, light: Light): void {
  page.session.edit({ type: "addLight", light }, ({ changes }) => {
    const added = changes.find((change) => change.type === "light");
    if (added === undefined) return;
    page.selectedLight.value = added.light;
    page.selectedPoint.value = null;
  });
}

/** Adds a light that is as this one but for its name, in the same place. */
export function duplicateLight(page: Page, id: LightId): void {
  const { lights } = page.session.document.value;
  const light = lightOf(page.session.document.value, id);
  if (light === undefined) return;
  const name = copyName(
    light,
    lights.map((entry) => entry.light.name),
  );
  addAndSelect(page, { ...light, name });
}

/** Makes it a BendyLight. One that has no cone is given one towards what is in the middle of one's own view; where nothing is
 * seen there, the server takes the scene's middle. */
export async function bendLight({ session, pick }: Page, id: LightId): Promise<void> {
  const light = lightOf(session.document.value, id);
  if (light === undefined) return;
  const orbit = session.viewer.own.value;
  const toward = hasCone(light) || orbit === null ? null : await pick(orbit.camera);
  session.edit({ type: "bendLight", light: id, ...(toward !== null && { toward }) });
}

/** True if the light has a cone. */
export const hasCone = (light: Light): boolean => light.type === "spot" || light.type === "bendy";

/** Makes it a spotlight, which has no control points to have selected. */
export function straightenLight({ session, selectedPoint }: Page, id: LightId): void {
  selectedPoint.value = null;
  session.edit({ type: "straightenLight", light: id });
}
