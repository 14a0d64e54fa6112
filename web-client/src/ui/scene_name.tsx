// Name of the scene, and the parts of its file that are not drawn.

import { Icon } from "./icons";
import { Name } from "./name";
import { usePage } from "./page";
import { sentence } from "./sentence";

const LIST = "scene-notes";
/** Name of a scene's asset; versions before names of scenes gave it to the scene, too. */
const HASH = /^sha256:([0-9a-f]{8})[0-9a-f]{56}$/;

export function SceneName() {
  const { session } = usePage();
  const { scene } = session.document.value;
  return (
    <>
      <span class="scene-name">
        <Name
          name={scene?.name.replace(HASH, "scene $1") ?? "no scene"}
          title={`Scene ${scene?.name ?? ""}`}
        />
      </span>
      <Notes notes={session.notes.value} />
    </>
  );
}

/** A button that opens the list of notes. The browser closes it on Escape or a click elsewhere, and gives the focus back. */
function Notes({ notes }: { notes: readonly string[] }) {
  if (notes.length === 0) return null;
  const count = notes.length === 1 ? "1 note" : `${notes.length} notes`;
  return (
    <>
      <button
        class="quiet"
        popoverTarget={LIST}
        title="What of the scene's file is not drawn"
        aria-label={`${count} on the scene`}
      >
        <Icon name="note" />
        {count}
      </button>
      <section id={LIST} class="scene-notes" popover="auto" aria-label="Notes on the scene">
        <h2>Not drawn, or drawn otherwise</h2>
        <ul>
          {notes.map((note) => (
            <li key={note}>{sentence(note)}</li>
          ))}
        </ul>
      </section>
    </>
  );
}
