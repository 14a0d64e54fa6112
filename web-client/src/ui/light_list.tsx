// The lights of the document, and who has selected which.

import { useEffect, useRef } from "preact/hooks";

import { lightLabel } from "../core/document";
import type { DocumentLight } from "../core/protocol";
import { Icon } from "./icons";
import { isFree, isMuted, toggleMute, toggleSolo } from "./light_actions";
import { focusBeside } from "./list_focus";
import { Name } from "./name";
import { addLight } from "./new_lights";
import { canEdit, holderOf, selectLight, usePage } from "./page";
import { colorOf } from "./person";
import { QuietButton } from "./quiet_button";
import { removeLight } from "./removing";

/** Lights that can be added, bent ones first. */
const ADDED = [
  { type: "bendy", title: "Add a BendyLight" },
  { type: "spot", title: "Add a spotlight" },
  { type: "omni", title: "Add an omni light" },
  { type: "directional", title: "Add a directional light" },
] as const;

export function LightList() {
  const page = usePage();
  const { lights } = page.session.document.value;
  const disabled = !canEdit(page);
  return (
    <section class="panel" aria-label="Lights">
      <header class="panel-head">
        <h2>Lights</h2>
        <Icon name="plus" />
        {ADDED.map(({ type, title }) => (
          <QuietButton key={type} title={title} disabled={disabled} press={() => void addLight(page, type)}>
            <Icon name={type} />
          </QuietButton>
        ))}
      </header>
      <ul class="list">
        {lights.map((entry) => (
          <LightRow key={entry.id} entry={entry} disabled={disabled} />
        ))}
        {lights.length === 0 && <li class="empty">No lights. Add one above.</li>}
      </ul>
    </section>
  );
}

function LightRow({ entry, disabled }: { entry: DocumentLight; disabled: boolean }) {
  const page = usePage();
  const { session, selectedLight } = page;
  const { id, light } = entry;
  const others = session.people.value.filter((p) => p.selection === id && p.client !== session.client.value);
  const held = holderOf(page, id) !== null;
  const selected = selectedLight.value === id;
  const { shownSettings, following } = session.viewer;
  const name = lightLabel(entry);
  const alone = session.document.value.lights.filter((other) => shownSettings.value.solo.includes(other.id));
  const soloed = alone.some((other) => other.id === id);
  const muted = isMuted(light);
  const row = useRef<HTMLLIElement>(null);
  useEffect(() => {
    if (selected) row.current?.scrollIntoView({ block: "nearest" });
  }, [selected]);
  return (
    <li
      class="item"
      ref={row}
      data-light={id}
      data-dark={muted || (alone.length > 0 && !soloed)}
      aria-current={selected}
    >
      <button class="item-name" onClick={() => selectLight(page, id)}>
        <Icon name={light.type} />
        <Name name={name} />
      </button>
      {others.map(({ client, actor }) => (
        <span
          key={client}
          class="dot"
          style={{ background: colorOf(client) }}
          role="img"
          aria-label={`${actor.name} has selected this`}
          title={`${actor.name} has selected this`}
        />
      ))}
      {held && <Icon name="lock" />}
      <QuietButton
        class="switch mute"
        title={
          muted ? "Switch this light on again, for everybody (M)" : "Switch this light off, for everybody (M)"
        }
        label={`Mute ${name}`}
        pressed={muted}
        disabled={!isFree(page, id)}
        press={() => toggleMute(page, id)}
      >
        M
      </QuietButton>
      <QuietButton
        class="switch solo"
        title={
          following.value === null ? "See this light alone; others see all (S)" : "As whom you follow has it"
        }
        label={`Solo ${name}`}
        pressed={soloed}
        disabled={following.value !== null}
        press={() => toggleSolo(page, id)}
      >
        S
      </QuietButton>
      <QuietButton
        class="item-action"
        title="Remove this light"
        label={`Remove ${name}`}
        disabled={disabled || held}
        press={(button) => {
          removeLight(page, id, () => focusBeside(button));
        }}
      >
        <Icon name="trash" />
      </QuietButton>
    </li>
  );
}
