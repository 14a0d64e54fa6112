// The front page: all sessions, in place of one.

import { useEffect, useState } from "preact/hooks";

import type { SessionEntry } from "../../core/protocol";
import { DropTarget } from "../drop_target";
import { Icon } from "../icons";
import { FRONT_KEYS, KeyList } from "../key_list";
import { OpeningPanel } from "../opening_panel";
import { QuietButton } from "../quiet_button";
import { Toasts } from "../toasts";
import { Archive } from "./archive";
import { Card } from "./card";
import { useFront } from "./front";
import { bindFrontKeys } from "./keys";
import { NewSession } from "./new_session";

/** With more sessions than these they are looked for by name. */
const MANY = 12;
/** Time between requests for the list while the page is visible. */
const REFRESH_MS = 5_000;
/** Cards that are there at once; more come on demand. */
const PAGE = 200;
const OPENER = "new-session-button";
const STALE = "The server does not answer: what stands here may be old.";

export function FrontPage() {
  const front = useFront();
  const { showKeys, making, title, find, missing, toasts, refresh, count } = front;
  useEffect(() => {
    const again = () => document.hidden || refresh().catch(() => toasts.add(STALE));
    const timer = setInterval(again, REFRESH_MS);
    document.addEventListener("visibilitychange", again);
    return () => {
      clearInterval(timer);
      document.removeEventListener("visibilitychange", again);
    };
  }, [refresh, toasts]);
  useEffect(() => bindFrontKeys(front), [front]);
  return (
    <div class="front">
      <header class="top-bar">
        <h1>BendyLights</h1>
        <span class="spring" />
        {count.value > MANY && (
          <input
            class="text find"
            type="search"
            aria-label="Find sessions"
            placeholder="Find"
            value={find.value}
            onInput={(event) => (find.value = event.currentTarget.value)}
          />
        )}
        <QuietButton title="Keys" press={() => (showKeys.value = true)}>
          Keys
        </QuietButton>
        <button id={OPENER} class="solid" onClick={() => (making.value = true)}>
          <Icon name="plus" />
          New session
        </button>
      </header>
      <main class="front-main">
        {missing !== null && (
          <p class="front-note" role="alert">
            There is no session called “{missing}” here. It may have been deleted, or its link is not whole.
          </p>
        )}
        <Sessions />
        <Archive />
      </main>
      <NewSession />
      <div class="corner">
        <OpeningPanel opener={OPENER} />
        <Toasts toasts={toasts.list} />
      </div>
      <DropTarget title={title} />
      <KeyList shown={showKeys} keys={FRONT_KEYS} />
    </div>
  );
}

function Sessions() {
  const { current, count, find } = useFront();
  const [most, setMost] = useState(PAGE);
  const left = current.value.length - most;
  return (
    <section aria-label="Sessions">
      <h2 class="front-heading">Sessions</h2>
      {count.value === 0 && (
        <p class="front-empty">
          No sessions yet. Begin a new one, or drop a scene of your own here: a .glb, a .gltf with its files,
          or a folder.
        </p>
      )}
      {count.value > 0 && current.value.length === 0 && (
        <p class="front-empty">No session has “{find.value.trim()}” in its name.</p>
      )}
      <ul class="cards">
        {current.value.slice(0, most).map((session) => (
          <Card key={session.name} session={session}>
            <CurrentActions session={session} />
          </Card>
        ))}
      </ul>
      {left > 0 && (
        <button class="solid more" onClick={() => setMost(most + PAGE)}>
          Show more ({left} left)
        </button>
      )}
    </section>
  );
}

function CurrentActions({ session }: { session: SessionEntry }) {
  const { renaming, duplicate, archive } = useFront();
  const { name, title } = session;
  return (
    <>
      <QuietButton title="Rename" label={`Rename ${title}`} press={() => (renaming.value = name)}>
        <Icon name="pencil" />
      </QuietButton>
      <QuietButton title="Duplicate" label={`Duplicate ${title}`} press={() => void duplicate(session)}>
        <Icon name="copy" />
      </QuietButton>
      <QuietButton title="Archive" label={`Archive ${title}`} press={() => void archive(session, true)}>
        <Icon name="archive" />
      </QuietButton>
    </>
  );
}
