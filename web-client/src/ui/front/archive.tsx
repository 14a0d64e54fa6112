// Sessions that are archived: brought back, or deleted for good.

import { useEffect, useRef, useState } from "preact/hooks";

import type { SessionEntry } from "../../core/protocol";
import { Icon } from "../icons";
import { QuietButton } from "../quiet_button";
import { Card } from "./card";
import { useFront } from "./front";

const LIST = "archived-sessions";

export function Archive() {
  const { archived, find } = useFront();
  const [isOpen, setOpen] = useState(false);
  const sessions = archived.value;
  if (sessions.length === 0) return <DeleteDialog />;
  // A search shows its matches wherever they are.
  const isShown = isOpen || find.value.trim() !== "";
  return (
    <section aria-label="Archived">
      <h2 class="front-heading">
        <button
          class="quiet"
          aria-expanded={isShown}
          aria-controls={isShown ? LIST : undefined}
          onClick={() => setOpen(!isOpen)}
        >
          <Icon name="fold" />
          Archived ({sessions.length})
        </button>
      </h2>
      {isShown && (
        <ul class="cards" id={LIST}>
          {sessions.map((session) => (
            <Card key={session.name} session={session}>
              <ArchivedActions session={session} />
            </Card>
          ))}
        </ul>
      )}
      <DeleteDialog />
    </section>
  );
}

function ArchivedActions({ session }: { session: SessionEntry }) {
  const { archive, deleting } = useFront();
  const { title } = session;
  return (
    <>
      <QuietButton
        title="Bring back"
        label={`Bring back ${title}`}
        press={() => void archive(session, false)}
      >
        <Icon name="undo" />
      </QuietButton>
      <QuietButton title="Delete" label={`Delete ${title}`} press={() => (deleting.value = session)}>
        <Icon name="trash" />
      </QuietButton>
    </>
  );
}

/** Asks again, and says what goes. */
function DeleteDialog() {
  const { deleting, remove } = useFront();
  const dialog = useRef<HTMLDialogElement>(null);
  const session = deleting.value;
  useEffect(() => {
    if (session !== null) dialog.current?.showModal();
    else dialog.current?.close();
  }, [session]);
  const close = () => (deleting.value = null);
  return (
    <dialog class="front-dialog" ref={dialog} aria-labelledby="deleting" onCancel={close}>
      {session !== null && (
        <>
          <h2 id="deleting">Delete “{session.title}”?</h2>
          <p>
            {whatGoes(session.seq)} go for good, from the server's disk too: neither undo nor its link brings
            them back. The scene stays, as other sessions may show it.
          </p>
          <div class="dialog-buttons">
            <button class="solid" onClick={close}>
              Keep it
            </button>
            <button
              class="solid danger"
              onClick={() => {
                close();
                void remove(session);
              }}
            >
              Delete
            </button>
          </div>
        </>
      )}
    </dialog>
  );
}

/** Says how much is deleted with a session of so many records. */
function whatGoes(seq: number): string {
  if (seq === 0) return "It has no step yet, and its name and link";
  return seq === 1 ? "Its lights and its one step" : `Its lights and all of its ${seq} steps`;
}
