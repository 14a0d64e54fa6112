// State of this page alone: the selection, and messages to its user.

import { computed, effect, type Signal, signal } from "@preact/signals";
import { createContext } from "preact";
import { useContext } from "preact/hooks";

import type { Pixel } from "../core/camera";
import { type AlternativesReply, type AlternativesRequest, requestOf } from "../core/alternatives";
import type { Host } from "../core/connection";
import type { ClientId, LightId } from "../core/ids";
import { otherAnswers, type OtherAnswers } from "../core/other_answers";
import { withPassing } from "../core/passing_pins";
import type { Camera, SceneNodes, Scope } from "../core/protocol";
import type { Listed, Session } from "../core/session";
import type { Vec3 } from "../core/vector";
import type { Aiming, Excursion, Linking, Removal } from "./page_state";
import { committing, type Presses, startPresses } from "./presses";
import type { Screen } from "./screen";
import { startTools, type Toolbox } from "./toolbox";

export interface Toast {
  key: number;
  message: string;
}

export interface Page {
  session: Session;
  /** Steps by keys that are not yet a record; what is asked of `session` makes them one first. */
  presses: Presses;
  screen: Screen;
  name: string;
  /** Entry of the session in the list. */
  listed: Signal<Listed>;
  /** The point of the scene in the middle of a camera's picture, if there is one. */
  pick(camera: Camera): Promise<Vec3 | null>;
  selectedLight: Signal<LightId | null>;
  /** Control point of the selected light; `null` for the light as a whole. */
  selectedPoint: Signal<number | null>;
  /** True if radii that would fold the tube shrink when control points are dragged. */
  radiiFollow: Signal<boolean>;
  /** True if dragged things are laid on the surface under the pointer. */
  snaps: Signal<boolean>;
  toolbox: Toolbox;
  /** Other answers to the drag of a feature. */
  answers: OtherAnswers;
  /** Passing over pins: active while its key is held, and until its button is pressed again. */
  passing: { held: Signal<boolean>; on: Signal<boolean> };
  aiming: Signal<Aiming>;
  /** Link that clicks in the picture edit, while they do. */
  linking: Signal<Linking | null>;
  /** The view through a light, while one has not gone back from it. */
  excursion: Signal<Excursion | null>;
  scope: Signal<Scope>;
  showHandles: Signal<boolean>;
  /** True if the parts of the picture that `render` would not write are darkened. */
  showGate: Signal<boolean>;
  /** True if the list of keys is visible. */
  showKeys: Signal<boolean>;
  /** Probing of pixels: active while its key is held, and until its button is pressed again. */
  probe: {
    held: Signal<boolean>;
    on: Signal<boolean>;
    /** The pointer in the picture as it is shown; `null` where it is elsewhere. */
    at: Signal<Pixel | null>;
    /** True if the pointer is a finger. */
    byFinger: Signal<boolean>;
  };
  /** A light that goes with its pins once it is agreed to. */
  removal: Signal<Removal | null>;
  /** The light that was reached for while somebody else drags it, as long as that goes on. */
  reachedFor: Signal<LightId | null>;
  toasts: Signal<readonly Toast[]>;
  /** Tells the person at the page. */
  say(message: string): void;
  /** The record that undo would take back when it was told that later steps stay. */
  toldOvertaken: Signal<number | null>;
  /** The nodes of the scene; `null` while they are not known. */
  nodes: Signal<SceneNodes | null>;
  /** Next hint on the demo scene; `null` after the last one. */
  hint: Signal<number | null>;
}

const TOAST_MS = 6000;
/** More than these would hide the picture. */
const MOST_TOASTS = 4;

const LIGHT_IS_GONE = "The light is no longer there";

export interface Toasts {
  list: Signal<readonly Toast[]>;
  add(message: string): void;
}

export function startToasts(): Toasts {
  const list = signal<readonly Toast[]>([]);
  let key = 0;
  return {
    list,
    add(message) {
      key += 1;
      const toast = { key, message };
      list.value = [...list.value.filter((t) => t.message !== message), toast].slice(-MOST_TOASTS);
      setTimeout(() => (list.value = list.value.filter((t) => t !== toast)), TOAST_MS);
    },
  };
}

export interface PageParts {
  host: Host;
  session: Session;
  screen: Screen;
  name: string;
  listed: Signal<Listed>;
  pick: Page["pick"];
  toasts: Toasts;
  /** Asks for the nodes of the session's scene; `null` where there is no answer. */
  fetchNodes(): Promise<SceneNodes | null>;
  /** Asks for all alternatives of a drag. */
  fetchAlternatives(request: AlternativesRequest): Promise<AlternativesReply>;
}

export function startPage(parts: PageParts): Page {
  const { host, session, screen, name, listed, pick, toasts, fetchNodes, fetchAlternatives } = parts;
  const presses = startPresses(host, session);
  const selectedLight = signal<LightId | null>(null);
  const passing = { held: signal(false), on: signal(false) };
  const passes = computed(() => passing.held.value || passing.on.value);
  const page: Page = {
    session: withPassing(committing(session, presses), passes),
    presses,
    screen,
    name,
    listed,
    pick,
    selectedLight,
    selectedPoint: signal(null),
    radiiFollow: signal(false),
    snaps: signal(false),
    toolbox: startTools(),
    answers: otherAnswers({
      after: host.after,
      ask(command) {
        // Others may have removed the light.
        const request = requestOf(command, session.mirror.value.document);
        return request === null ? Promise.resolve({ why: LIGHT_IS_GONE }) : fetchAlternatives(request);
      },
    }),
    passing,
    aiming: signal<Aiming>("off"),
    linking: signal<Linking | null>(null),
    excursion: signal<Excursion | null>(null),
    scope: signal<Scope>("mine"),
    showHandles: signal(true),
    showGate: signal(true),
    showKeys: signal(false),
    probe: {
      held: signal(false),
      on: signal(false),
      at: signal<Pixel | null>(null),
      byFinger: signal(false),
    },
    removal: signal<Removal | null>(null),
    reachedFor: signal<LightId | null>(null),
    toasts: toasts.list,
    say: toasts.add,
    toldOvertaken: signal(null),
    nodes: signal(null),
    hint: signal<number | null>(null),
  };
  effect(() => session.select(selectedLight.value));
  effect(() => followLights(page));
  effect(() => {
    const { value } = page.reachedFor;
    if (value !== null && holderOf(page, value) === null) page.reachedFor.value = null;
  });
  followScene(page, fetchNodes);
  return page;
}

export function selectLight(page: Page, light: LightId | null): void {
  if (light !== page.selectedLight.value) page.selectedPoint.value = null;
  page.selectedLight.value = light;
}

/** Keeps something selected that is there: at first, and when the selected light was removed, the first. */
function followLights(page: Page): void {
  const { lights } = page.session.document.value;
  const selected = page.selectedLight.peek();
  const light = lights.find((entry) => entry.id === selected);
  if (light === undefined) {
    selectLight(page, lights[0]?.id ?? null);
  } else if (light.light.type === "bendy") {
    const last = light.light.points.length - 1;
    const point = page.selectedPoint.peek();
    if (point !== null && point > last) page.selectedPoint.value = last;
  }
}

/** Keeps the nodes those of the scene that the document has. */
function followScene({ session, nodes }: Page, fetchNodes: PageParts["fetchNodes"]): void {
  const asset = computed(() => session.document.value.scene?.asset);
  effect(() => {
    const wanted = asset.value;
    nodes.value = null;
    if (wanted === undefined) return;
    void fetchNodes().then((found) => {
      if (asset.peek() === wanted) nodes.value = found;
    });
  });
}

const PageContext = createContext<Page | null>(null);
export const PageProvider = PageContext.Provider;

/** The page that a component belongs to. */
export function usePage(): Page {
  const page = useContext(PageContext);
  if (page === null) throw new Error("A component of the page stands outside of it.");
  return page;
}

/** Client that drags the light now. */
export const holderOf = ({ session }: Page, light: LightId): ClientId | null =>
  session.gestures.value.find((gesture) => gesture.light === light)?.client ?? null;

/** Reaches for a light: whether it can be dragged now. Where somebody else has it, the page says who. */
export function reachFor(page: Page, light: LightId): boolean {
  const isFree = holderOf(page, light) === null;
  page.reachedFor.value = isFree ? null : light;
  return isFree && canEdit(page);
}

/** True if edits can be made now. */
export const canEdit = (page: Page): boolean => page.session.connection.value.kind === "connected";
