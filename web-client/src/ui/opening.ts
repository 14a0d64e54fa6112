// A scene from a person's own disk: made one file, sent to the server, and loaded.

import { type Signal, signal } from "@preact/signals";
import { createContext } from "preact";
import { useContext } from "preact/hooks";

import { type Given, isGltf, pack, type Packed, sceneAmong, sceneNameOf } from "../core/gltf_pack";

/** A scene on its way. */
export type Opening =
  /** Its files are put together. */
  | { kind: "packing"; name: string; stop(): void }
  | { kind: "sending"; name: string; sent: number; size: number; stop(): void }
  /** All of it is with the server, which reads it. */
  | { kind: "reading"; name: string; stop(): void }
  | { kind: "loading"; name: string }
  | { kind: "failed"; name: string; why: string; again: (() => void) | null };

/** Events of an upload. After `stop` there are none. */
export interface SendingEvents {
  progress(sent: number, size: number): void;
  /** All of it has gone. */
  sent(): void;
  kept(asset: string): void;
  failed(why: string): void;
}

/** Sends a scene's file; the answer stops that. */
export type SendScene = (file: Blob, name: string, events: SendingEvents) => () => void;

export interface OpeningParts {
  send: SendScene;
  /** Loads what the server has kept, under a title that may be empty; a sentence says why not. */
  load(asset: string, title: string): Promise<string | null>;
  /** Why no scene can be opened now, if none can. */
  hindrance(): string | null;
  say(message: string): void;
}

/** Opens one scene at a time. */
export interface SceneOpening {
  state: Signal<Opening | null>;
  /** Opens the scene among files that were picked or dropped. It is called `title`, or where that is empty as its file is. */
  open(given: readonly Given<File>[], title?: string): void;
  /** Says of files that they cannot be opened. */
  fail(why: string): void;
}

const SCENE = "the scene";
const BUSY = "A scene is on its way already: wait for it, or cancel it first.";

export function startOpening({ send, load, hindrance, say }: OpeningParts): SceneOpening {
  const state = signal<Opening | null>(null);
  const fail = (why: string, name = SCENE, again: (() => void) | null = null) =>
    (state.value = { kind: "failed", name, why, again });

  function sendFile(file: Blob, name: string, title: string): void {
    const shown = name || SCENE;
    let cancel = () => {};
    const stop = () => {
      state.value = null;
      cancel();
    };
    state.value = { kind: "sending", name: shown, sent: 0, size: file.size, stop };
    cancel = send(file, name, {
      progress: (sent, size) => (state.value = { kind: "sending", name: shown, sent, size, stop }),
      sent: () => (state.value = { kind: "reading", name: shown, stop }),
      kept: (asset) => void loadAsset(asset, shown, title || name),
      failed: (why) => fail(why, shown, () => sendFile(file, name, title)),
    });
  }

  async function loadAsset(asset: string, shown: string, title: string): Promise<void> {
    state.value = { kind: "loading", name: shown };
    const why = await load(asset, title);
    if (why === null) state.value = null;
    else fail(why, shown, () => void loadAsset(asset, shown, title));
  }

  return {
    state,
    open(given, title = "") {
      const why = hindrance();
      if (why !== null) return say(why);
      if (state.value !== null && state.value.kind !== "failed") return say(BUSY);
      const found = sceneAmong(given);
      if ("why" in found) {
        fail(found.why);
        return;
      }
      const { scene } = found;
      const name = sceneNameOf(scene.path);
      const packing: Opening = { kind: "packing", name: name || SCENE, stop: () => (state.value = null) };
      state.value = packing;
      void asOneFile(scene, given).then((packed) => {
        if (state.value !== packing) return;
        if ("parts" in packed) sendFile(new Blob(packed.parts), name, title);
        else fail(packed.why, packing.name);
      });
    },
    fail,
  };
}

async function asOneFile(scene: Given<File>, given: readonly Given<File>[]): Promise<Packed<File>> {
  if (!isGltf(scene.path)) return { parts: [scene.file] };
  try {
    return pack(scene, await scene.file.text(), given);
  } catch {
    return { why: `“${scene.path}” cannot be read: it has changed, or it is too large. Pick it again.` };
  }
}

const OpeningContext = createContext<SceneOpening | null>(null);
export const OpeningProvider = OpeningContext.Provider;

/** Opens scenes in the session of the component, or as a new session. */
export function useOpening(): SceneOpening {
  const opening = useContext(OpeningContext);
  if (opening === null) throw new Error("A component that opens scenes stands where none can be opened.");
  return opening;
}
