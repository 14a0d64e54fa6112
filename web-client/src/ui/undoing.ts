// Undo and redo as this page asks for them.

import type { Page } from "./page";

/** Takes back the latest step. Where later ones of the same people stay, since others have changed what they did, the first press says
 * so and takes nothing back: who presses again has read it. */
export function undo(page: Page): void {
  const { session, scope, toldOvertaken } = page;
  // A gesture becomes a step, and the first to be undone.
  const step = session.ownDrag.value === null ? session.history.value?.undo[scope.value] : undefined;
  const passed = step?.passed ?? [];
  if (step && passed.length > 0 && toldOvertaken.value !== step.seq) {
    toldOvertaken.value = step.seq;
    for (const why of passed) page.say(`${why}: it stays. Press again to undo ${step.what}`);
    return;
  }
  session.undo(scope.value);
}

/** Takes back the latest undo. */
export const redo = ({ session, scope }: Page): void => session.redo(scope.value);
