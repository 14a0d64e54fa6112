// The lights of the document, and who has selected which.

import { useEffect, useRef } from "preact/hooks";

import { lightLabel } from "../core/document";
import type { DocumentLight } from "../core/protocol";
import { Icon } from "./icons";
import { addLight } from "./new_lights";
import { canEdit, selectLight, usePage } from "./page";
import { colorOf } from "./person";

export function LightList() {
  const page = usePage();
  const { lights } = page.session.document.value;
  const disabled = !canEdit(page);
  return (
    <section class="panel" aria-label="Lights">
      <header class="panel-head">
        <h2>Lights</h2>
        <button
          class="quiet"
          title="Add a BendyLight"
          aria-label="Add a BendyLight"
          disabled={disabled}
          onClick={() => addLight(page, "bendy")}
        >
          <Icon name="plus" />
          <Icon name="bendy" />
        </button>
        <button
          class="quiet"
          title="Add a spotlight"
          aria-label="Add a spotlight"
          disabled={disabled}
          onClick={() => addLight(page, "spot")}
        >
          <Icon name="plus" />
          <Icon name="spot" />
        </button>
      </header>
      <ul class="list">
        {lights.map((placed) => (
          <LightRow key={placed.id} placed={placed} disabled={disabled} />
        ))}
        {lights.length === 0 && <li class="empty">No lights. Add one above.</li>}
      </ul>
    </section>
  );
}

function LightRow({ placed, disabled }: { placed: DocumentLight; disabled: boolean }) {
  const page = usePage();
  const { session, selectedLight } = page;
  const { id, light } = placed;
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
        <span class="clipped">{lightLabel(placed)}</span>
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
      <button
        class="quiet item-action"
        title="Remove this light"
        aria-label={`Remove ${lightLabel(placed)}`}
        disabled={disabled || held}
        onClick={() => session.edit({ type: "removeLight", light: id })}
      >
        <Icon name="trash" />
      </button>
    </li>
  );
}
