// State of a session's page that a reload of its tab keeps: camera, selection, tool, and visible panels.
// State of the browser: its user has seen the hints.

import type { Orbit } from "../core/navigation";
import { FOLLOW_MODES, type FollowMode } from "../core/following";
import type { ViewSettings } from "../core/protocol";
import { TOOLS, type Tool } from "../core/tools";
import { type Page, selectLight } from "./page";

interface Kept {
  view: Orbit;
  settings: ViewSettings;
  light: number | null;
  point: number | null;
  tool: Tool;
  mode: FollowMode;
  showHandles: boolean;
  showGate: boolean;
  snaps: boolean;
}

const HINTS_KEY = "bendylights.hints";

/** True if this browser has shown the demo's hints to their end. */
export const areHintsSeen = (): boolean => localStorage.getItem(HINTS_KEY) === "seen";

export const keepHintsSeen = (): void => localStorage.setItem(HINTS_KEY, "seen");

const keyOf = (session: string) => `bendylights.page.${session}`;

/** Takes up what this tab had of the session when it was last left. */
export function restorePage(page: Page): void {
  const kept = read(page.name);
  if (kept === null) return;
  page.session.viewer.restore(kept.view, kept.settings);
  selectLight(page, kept.light);
  page.selectedPoint.value = kept.point;
  page.toolbox.tool.value = kept.tool;
  page.toolbox.following.value = { ...page.toolbox.following.value, mode: kept.mode };
  for (const shown of ["showHandles", "showGate", "snaps"] as const) page[shown].value = kept[shown];
}

/** Keeps it for the next time. */
export function keepPage({ session, selectedLight, selectedPoint, toolbox, ...page }: Page): void {
  const view = session.viewer.own.value;
  if (view === null) return;
  const kept: Kept = {
    view,
    settings: session.viewer.settings.value,
    light: selectedLight.value,
    point: selectedPoint.value,
    tool: toolbox.tool.value,
    mode: toolbox.following.value.mode,
    showHandles: page.showHandles.value,
    showGate: page.showGate.value,
    snaps: page.snaps.value,
  };
  sessionStorage.setItem(keyOf(page.name), JSON.stringify(kept));
}

/** `null` where nothing was kept, or by another version of the page. */
function read(session: string): Kept | null {
  try {
    const kept = JSON.parse(sessionStorage.getItem(keyOf(session)) ?? "null") as Kept | null;
    return kept !== null &&
      isView(kept.view) &&
      TOOLS.includes(kept.tool) &&
      FOLLOW_MODES.includes(kept.mode) &&
      Array.isArray(kept.settings.solo)
      ? kept
      : null;
  } catch {
    return null;
  }
}

function isView({ camera, distance }: Orbit): boolean {
  const numbers = [...camera.translation, ...camera.rotation, distance];
  return numbers.length === 8 && numbers.every(Number.isFinite) && typeof camera.projection === "object";
}
