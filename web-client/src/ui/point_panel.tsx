// The control points of the selected BendyLight, one at a time.

import { isRemovable } from "../core/curve";
import type { LightId } from "../core/ids";
import { rowsOf, setParameter, valueIn } from "../core/parameters";
import type { Bendy } from "../core/protocol";
import { lightBinding } from "./binding";
import { Checkbox } from "./fields";
import { Icon } from "./icons";
import { usePage } from "./page";
import { ParameterField } from "./parameter_field";
import { QuietButton } from "./quiet_button";
import { FoldingSection } from "./sections";

interface PointPanelProps {
  id: LightId;
  light: Bendy;
  disabled: boolean;
}

export function PointPanel({ id, light, disabled }: PointPanelProps) {
  const { session, selectedPoint } = usePage();
  const selected = selectedPoint.value;
  const insert = (point: number) => {
    session.edit({ type: "insertPoint", light: id, point }, () => (selectedPoint.value = point));
  };
  return (
    <FoldingSection
      group="Control points"
      heading="Control points"
      openAtFirst
      tools={
        <>
          <QuietButton
            title={
              selected === null ? "Add a control point at the end" : "Insert a control point after this one"
            }
            label="Insert control point"
            disabled={disabled}
            press={() => insert(selected === null ? light.points.length : selected + 1)}
          >
            <Icon name="plus" />
          </QuietButton>
          <QuietButton
            title="Remove this control point"
            label="Remove control point"
            disabled={disabled || selected === null || !isRemovable(light.points.length, selected)}
            press={() =>
              selected !== null && session.edit({ type: "removePoint", light: id, point: selected })
            }
          >
            <Icon name="minus" />
          </QuietButton>
        </>
      }
    >
      <div class="tabs" role="group" aria-label="Control point">
        {light.points.map((_, point) => (
          <button
            // biome-ignore lint/suspicious/noArrayIndexKey: a control point is known by its index
            key={point}
            class="tab"
            aria-pressed={selected === point}
            title={point === 0 ? "The source" : `Control point ${point}`}
            onClick={() => (selectedPoint.value = selected === point ? null : point)}
          >
            {point}
          </button>
        ))}
      </div>
      {selected === null || selected >= light.points.length ? (
        <p class="hint">Select a control point here or in the picture.</p>
      ) : (
        <PointFields key={selected} id={id} light={light} point={selected} disabled={disabled} />
      )}
      <RadiiFollow disabled={disabled} />
    </FoldingSection>
  );
}

/** This page's own choice, which its next drags keep to. */
function RadiiFollow({ disabled }: { disabled: boolean }) {
  const { radiiFollow } = usePage();
  const set = (follow: boolean) => (radiiFollow.value = follow);
  return (
    <Checkbox
      label="Radii follow"
      doc="Where a control point is dragged farther than the tube can bend, the tube becomes thinner instead of stopping it."
      value={radiiFollow.value}
      binding={{ set, drag: () => ({ update: set, commit() {}, cancel() {} }) }}
      disabled={disabled}
    />
  );
}

function PointFields({ id, light, point, disabled }: PointPanelProps & { point: number }) {
  const { session } = usePage();
  // The first control point is the light's source: it moves with the light.
  const rows = rowsOf(session.table, "point").filter(({ name }) => point > 0 || name !== "position");
  return (
    <>
      {rows.map((row) => (
        <ParameterField
          key={row.name}
          row={row}
          value={valueIn(row, "point", light, point)}
          initial={row.default.point}
          among={light.points.map((_, other) => valueIn(row, "point", light, other))}
          binding={lightBinding(session, id, (value) => setParameter(id, row, value, point))}
          disabled={disabled}
        />
      ))}
    </>
  );
}
