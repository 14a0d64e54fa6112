// The front page's state: the sessions as the server lists them, and what is done with them.

import { computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import { createContext } from "preact";
import { useContext } from "preact/hooks";

import type { Actor, DemoScene, SessionEntry } from "../../core/protocol";
import { copyTitle, freeTitle, latestFirst, matching, nameFor, UNTITLED } from "../../core/session_list";
import { goTo } from "../address";
import type { Toasts } from "../page";
import { Refused, type Server } from "./server";
import { startThumbnails, type Thumbnails } from "./thumbnails";

export interface Front {
  /** Sessions that people work on and that are looked for, the latest first. */
  current: ReadonlySignal<readonly SessionEntry[]>;
  archived: ReadonlySignal<readonly SessionEntry[]>;
  /** Number of all, with or without a search. */
  count: ReadonlySignal<number>;
  demos: Signal<readonly DemoScene[]>;
  /** When the list came, in milliseconds since 1970. */
  nowMs: Signal<number>;
  find: Signal<string>;
  /** The name in the address, where there is no session called so. */
  missing: string | null;
  /** The session whose title is being typed. */
  renaming: Signal<string | null>;
  /** The session of which it is asked whether it shall go. */
  deleting: Signal<SessionEntry | null>;
  /** True while the form of a new session is open. */
  making: Signal<boolean>;
  /** The title typed for a new session. */
  title: Signal<string>;
  showKeys: Signal<boolean>;
  /** The session whose card gets the focus once it is there. */
  focused: Signal<string | null>;
  thumbnails: Thumbnails;
  toasts: Toasts;
  refresh(): Promise<void>;
  create(title: string, scene: string | null): Promise<void>;
  /** Makes a session of a scene that the server has, and leads there; a sentence says why not. */
  begin(asset: string, title: string): Promise<string | null>;
  rename(session: SessionEntry, title: string): Promise<void>;
  duplicate(session: SessionEntry): Promise<void>;
  archive(session: SessionEntry, archived: boolean): Promise<void>;
  remove(session: SessionEntry): Promise<void>;
}

export interface FrontParts {
  server: Server;
  /** Sessions of the first list. */
  sessions: readonly SessionEntry[];
  missing: string | null;
  actor: Actor;
  toasts: Toasts;
}

/** Maximum number of names that are tried for a new session. */
const MOST_NAMES = 100;
const TAKEN = 409;

export function startFront({ server, sessions, missing, actor, toasts }: FrontParts): Front {
  const all = signal<readonly SessionEntry[]>(latestFirst(sessions));
  const nowMs = signal(Date.now());
  const find = signal("");
  const focused = signal<string | null>(null);
  const titles = () => new Set(all.value.map(({ title }) => title));

  async function refresh(): Promise<void> {
    all.value = latestFirst(await server.list());
    nowMs.value = Date.now();
  }

  /** Does `task` and lists anew; says why not where it is refused. */
  async function carryOut(task: () => Promise<void>): Promise<boolean> {
    try {
      await task();
      await refresh();
      return true;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      toasts.add(error.message);
      return false;
    }
  }

  /** Makes a session by `make` under the first name for `title` that is free, and gives that. */
  async function named(title: string, make: (name: string) => Promise<void>): Promise<string> {
    for (let attempt = 1; ; attempt += 1) {
      const name = nameFor(title, attempt);
      try {
        await make(name);
        return name;
      } catch (error) {
        const isTaken = error instanceof Refused && error.status === TAKEN && attempt < MOST_NAMES;
        if (!isTaken) throw error;
      }
    }
  }

  /** Makes a session and leads there. */
  async function begin(typed: string, of: { scene?: string }): Promise<void> {
    const title = typed === "" ? freeTitle(UNTITLED, titles()) : typed;
    goTo(await named(title, (name) => server.create({ name, title, actor, ...of })));
  }

  return {
    current: computed(() => matching(all.value, find.value).filter(({ archived }) => !archived)),
    archived: computed(() => matching(all.value, find.value).filter(({ archived }) => archived)),
    count: computed(() => all.value.filter(({ archived }) => !archived).length),
    demos: signal<readonly DemoScene[]>([]),
    nowMs,
    find,
    missing,
    renaming: signal(null),
    deleting: signal<SessionEntry | null>(null),
    making: signal(false),
    title: signal(""),
    showKeys: signal(false),
    focused,
    thumbnails: startThumbnails(server),
    toasts,
    refresh,
    async create(title, scene) {
      await carryOut(() => begin(title, scene === null ? {} : { scene }));
    },
    async begin(scene, title) {
      try {
        await begin(title, { scene });
        return null;
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        return error.message;
      }
    },
    async rename(session, title) {
      await carryOut(() => server.change(session.name, { title }));
      focused.value = session.name;
    },
    async duplicate(session) {
      const title = copyTitle(session.title, titles());
      let made = "";
      const isMade = await carryOut(async () => {
        made = await named(title, (name) => server.duplicate(session.name, { name, title }));
      });
      if (!isMade) return;
      toasts.add(`“${title}” has all that “${session.title}” has, its undo too.`);
      focused.value = made;
    },
    async archive(session, archived) {
      if (!(await carryOut(() => server.change(session.name, { archived })))) return;
      toasts.add(
        archived ? `“${session.title}” is archived: its link still opens it.` : `“${session.title}” is back.`,
      );
      if (!archived) focused.value = session.name;
    },
    async remove(session) {
      if (await carryOut(() => server.remove(session.name))) toasts.add(`“${session.title}” is deleted.`);
    },
  };
}

const FrontContext = createContext<Front | null>(null);
export const FrontProvider = FrontContext.Provider;

/** The front page that a component belongs to. */
export function useFront(): Front {
  const front = useContext(FrontContext);
  if (front === null) throw new Error("A component of the front page stands outside of it.");
  return front;
}
