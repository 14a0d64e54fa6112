// Every parameter of the selected light.

import { Fragment } from "preact";

import { lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import { hasEffect, type Section, sectionsOf, setParameter, valueIn } from "../core/parameters";
import type { Light, ParameterTable } from "../core/protocol";
import { lightBinding } from "./binding";
import { toggleAiming, toggleLookThrough } from "./directing";
import { Icon } from "./icons";
import { bendLight, duplicateLight, hasCone, straightenLight } from "./light_actions";
import { canEdit, holderOf, usePage } from "./page";
import { ParameterField } from "./parameter_field";
import { nameOf } from "./person";
import { PinPanel } from "./pin_panel";
import { PointPanel } from "./point_panel";
import { QuietButton } from "./quiet_button";
import { removeLight } from "./removing";
import { FoldingSection } from "./sections";

const HEADINGS: { [T in Light["type"]]: string } = {
  bendy: "BendyLight",
  spot: "Spotlight",
  omni: "Omni light",
  directional: "Directional light",
};

/** Sections that are open before anybody has opened or closed one: the table begins with what is used most. */
const OPEN_AT_FIRST = 4;

export function LightPanel() {
  const page = usePage();
  const { session, selectedLight } = page;
  const id = selectedLight.value;
  const light = lightOf(session.document.value, id);
  if (id === null || light === undefined) {
    return <p class="hint">Select a light to see its parameters.</p>;
  }
  const holder = holderOf(page, id);
  const disabled = !canEdit(page) || holder !== null;
  return (
    // Another light is another panel: drafts and drags of the one must not end up in the other.
    <div key={id}>
      {holder !== null && (
        <p class="held">
          <Icon name="lock" /> {nameOf(session.people.value, holder)} is dragging this light.
        </p>
      )}
      <LightTools id={id} light={light} disabled={disabled} />
      {shownSections(session.table, light).map((section, k) => (
        <Fragment key={section.group}>
          <FoldingSection
            group={section.group}
            heading={k === 0 ? HEADINGS[light.type] : section.group}
            openAtFirst={k < OPEN_AT_FIRST}
          >
            <SectionFields section={section} id={id} light={light} disabled={disabled} />
          </FoldingSection>
          {/* The controls that bend it are used most, and stay visible. */}
          {k === 0 && light.type === "bendy" && <PointPanel id={id} light={light} disabled={disabled} />}
          {k === 0 && <PinPanel id={id} />}
        </Fragment>
      ))}
    </div>
  );
}

/** The fields that do something for the light as it is. */
function shownSections(table: ParameterTable, light: Light): Section[] {
  return sectionsOf(table, light.type).flatMap(({ group, rows }) => {
    const shown = rows.filter((row) => hasEffect(table, light.type, row, light));
    return shown.length === 0 ? [] : [{ group, rows: shown }];
  });
}

/** Buttons for the light as a whole. */
function LightTools({ id, light, disabled }: { id: LightId; light: Light; disabled: boolean }) {
  const page = usePage();
  return (
    <div class="light-tools" role="toolbar" aria-label="Light">
      {light.type === "bendy" ? (
        <QuietButton
          title="Straighten this light: a spotlight from its source to its last control point"
          label="Straighten this light"
          disabled={disabled}
          press={() => straightenLight(page, id)}
        >
          <Icon name="spot" /> Straighten
        </QuietButton>
      ) : (
        <QuietButton
          title={
            hasCone(light)
              ? "Bend this light: control points to where it shines"
              : "Bend this light: control points in a cone towards what is in the middle of your view"
          }
          label="Bend this light"
          disabled={disabled}
          press={() => void bendLight(page, id)}
        >
          <Icon name="bendy" /> Bend
        </QuietButton>
      )}
      {light.type !== "omni" && (
        <QuietButton
          title="Turn this light to what is clicked next in the picture (T)"
          label="Aim this light"
          pressed={page.aiming.value !== "off"}
          disabled={disabled}
          press={() => toggleAiming(page)}
        >
          <Icon name="aim" /> Aim
        </QuietButton>
      )}
      <QuietButton
        title="Look from where this light stands to where it shines, and back (L)"
        label="Look through this light"
        pressed={page.excursion.value?.light === id}
        press={() => toggleLookThrough(page)}
      >
        <Icon name="view" /> Through
      </QuietButton>
      <QuietButton
        title="Duplicate this light (D)"
        label="Duplicate this light"
        disabled={disabled}
        press={() => duplicateLight(page, id)}
      >
        <Icon name="copy" /> Duplicate
      </QuietButton>
      <QuietButton
        title="Remove this light"
        disabled={disabled}
        press={() => removeLight(page, id, () => {})}
      >
        <Icon name="trash" /> Remove
      </QuietButton>
    </div>
  );
}

interface SectionFieldsProps {
  section: Section;
  id: LightId;
  light: Light;
  disabled: boolean;
}

function SectionFields({ section: { rows }, id, light, disabled }: SectionFieldsProps) {
  const { session } = usePage();
  return (
    <>
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
    </>
  );
}
