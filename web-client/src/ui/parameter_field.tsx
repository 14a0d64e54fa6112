// A field for any parameter, by its kind.

import { useRef } from "preact/hooks";

import { type LinksValue, textOfLinks } from "../core/links";
import type { Knot, PeriodicCurve } from "../core/periodic_curve";
import type { Kind, NumberKind } from "../core/parameters";
import type { Parameter } from "../core/protocol";
import { clampTo, firstValue, isSameValue, sliderEnds, stepTo } from "../core/parameters";
import { fromEulerDegrees, type Quat, toEulerDegrees, type Vec3 } from "../core/vector";
import { type Binding, through } from "./binding";
import { CurveField } from "./curve_field";
import { ColorField } from "./color_field";
import { Checkbox, Choice, type FieldProps, TextField, VectorField } from "./fields";
import { formatNumber } from "./format";
import { LinksField } from "./links_field";
import { Row, type RowProps } from "./row";
import { Slider } from "./slider";

/** Degrees that one arrow key and one pixel of a scrub turn a light. */
const TURN_STEP = 0.5;

interface ParameterFieldProps {
  row: Parameter;
  /** Value in the JSON of its owner. */
  value: unknown;
  /** Default of the owner; `undefined` for none. */
  initial: unknown;
  /** Values of the same kind that its slider has room for, such as those of the other control points. */
  among?: readonly unknown[];
  binding: Binding<unknown>;
  disabled: boolean;
}

/** The table says that a value is of its row's kind: here that becomes its type. */
export function ParameterField({ row, value, initial, among, binding, disabled }: ParameterFieldProps) {
  const { kind, label } = row;
  const unit = "unit" in kind ? kind.unit : undefined;
  const common: RowProps = { label, doc: withUnit(row.doc, unit), disabled };
  if (isResettable(kind) && initial !== undefined && !isSameValue(value, initial)) {
    common.reset = { to: textOf(kind, initial), run: () => binding.set(initial) };
  }
  // Neither in the light nor in the table: there is nothing to show, or to start from.
  if (value === undefined) return null;
  function props<V>(): FieldProps<V> {
    return { ...common, value: value as V, binding: binding as Binding<V> };
  }
  switch (kind.type) {
    case "number":
      return kind.none !== undefined ? (
        <OptionalNumber kind={kind} {...props<number | null>()} />
      ) : (
        <NumberSlider kind={kind} among={(among ?? [value]) as number[]} {...props<number>()} />
      );
    case "flag":
      return <Checkbox {...props<boolean>()} />;
    case "choice":
      return <Choice choices={kind.choices} {...props<string>()} />;
    case "color":
      return <ColorField {...props<Vec3>()} />;
    case "vector":
      return <VectorField step={kind.step} {...props<Vec3>()} />;
    case "rotation": {
      const { value, binding } = props<Quat>();
      return (
        <VectorField
          {...common}
          value={toEulerDegrees(value)}
          binding={through(binding, fromEulerDegrees)}
          step={TURN_STEP}
        />
      );
    }
    case "text":
      return (
        <Row {...common}>
          <TextField {...props<string>()} set={binding.set} maxLength={kind.maxBytes} />
        </Row>
      );
    case "links":
      return <LinksField row={row} {...props<LinksValue>()} />;
    case "periodicCurve":
      return <CurveField kind={kind} {...props<PeriodicCurve>()} />;
    case "projection":
      // A camera's; it is set by looking from there.
      return null;
  }
}

interface NumberSliderProps extends FieldProps<number> {
  kind: NumberKind;
  among: readonly number[];
}

function NumberSlider({ kind, among, ...props }: NumberSliderProps) {
  const [from, to] = sliderEnds(kind, among);
  return (
    <Slider
      {...props}
      from={from}
      to={to}
      step={kind.step}
      unit={SIGNS[kind.unit ?? ""]}
      countsIn={kind.unit}
      clamp={(value) => clampTo(kind, value)}
      stepTo={(from, wanted) => stepTo(kind, from, wanted)}
      logarithmic={kind.scale === "logarithmic" && from > 0}
    />
  );
}

/** A box for no number at all, and below it the slider for one. */
function OptionalNumber({ kind, ...props }: FieldProps<number | null> & { kind: NumberKind }) {
  const { label, value, binding } = props;
  const latest = useRef(firstValue(kind));
  if (value !== null) latest.current = value;
  return (
    <>
      <Checkbox
        {...props}
        label={kind.none ?? `No ${label.toLowerCase()}`}
        reset={value === null ? props.reset : undefined}
        value={value === null}
        binding={through(binding, (isNone: boolean) => (isNone ? null : latest.current))}
      />
      {value !== null && (
        <NumberSlider
          {...props}
          kind={kind}
          among={[value]}
          value={value}
          binding={binding as Binding<number>}
        />
      )}
    </>
  );
}

/** Signs that have room beside a number; other units are said with what it is. */
const SIGNS: { [unit: string]: string } = {
  degrees: "°",
  "°": "°",
  "%": "%",
  stops: " stops",
  kelvin: " K",
  K: " K",
};

const withUnit = (doc: string, unit = ""): string =>
  unit === "" || unit in SIGNS ? doc : `${doc} In ${unit}.`;

/** Nobody wants a name or a lens from nowhere back. */
const isResettable = ({ type }: Kind): boolean => type !== "text" && type !== "projection";

/** A value of the kind as people read it. */
function textOf(kind: Kind, value: unknown): string {
  const numbers = (values: readonly number[]) => values.map((v) => formatNumber(v, 3)).join(", ");
  switch (kind.type) {
    case "number":
      if (value === null) return (kind.none ?? "none").toLowerCase();
      return `${formatNumber(value as number, 3)}${SIGNS[kind.unit ?? ""] ?? ""}`;
    case "flag":
      return value === true ? "on" : "off";
    case "choice":
      return kind.choices.find(({ name }) => name === value)?.label ?? String(value);
    case "color":
    case "vector":
      return numbers(value as Vec3);
    case "rotation":
      return numbers(toEulerDegrees(value as Quat));
    case "links":
      return textOfLinks(value as LinksValue);
    case "periodicCurve":
      return value === null ? kind.none.toLowerCase() : `${(value as readonly Knot[]).length} knots`;
    case "text":
    case "projection":
      return String(value);
  }
}
