// Session, undo, who is here, and whether the page is connected.

import { useState } from "preact/hooks";

import type { ConnectionState } from "../core/connection";
import type { HistoryStep, Presence, Scope } from "../core/protocol";
import { addressOf } from "./address";
import { TextField } from "./fields";
import { Icon } from "./icons";
import { Name } from "./name";
import { canEdit, usePage } from "./page";
import { colorOf } from "./person";
import { QuietButton } from "./quiet_button";
import { SceneMenu } from "./scene_menu";
import { SceneName } from "./scene_name";
import { redo, undo } from "./undoing";

export function TopBar() {
  const page = usePage();
  const { session, name, listed } = page;
  const { title, archived } = listed.value;
  return (
    <header class="top-bar">
      <a class="quiet all-sessions" href={addressOf(null)} title="All sessions" aria-label="All sessions">
        <Icon name="sessions" />
      </a>
      <div class="where">
        <h1>BendyLights</h1>
        <span class="session-name">
          <Name name={title} title={title === name ? "Session" : `Session ${name}`} />
        </span>
        {archived && (
          <span
            class="archived-note"
            title="It is left out of the list of sessions until it is brought back there"
          >
            Archived
          </span>
        )}
        <SceneName />
        <SceneMenu />
      </div>
      <UndoButtons />
      <span class="spring" />
      <People />
      <ConnectionBadge state={session.connection.value} />
    </header>
  );
}

const SCOPES: { [S in Scope]: { label: string; title: string } } = {
  mine: { label: "Mine", title: "Undo and redo my own steps" },
  session: { label: "All", title: "Undo and redo anybody's steps" },
};

function UndoButtons() {
  const page = usePage();
  const { session, scope } = page;
  const history = session.history.value;
  return (
    <div class="undo" role="group" aria-label="Undo and redo">
      <StepButton
        kind="undo"
        keys="Ctrl+Z"
        // A gesture becomes a step, and the first to be undone.
        step={session.ownDrag.value === null ? history?.undo[scope.value] : undefined}
        press={() => undo(page)}
      />
      <StepButton
        kind="redo"
        keys="Ctrl+Shift+Z"
        step={history?.redo[scope.value]}
        press={() => redo(page)}
      />
      <div class="toggle" role="group" aria-label="Whose steps">
        {(Object.keys(SCOPES) as Scope[]).map((choice) => (
          <button
            key={choice}
            title={SCOPES[choice].title}
            aria-pressed={scope.value === choice}
            onClick={() => (scope.value = choice)}
          >
            {SCOPES[choice].label}
          </button>
        ))}
      </div>
    </div>
  );
}

interface StepButtonProps {
  kind: "undo" | "redo";
  keys: string;
  /** Step that it takes back; `null` for none, `undefined` before it is known. */
  step: HistoryStep | null | undefined;
  press(): void;
}

/** Says what it will take back, and of whom; grey where there is nothing. */
function StepButton({ kind, keys, step, press }: StepButtonProps) {
  const page = usePage();
  const verb = kind === "undo" ? "Undo" : "Redo";
  const isOwn = step?.actor.id === page.session.actor.value.id;
  const by = step === null || step === undefined || isOwn ? "" : `, by ${step.actor.name}`;
  const label = step === null ? `Nothing to ${kind}` : `${verb} ${step?.what ?? "the last step"}${by}`;
  return (
    <QuietButton
      class={`step-${kind}`}
      title={step === null ? label : `${label} (${keys})`}
      label={label}
      disabled={step === null || !canEdit(page)}
      press={press}
    >
      <Icon name={kind} />
    </QuietButton>
  );
}

function People() {
  const { session } = usePage();
  const own = session.client.value;
  const others = session.people.value.filter(({ client }) => client !== own);
  return (
    <ul class="people" aria-label="Who is here">
      {others.map((person) => (
        <Other key={person.client} person={person} />
      ))}
      <Self />
    </ul>
  );
}

function Other({ person: { client, actor, following } }: { person: Presence }) {
  const { session } = usePage();
  const { viewer } = session;
  const followed = viewer.following.value === client;
  const followsMe = following === session.client.value;
  const title = followed ? `Stop following ${actor.name}` : `Follow ${actor.name}'s view`;
  return (
    <li>
      <button
        class="person"
        data-person={client}
        aria-pressed={followed}
        aria-label={title}
        title={followsMe ? `${title} (follows yours)` : title}
        onClick={() => viewer.follow(followed ? null : client)}
      >
        <span class="dot" style={{ background: colorOf(client) }} />
        <Name name={actor.name} title={title} />
        {(followed || followsMe) && <Icon name="view" />}
      </button>
    </li>
  );
}

function Self() {
  const { session } = usePage();
  const [editing, setEditing] = useState(false);
  const { name } = session.actor.value;
  const rename = (text: string) => text.trim() !== "" && session.rename(text.trim());
  return (
    <li
      class="person self"
      // The button that the field takes the place of loses the focus too.
      onFocusOut={({ target }) => target instanceof HTMLInputElement && setEditing(false)}
    >
      <span class="dot" style={{ background: colorOf(session.client.value ?? 0) }} />
      {editing ? (
        <TextField label="Your name" value={name} set={rename} disabled={false} autofocus />
      ) : (
        <button
          class="self-name"
          aria-label={`${name}, you. Change your name`}
          onClick={() => setEditing(true)}
        >
          <Name name={name} title={`${name}, you. Change your name`} />
        </button>
      )}
    </li>
  );
}

const CONNECTION: { [K in ConnectionState["kind"]]: string } = {
  connecting: "Connecting",
  connected: "Connected",
  reconnecting: "Reconnecting",
  draining: "Server stopping",
  refused: "Refused",
};

function ConnectionBadge({ state }: { state: ConnectionState }) {
  const { session } = usePage();
  const { roundTripMs } = session.statistics.value;
  const title = roundTripMs === null ? CONNECTION[state.kind] : `Round trip ${roundTripMs.toFixed(0)} ms`;
  return (
    <span class="connection" data-kind={state.kind} role="status" title={title}>
      {CONNECTION[state.kind]}
    </span>
  );
}
