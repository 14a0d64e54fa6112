// The lights of the document, and who has selected which.

import { useEffect, useRef } from "preact/hooks";

import { lightLabel } from "../core/document";
import type { DocumentLight } from "../core/protocol";
import { Icon } from "./icons";
import { focusBeside } from "./list_focus";
import { addLight } from "./new_lights";
import { canEdit, selectLight, usePage } from "./page";
import { colorOf } from "./person";
import { QuietButton } from "./quiet_button";

export function LightList() {
  const page = usePage();
  const { lights } = page.session.document.value;
  const disabled = !canEdit(page);
  return (
    <section class="panel" aria-label="Lights">
      <header class="panel-head">
        <h2>Lights</h2>
        <QuietButton title="Add a BendyLight" disabled={disabled} press={() => addLight(page, "bendy")}>
          <Icon name="plus" />
          <Icon name="bendy" />
        </QuietButton>
        <QuietButton title="Add a spotlight" disabled={disabled} press={() => addLight(page, "spot")}>
          <Icon name="plus" />
          <Icon name="spot" />
        </QuietButton>
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
  const held = session.gestures.value.some((gesture) => gesture.light === id);
  const selected = selectedLight.value === id;
  const row = useRef<HTMLLIElement>(null);
  useEffect(() => {
    if (selected) row.current?.scrollIntoView({ block: "nearest" });
  }, [selected]);
  return (
    <li class="item" ref={row} data-light={id} aria-current={selected}>
      <button class="item-name" onClick={() => selectLight(page, id)}>
        <Icon name={light.type} />
        <span class="clipped">{lightLabel(entry)}</span>
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
        class="item-action"
        title="Remove this light"
        label={`Remove ${lightLabel(entry)}`}
        disabled={disabled || held}
        press={(button) => {
          focusBeside(button);
          session.edit({ type: "removeLight", light: id });
        }}
      >
        <Icon name="trash" />
      </QuietButton>
    </li>
  );
}
