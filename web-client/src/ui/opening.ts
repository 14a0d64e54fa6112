// A scene from a person's own disk: made one file, sent to the server, and loaded into the session.

import { type Given, isGltf, pack, type Packed, sceneAmong, sceneNameOf } from "../core/gltf_pack";
import { fitScene } from "./fitting";
import { canEdit, type Page } from "./page";

/** A scene on its way. */
export type Opening =
  /** Its files are put together. */
  | { kind: "packing"; name: string; stop(): void }
  | { kind: "sending"; name: string; sent: number; size: number; stop(): void }
  /** All of it is with the server, which reads it. */
  | { kind: "reading"; name: string; stop(): void }
  | { kind: "failed"; name: string; why: string; again: (() => void) | null };

/** What is told of a file that is sent. After `stop` nothing is. */
export interface SendingEvents {
  progress(sent: number, size: number): void;
  /** All of it has gone. */
  sent(): void;
  kept(asset: string): void;
  failed(why: string): void;
}

/** Sends a scene's file; the answer stops that. */
export type SendScene = (file: Blob, name: string, events: SendingEvents) => () => void;

const SCENE = "the scene";

/** Opens the scene among files that were picked or dropped. */
export function openScene(page: Page, given: readonly Given<File>[]): void {
  const { opening } = page;
  if (!canEdit(page)) {
    page.say("Not connected: no scene can be opened now. Try again once the page is connected.");
    return;
  }
  if (opening.value !== null && opening.value.kind !== "failed") {
    page.say("A scene is on its way already: wait for it, or cancel it first.");
    return;
  }
  const found = sceneAmong(given);
  if ("why" in found) {
    opening.value = { kind: "failed", name: SCENE, why: found.why, again: null };
    return;
  }
  const { scene } = found;
  const name = sceneNameOf(scene.path);
  const packing: Opening = { kind: "packing", name: name || SCENE, stop: () => (opening.value = null) };
  opening.value = packing;
  void asOneFile(scene, given).then((packed) => {
    if (opening.value !== packing) return;
    if ("parts" in packed) send(page, new Blob(packed.parts), name);
    else opening.value = { kind: "failed", name: packing.name, why: packed.why, again: null };
  });
}

async function asOneFile(scene: Given<File>, given: readonly Given<File>[]): Promise<Packed<File>> {
  if (!isGltf(scene.path)) return { parts: [scene.file] };
  try {
    return pack(scene, await scene.file.text(), given);
  } catch {
    return { why: `“${scene.path}” cannot be read: it has changed, or it is too large. Pick it again.` };
  }
}

function send(page: Page, file: Blob, name: string): void {
  const { opening } = page;
  const shown = name || SCENE;
  let cancel = () => {};
  const stop = () => {
    opening.value = null;
    cancel();
  };
  opening.value = { kind: "sending", name: shown, sent: 0, size: file.size, stop };
  cancel = page.sendScene(file, name, {
    progress: (sent, size) => (opening.value = { kind: "sending", name: shown, sent, size, stop }),
    sent: () => (opening.value = { kind: "reading", name: shown, stop }),
    kept: (asset) => load(page, asset, shown),
    failed: (why) =>
      (opening.value = { kind: "failed", name: shown, why, again: () => send(page, file, name) }),
  });
}

/** Loads what the server has kept, and looks at it as its first camera does. */
function load(page: Page, scene: string, name: string): void {
  const { opening, session } = page;
  if (!canEdit(page)) {
    const why = "The server has it, but this page is not connected: load it once it is.";
    opening.value = { kind: "failed", name, why, again: () => load(page, scene, name) };
    return;
  }
  opening.value = null;
  session.edit({ type: "loadScene", scene }, () => {
    const [first] = session.document.value.cameras;
    if (first === undefined) fitScene(page);
    else session.viewer.jump(first.camera);
  });
}
