// Keys of the whole page. Fields keep theirs.

import { frameLight, frameScene } from "./framing";
import { canEdit, type Page } from "./page";

/** Listens for as long as the page lives. */
export function bindKeys(page: Page): void {
  addEventListener("keydown", (event) => {
    if (
      event.target instanceof HTMLElement &&
      event.target.matches("input:not([type=range]), select, textarea")
    )
      return;
    const task = taskFor(page, event);
    if (task === null) return;
    event.preventDefault();
    task();
  });
}

function taskFor(page: Page, event: KeyboardEvent): (() => void) | null {
  const { session, scope, showHandles, showGate } = page;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (!canEdit(page)) return null;
    if (key === "y" || (key === "z" && event.shiftKey)) return () => session.redo(scope.value);
    return key === "z" ? () => session.undo(scope.value) : null;
  }
  if (event.altKey) return null;
  switch (key) {
    case "a":
      return () => frameScene(page);
    case "f":
      return () => frameLight(page);
    case "g":
      return () => (showGate.value = !showGate.value);
    case "h":
      return () => (showHandles.value = !showHandles.value);
    default:
      return null;
  }
}
