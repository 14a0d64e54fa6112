// What opens another scene: a menu beside the scene's name, and files that are dropped anywhere on the page.

import { useEffect, useState } from "preact/hooks";

import { droppedFiles, hasFiles, pickFiles } from "./given_files";
import { Icon } from "./icons";
import { openScene } from "./opening";
import { type Page, usePage } from "./page";

const MENU = "scene-menu";
export const MENU_BUTTON = "open-scene";

export function SceneMenu() {
  const page = usePage();
  const [open, setOpen] = useState(false);
  const pick = (folder: boolean) => {
    document.getElementById(MENU)?.hidePopover();
    pickFiles(folder, (given) => openScene(page, given));
  };
  return (
    <>
      <button
        id={MENU_BUTTON}
        class="quiet"
        popoverTarget={MENU}
        title="Open a scene of your own, for everybody in the session"
        aria-label="Open a scene"
      >
        <Icon name="open" />
      </button>
      <section
        id={MENU}
        class="scene-notes scene-menu"
        popover="auto"
        aria-label="Open a scene"
        onBeforeToggle={(event) => setOpen(event.newState === "open")}
      >
        {open && (
          <>
            <button class="solid" onClick={() => pick(false)}>
              Pick files
            </button>
            <button class="solid" onClick={() => pick(true)}>
              Pick a folder
            </button>
            <p>
              A .glb, or a .gltf together with its files. They can be dropped on the page too. Undo brings
              back what is here now.
            </p>
          </>
        )}
      </section>
    </>
  );
}

/** Says that files can be let go of, while they are over the page, and takes them. What is dropped never leads the page away. */
export function DropTarget() {
  const page = usePage();
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
    addEventListener("drop", (event) => drop(event, page, setOver), { signal });
    return () => listening.abort();
  }, [page]);
  return over ? (
    <div class="drop-target" role="status">
      <p>Let go to open a scene: a .glb, a .gltf with its files, or a folder</p>
    </div>
  ) : null;
}

const isField = (target: EventTarget | null): boolean =>
  target instanceof HTMLElement && target.matches("input, textarea");

function drop(event: DragEvent, page: Page, setOver: (over: boolean) => void): void {
  setOver(false);
  if (!hasFiles(event)) {
    if (!isField(event.target)) event.preventDefault();
    return;
  }
  event.preventDefault();
  void droppedFiles(event).then(
    (given) => {
      if (given === null) page.say("These are too many files for a scene: drop the scene's own folder.");
      else openScene(page, given);
    },
    () =>
      page.say("A file of what you dropped cannot be read: check that you may open it, and drop it again."),
  );
}
