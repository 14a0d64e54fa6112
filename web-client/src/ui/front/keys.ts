// Keys of the front page. Tab, Enter and fields are the browser's.

import type { SessionEntry } from "../../core/protocol";
import type { Front } from "./front";

/** Listens until what it gives is called. */
export function bindFrontKeys(front: Front): () => void {
  const listen = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLElement && event.target.matches("input, select, textarea, dialog *"))
      return;
    const task = taskFor(front, event.key);
    if (task === null) return;
    event.preventDefault();
    task();
  };
  addEventListener("keydown", listen);
  return () => removeEventListener("keydown", listen);
}

function taskFor(front: Front, key: string): (() => void) | null {
  if (key === "?") return () => (front.showKeys.value = true);
  if (key === "n" || key === "N") return () => (front.making.value = true);
  const links = [...document.querySelectorAll<HTMLElement>(".card-link")];
  const at = links.findIndex((link) => link.closest(".card")?.contains(document.activeElement) === true);
  const to = links[at < 0 && key.startsWith("Arrow") ? 0 : neighbour(links, at, key)];
  if (to !== undefined) return () => to.focus();
  const name = links[at]?.closest<HTMLElement>(".card")?.dataset.session;
  const session = [...front.current.value, ...front.archived.value].find((entry) => entry.name === name);
  return session === undefined ? null : taskForCard(front, session, key, links[at + 1] ?? links[at - 1]);
}

/** Task of a key for the session of the focused card; `next` gets the focus if that card disappears. */
function taskForCard(
  front: Front,
  session: SessionEntry,
  key: string,
  next: HTMLElement | undefined,
): (() => void) | null {
  switch (key) {
    case "F2":
      return () => (front.renaming.value = session.name);
    case "d":
    case "D":
      return () => void front.duplicate(session);
    case "Delete":
      if (session.archived) return () => (front.deleting.value = session);
      return () => {
        next?.focus();
        void front.archive(session, true);
      };
    default:
      return null;
  }
}

/** The index of the card that a key leads to from the one at `at`; -1 where it leads to none. */
function neighbour(links: readonly HTMLElement[], at: number, key: string): number {
  switch (key) {
    case "ArrowRight":
      return at + 1;
    case "ArrowLeft":
      return at - 1;
    case "ArrowDown":
    case "ArrowUp":
      return inRow(links, at, key === "ArrowDown");
    case "Home":
      return 0;
    case "End":
      return links.length - 1;
    default:
      return -1;
  }
}

/** The card nearest below or above; -1 where there is no row. */
function inRow(links: readonly HTMLElement[], at: number, isDown: boolean): number {
  const boxes = links.map((link) => link.getBoundingClientRect());
  const from = boxes[at];
  if (from === undefined) return -1;
  const rows = boxes
    .map(({ top }) => top)
    .filter((top) => (isDown ? top > from.top + 1 : top < from.top - 1));
  const row = isDown ? Math.min(...rows) : Math.max(...rows);
  const distance = (k: number) => Math.abs((boxes[k]?.left ?? 0) - from.left);
  const there = boxes.flatMap(({ top }, k) => (Math.abs(top - row) < 1 ? [k] : []));
  return there.reduce((best, k) => (best < 0 || distance(k) < distance(best) ? k : best), -1);
}
