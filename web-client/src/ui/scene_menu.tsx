// Menu beside the scene's name that opens another scene.

import { useState } from "preact/hooks";

import { pickFiles } from "./given_files";
import { Icon } from "./icons";
import { useOpening } from "./opening";

const MENU = "scene-menu";
export const MENU_BUTTON = "open-scene";

export function SceneMenu() {
  const opening = useOpening();
  const [open, setOpen] = useState(false);
  const pick = (folder: boolean) => {
    document.getElementById(MENU)?.hidePopover();
    pickFiles(folder, (given) => opening.open(given));
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
