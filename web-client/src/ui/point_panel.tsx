// The control points of the selected BendyLight, one at a time.

import type { Bendy, PointParameter } from "../core/protocol";
import type { Vec3 } from "../core/vector";
import { ColorField, Slider, VectorField } from "./fields";
import { Icon } from "./icons";
import type { PartProps } from "./light_panel";
import { usePage } from "./page";
import { lightTarget, type Target } from "./target";

/** The fewest control points that make a curve. */
const FEWEST_POINTS = 3;

/** Whether the curve can do without control point `point`. */
export const removablePoint = (light: Bendy, point: number): boolean =>
  point > 0 && light.points.length > FEWEST_POINTS;

export function PointPanel({ id, light, disabled }: PartProps<Bendy>) {
  const { session, selectedPoint } = usePage();
  const selected = selectedPoint.value;
  const insert = (point: number) => {
    session.edit({ type: "insertPoint", light: id, point }, () => (selectedPoint.value = point));
  };
  return (
    <section class="panel" aria-label="Control points">
      <header class="panel-head">
        <h2>Control points</h2>
        <button
          class="quiet"
          title={
            selected === null ? "Add a control point at the end" : "Insert a control point after this one"
          }
          aria-label="Insert control point"
          disabled={disabled}
          onClick={() => insert(selected === null ? light.points.length : selected + 1)}
        >
          <Icon name="plus" />
        </button>
        <button
          class="quiet"
          title="Remove this control point"
          aria-label="Remove control point"
          disabled={disabled || selected === null || !removablePoint(light, selected)}
          onClick={() =>
            selected !== null && session.edit({ type: "removePoint", light: id, point: selected })
          }
        >
          <Icon name="minus" />
        </button>
      </header>
      <div class="tabs" role="group" aria-label="Control point">
        {light.points.map((_, point) => (
          <button
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
    </section>
  );
}

function PointFields({ id, light, point, disabled }: PartProps<Bendy> & { point: number }) {
  const { session } = usePage();
  function parameter<V>(make: (value: V) => PointParameter): Target<V> {
    return lightTarget(session, id, (value: V) => ({
      type: "setPoint",
      light: id,
      point,
      parameter: make(value),
    }));
  }
  return (
    <>
      {point > 0 && (
        <VectorField
          label="Position"
          value={light.points[point] ?? [0, 0, 0]}
          target={parameter((position: Vec3) => ({ position }))}
          disabled={disabled}
          step={0.01}
        />
      )}
      <Slider
        label="Radius"
        value={light.radii[point] ?? 0}
        from={0}
        to={2 * Math.max(...light.radii)}
        min={0}
        step={0.01}
        target={parameter((radius: number) => ({ radius }))}
        disabled={disabled}
      />
      <Slider
        label="Intensity"
        value={light.intensities[point] ?? 0}
        from={0}
        to={10}
        min={0}
        step={0.05}
        target={parameter((intensity: number) => ({ intensity }))}
        disabled={disabled}
      />
      <ColorField
        label="Color"
        value={light.colors[point] ?? [1, 1, 1]}
        target={parameter((color: Vec3) => ({ color }))}
        disabled={disabled}
      />
    </>
  );
}
