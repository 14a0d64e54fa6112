// Lights that are removed: at once, or where more goes with them once a person has said so.

import { useLayoutEffect, useRef } from "preact/hooks";

import { lightName, lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import { pinsOf } from "../core/pins";
import { type Page, usePage } from "./page";
import type { Removal } from "./page_state";

/** Removes the light; one that takes pins with it only once a person has agreed. */
export function removeLight(page: Page, light: LightId, leave: () => void): void {
  if (pinsOf(page.session.document.value, light).length > 0) page.removal.value = { light, leave };
  else remove(page, { light, leave });
}

function remove({ session }: Page, { light, leave }: Removal): void {
  leave();
  session.edit({ type: "removeLight", light });
}

/** Asks, while there is something to ask. */
export function RemovalQuestion() {
  const page = usePage();
  const { session, removal } = page;
  const dialog = useRef<HTMLDialogElement>(null);
  const { value } = removal;
  const document = session.document.value;
  // Somebody else may have removed it meanwhile.
  const asked = value !== null && lightOf(document, value.light) !== undefined ? value : null;
  const isAsked = asked !== null;
  // Before the next key comes, which is for the question.
  useLayoutEffect(() => {
    if (isAsked) dialog.current?.showModal();
    else dialog.current?.close();
  }, [isAsked]);
  const end = () => (removal.value = null);
  const agree = () => {
    // The focus goes back to what it was before, and from there on.
    dialog.current?.close();
    end();
    if (asked !== null) remove(page, asked);
  };
  const pins = asked === null ? 0 : pinsOf(document, asked.light).length;
  return (
    <dialog class="question" ref={dialog} aria-labelledby="removal" onCancel={end}>
      {asked !== null && (
        <>
          <p id="removal">
            {lightName(document, asked.light)} and {pins === 1 ? "its pin" : `${pins} pins`} go. Undo brings
            them back.
          </p>
          <footer>
            <button class="solid" onClick={end}>
              Keep
            </button>
            <button class="solid" onClick={agree}>
              Remove
            </button>
          </footer>
        </>
      )}
    </dialog>
  );
}
