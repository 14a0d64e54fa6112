// Every parameter of the selected light.

import { lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import { type Section, sectionsOf, setParameter, valueIn } from "../core/parameters";
import type { Light } from "../core/protocol";
import { lightBinding } from "./binding";
import { Icon } from "./icons";
import { canEdit, usePage } from "./page";
import { ParameterField } from "./parameter_field";
import { nameOf } from "./person";
import { PointPanel } from "./point_panel";

const HEADINGS: { [T in Light["type"]]: string } = { bendy: "BendyLight", spot: "Spotlight" };

export function LightPanel() {
  const page = usePage();
  const { session, selectedLight } = page;
  const id = selectedLight.value;
  const light = lightOf(session.document.value, id);
  if (id === null || light === undefined) {
    return <p class="hint">Select a light to see its parameters.</p>;
  }
  const holder = session.gestures.value.find((gesture) => gesture.light === id)?.client;
  const disabled = !canEdit(page) || holder !== undefined;
  return (
    // Another light is another panel: drafts and drags of the one must not end up in the other.
    <div key={id}>
      {holder !== undefined && (
        <p class="held">
          <Icon name="lock" /> {nameOf(session.people.value, holder)} is dragging this light.
        </p>
      )}
      {sectionsOf(session.table, light.type).map((section, k) => (
        <LightSection
          key={section.group}
          section={section}
          heading={k === 0 ? HEADINGS[light.type] : section.group}
          id={id}
          light={light}
          disabled={disabled}
        />
      ))}
      {light.type === "bendy" && <PointPanel id={id} light={light} disabled={disabled} />}
    </div>
  );
}

interface LightSectionProps {
  section: Section;
  heading: string;
  id: LightId;
  light: Light;
  disabled: boolean;
}

function LightSection({ section: { group, rows }, heading, id, light, disabled }: LightSectionProps) {
  const { session } = usePage();
  return (
    <section class="panel" aria-label={group}>
      <header class="panel-head">
        <h2>{heading}</h2>
      </header>
      {rows.map((row) => (
        <ParameterField
          key={row.name}
          row={row}
          value={valueIn(row, light.type, light)}
          initial={row.default[light.type]}
          binding={lightBinding(session, id, (value) => setParameter(id, row, value))}
          disabled={disabled}
        />
      ))}
    </section>
  );
}
