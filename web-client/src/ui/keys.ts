// Keys of the whole page. Fields keep theirs, but for undo where nothing was typed.

import { nextMode } from "../core/following";
import { TOOLS } from "../core/tools";
import { canAim, toggleAiming, toggleLookThrough } from "./directing";
import { fitLight, fitScene } from "./fitting";
import { duplicateLight, isFree, toggleMute, toggleSolo } from "./light_actions";
import { canEdit, type Page } from "./page";
import { takeTool } from "./tools";
import { redo, undo } from "./undoing";

const FIELDS = "input:not([type=range]), select, textarea";
const TYPED = ".text, [data-typed=true]";

/** While it is held, pixels are asked about. */
const PROBE_KEY = "i";
/** While it is held, edits pass over pins. */
const PASSING_KEY = "p";

/** Listens for as long as the page lives. */
export function bindKeys(page: Page): void {
  addEventListener("keydown", (event) => {
    const own = event.ctrlKey || event.metaKey ? TYPED : FIELDS;
    if (event.target instanceof HTMLElement && event.target.matches(own)) return;
    const task = taskFor(page, event);
    if (task === null) return;
    event.preventDefault();
    task();
  });
  const letGo = (key: string) => {
    if (key === PROBE_KEY) page.probe.held.value = false;
    if (key === PASSING_KEY) page.passing.held.value = false;
  };
  addEventListener("keyup", ({ key }) => letGo(key.toLowerCase()));
  // A key that is let go of elsewhere says nothing here.
  addEventListener("blur", () => [PROBE_KEY, PASSING_KEY].forEach(letGo));
}

function taskFor(page: Page, event: KeyboardEvent): (() => void) | null {
  const { showGate, showHandles, showKeys, probe, passing } = page;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (!canEdit(page)) return null;
    if (key === "y" || (key === "z" && event.shiftKey)) return () => redo(page);
    return key === "z" ? () => undo(page) : null;
  }
  if (event.altKey) return null;
  switch (key) {
    case "a":
      return () => fitScene(page);
    case "f":
      return () => fitLight(page);
    case "g":
      return () => (showGate.value = !showGate.value);
    case "h":
      return () => (showHandles.value = !showHandles.value);
    case "escape":
      return leaving(page);
    case "b":
      return () => {
        const { following } = page.toolbox;
        following.value = { ...following.value, mode: nextMode(following.value.mode) };
      };
    case PROBE_KEY:
      return () => (probe.held.value = true);
    case PASSING_KEY:
      return () => (passing.held.value = true);
    case "?":
      return () => (showKeys.value = !showKeys.value);
    default: {
      const tool = TOOLS[Number(key) - 1];
      return tool === undefined ? taskForLight(page, key) : () => takeTool(page, tool);
    }
  }
}

/** Out of what a press on the picture would do. */
function leaving(page: Page): (() => void) | null {
  const { aiming, linking, toolbox, answers } = page;
  if (answers.shown.value?.isOver === true) return answers.close;
  if (aiming.value !== "off") return () => (aiming.value = "off");
  if (linking.value !== null) return () => (linking.value = null);
  if (toolbox.tool.value === "select" || toolbox.dragged.value !== null) return null;
  return () => takeTool(page, "select");
}

/** Task of a key for the selected light. */
function taskForLight(page: Page, key: string): (() => void) | null {
  const { selectedLight, session } = page;
  const light = selectedLight.value;
  if (light === null) return null;
  if (key === "s") return session.viewer.following.value === null ? () => toggleSolo(page, light) : null;
  if (key === "l") return () => toggleLookThrough(page);
  if (key === "t") return canAim(page, light) ? () => toggleAiming(page) : null;
  const edit = { d: duplicateLight, m: toggleMute }[key];
  return edit !== undefined && isFree(page, light) ? () => edit(page, light) : null;
}
