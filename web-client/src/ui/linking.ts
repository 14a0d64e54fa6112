// Objects that are linked to a light by clicks in the picture.

import { lightName, lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import { type LinkList, type LinksValue, pathsOf, withPaths } from "../core/links";
import { setParameter, valueIn } from "../core/parameters";
import { namesOf } from "../core/node_tree";
import type { PixelQuestion } from "../core/probing";
import type { Parameter } from "../core/protocol";
import { isFree } from "./light_actions";
import type { Page } from "./page";
import type { Linking } from "./page_state";

/** True if a click in the picture links an object to a light. */
export const isLinking = ({ linking, selectedLight }: Page): boolean =>
  linking.value !== null && linking.value.light === selectedLight.value;

/** Clicks in the picture go to this list from now on, or no longer do. Keys go to the picture too. */
export function toggleLinking(page: Page, light: LightId, row: Parameter, list: LinkList): void {
  const { linking, aiming } = page;
  const is = linking.value;
  if (is !== null && is.light === light && is.row.name === row.name && is.list === list) {
    linking.value = null;
    return;
  }
  aiming.value = "off";
  linking.value = { light, row, list, said: null };
  document.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
}

/** Puts the object that is seen there into the list. */
export function linkAt(page: Page, question: PixelQuestion | null): void {
  const { session, linking } = page;
  const { value } = linking;
  if (value === null) return;
  const say = (said: string) => (linking.value = { ...value, said });
  if (question === null) {
    say("Nothing is seen there: pick an object");
    return;
  }
  session.probe("link", question, (found) => {
    // It has been ended, or goes to another list by now.
    if (found === null || linking.value !== value) return;
    if (found.seen === null) say("Nothing is seen there: pick an object");
    else say(linked(page, value, found.seen.node));
  });
}

/** Adds a path to the list; a sentence on what came of it. */
function linked(page: Page, { light: id, row, list }: Linking, path: string): string {
  const { session } = page;
  const light = lightOf(session.document.value, id);
  const object = `“${namesOf(path).at(-1)}”`;
  const name = lightName(session.document.value, id);
  if (light === undefined || !isFree(page, id)) return `${name} cannot be changed now: try again`;
  const links = valueIn(row, light.type, light) as LinksValue;
  const paths = pathsOf(links, list);
  if (paths.includes(path)) return `${object} is there already`;
  session.edit(setParameter(id, row, withPaths(links, list, [...paths, path])));
  return `Added: ${effectOf(row, list, object, name)}`;
}

/** Sentence for the effect of an object in the list. */
function effectOf({ name }: Parameter, list: LinkList, object: string, light: string): string {
  if (name === "shadowLink") {
    return list === "include"
      ? `of what throws shadows in ${light}, ${object}`
      : `${object} throws no shadow in ${light}`;
  }
  return list === "include" ? `${light} lights ${object}` : `${light} does not light ${object}`;
}

/** Sentence for the effect of the next click. */
export function linkingText({ session }: Page, { light, row, list, said }: Linking): string {
  if (said !== null) return said;
  const next = effectOf(row, list, "what you pick", lightName(session.document.value, light));
  return `Pick objects: ${next}; Enter takes the middle`;
}
