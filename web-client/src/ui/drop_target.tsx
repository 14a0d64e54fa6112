// Files that are dropped anywhere on the page.

import type { ReadonlySignal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";

import { droppedFiles, hasFiles } from "./given_files";
import { type SceneOpening, useOpening } from "./opening";

/** Says that files can be let go of, while they are over the page, and takes them, under `title` where one is typed. What is dropped never leads the page away. */
export function DropTarget({ title }: { title?: ReadonlySignal<string> }) {
  const opening = useOpening();
  const [over, setOver] = useState(false);
  useEffect(() => {
    const listening = new AbortController();
    const { signal } = listening;
    const drag = (event: DragEvent) => {
      // Text that is dropped into a field is the field's.
      if (!hasFiles(event) && isField(event.target)) return;
      event.preventDefault();
      if (event.dataTransfer !== null) event.dataTransfer.dropEffect = hasFiles(event) ? "copy" : "none";
      setOver(hasFiles(event));
    };
    addEventListener("dragenter", drag, { signal });
    addEventListener("dragover", drag, { signal });
    // Nothing is entered where the pointer leaves the window.
    addEventListener("dragleave", ({ relatedTarget }) => relatedTarget === null && setOver(false), {
      signal,
    });
    addEventListener("drop", (event) => drop(event, opening, setOver, title), { signal });
    return () => listening.abort();
  }, [opening, title]);
  return over ? (
    <div class="drop-target" role="status">
      <p>Let go to open a scene: a .glb, a .gltf with its files, or a folder</p>
    </div>
  ) : null;
}

const isField = (target: EventTarget | null): boolean =>
  target instanceof HTMLElement && target.matches("input, textarea");

function drop(
  event: DragEvent,
  opening: SceneOpening,
  setOver: (over: boolean) => void,
  title?: ReadonlySignal<string>,
): void {
  setOver(false);
  if (!hasFiles(event)) {
    if (!isField(event.target)) event.preventDefault();
    return;
  }
  event.preventDefault();
  void droppedFiles(event).then(
    (given) => {
      if (given === null) opening.fail("These are too many files for a scene: drop the scene's own folder.");
      else opening.open(given, title?.value.trim());
    },
    () =>
      opening.fail(
        "A file of what you dropped cannot be read: check that you may open it, and drop it again.",
      ),
  );
}
