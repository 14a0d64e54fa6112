// Every parameter of the selected light.

import { lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import type { Bendy, Decay, Light, LightParameter, Spot } from "../core/protocol";
import { fromEulerDegrees, type Quat, toEulerDegrees, type Vec3 } from "../core/vector";
import { Choice, ColorField, Row, Slider, TextField, VectorField } from "./fields";
import { Icon } from "./icons";
import { canEdit, usePage } from "./page";
import { nameOf } from "./person";
import { PointPanel } from "./point_panel";
import { lightTarget, type Target, through } from "./target";

const DECAYS: { [D in Decay]: string } = { none: "None", linear: "Linear", inverseSquare: "Inverse square" };
const FRAMES = { rotationMinimizing: "Rotation minimizing", up: "Up" } as const;
const DIRECTIONS = { tube: "Tube (continuous)", path: "Path (exact)" } as const;
const END_MODES = { cut: "Cut at the last point", extend: "Extend straight on" } as const;

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
      <Placement id={id} light={light} disabled={disabled} />
      <Shape id={id} light={light} disabled={disabled} />
      {light.type === "bendy" && <PointPanel id={id} light={light} disabled={disabled} />}
    </div>
  );
}

export interface PartProps<L extends Light = Light> {
  id: LightId;
  light: L;
  disabled: boolean;
}

/** The target for one parameter of a light. */
function useParameter(id: LightId): <V>(make: (value: V) => LightParameter) => Target<V> {
  const { session } = usePage();
  return (make) =>
    lightTarget(session, id, (value) => ({ type: "setLight", light: id, parameter: make(value) }));
}

function Placement({ id, light, disabled }: PartProps) {
  const { session } = usePage();
  const { translation, rotation, scale } = light.transform;
  const moves = lightTarget(session, id, (to: Vec3) => ({ type: "placeLight", light: id, translation: to }));
  const turns = lightTarget(session, id, (to: Quat) => ({ type: "placeLight", light: id, rotation: to }));
  const scales = lightTarget(session, id, (to: number) => ({ type: "placeLight", light: id, scale: to }));
  const rename = (name: string) => session.edit({ type: "setLight", light: id, parameter: { name } });
  return (
    <section class="panel" aria-label="Light">
      <header class="panel-head">
        <h2>{light.type === "bendy" ? "BendyLight" : "Spotlight"}</h2>
      </header>
      <Row label="Name">
        <TextField label="Name" value={light.name} set={rename} disabled={disabled} />
      </Row>
      <VectorField label="Position" value={translation} target={moves} disabled={disabled} step={0.01} />
      <VectorField
        label="Rotation"
        value={toEulerDegrees(rotation)}
        target={through(turns, fromEulerDegrees)}
        disabled={disabled}
        step={0.5}
      />
      <Slider
        label="Scale"
        value={scale}
        from={0.1}
        to={3}
        min={1e-6}
        step={0.01}
        target={scales}
        disabled={disabled}
      />
    </section>
  );
}

function Shape({ id, light, disabled }: PartProps) {
  const parameter = useParameter(id);
  return (
    <section class="panel" aria-label="Shape">
      <header class="panel-head">
        <h2>Shape</h2>
      </header>
      {light.type === "spot" && <SpotOnly id={id} light={light} disabled={disabled} />}
      <Slider
        label="Cone angle"
        value={light.coneAngle}
        from={1}
        to={89}
        min={0.1}
        max={89.9}
        step={0.5}
        unit="°"
        target={parameter((coneAngle: number) => ({ coneAngle }))}
        disabled={disabled}
      />
      <Slider
        label="Softness"
        value={light.coneSoftness}
        from={0}
        to={1}
        min={0}
        max={1}
        step={0.01}
        target={parameter((coneSoftness: number) => ({ coneSoftness }))}
        disabled={disabled}
      />
      <Choice
        label="Decay"
        value={light.decay}
        options={DECAYS}
        target={parameter((decay: Decay) => ({ decay }))}
        disabled={disabled}
      />
      {light.type === "bendy" && <BendyOnly id={id} light={light} disabled={disabled} />}
    </section>
  );
}

function SpotOnly({ id, light, disabled }: PartProps<Spot>) {
  const parameter = useParameter(id);
  const range = parameter((to: number | null) => ({ range: to }));
  return (
    <>
      <ColorField
        label="Color"
        value={light.color}
        target={parameter((color: Vec3) => ({ color }))}
        disabled={disabled}
      />
      <Slider
        label="Intensity"
        value={light.intensity}
        from={0}
        to={20}
        min={0}
        step={0.05}
        target={parameter((intensity: number) => ({ intensity }))}
        disabled={disabled}
      />
      <Row label="Endless">
        <input
          type="checkbox"
          aria-label="Endless"
          disabled={disabled}
          checked={light.range === undefined}
          onChange={(event) => range.set(event.currentTarget.checked ? null : 5)}
        />
      </Row>
      {light.range !== undefined && (
        <Slider
          label="Range"
          value={light.range}
          from={0.1}
          to={20}
          min={1e-6}
          step={0.05}
          target={range}
          disabled={disabled}
        />
      )}
    </>
  );
}

function BendyOnly({ id, light, disabled }: PartProps<Bendy>) {
  const parameter = useParameter(id);
  return (
    <>
      <Choice
        label="End"
        value={light.endMode}
        options={END_MODES}
        target={parameter((endMode: Bendy["endMode"]) => ({ endMode }))}
        disabled={disabled}
      />
      <Choice
        label="Direction"
        value={light.direction}
        options={DIRECTIONS}
        target={parameter((direction: Bendy["direction"]) => ({ direction }))}
        disabled={disabled}
      />
      <Choice
        label="Frame"
        value={light.frame}
        options={FRAMES}
        target={parameter((frame: Bendy["frame"]) => ({ frame }))}
        disabled={disabled}
      />
      <VectorField
        label="Up"
        value={light.up}
        target={parameter((up: Vec3) => ({ up }))}
        disabled={disabled}
        step={0.01}
      />
    </>
  );
}
