// A number over an angle: its knots, and a picture of what comes of them.

import {
  clampDegrees,
  type Knot,
  outlineOf,
  type PeriodicCurve,
  without,
  withOneMore,
} from "../core/periodic_curve";
import type { Kind } from "../core/parameters";
import { through } from "./binding";
import { type FieldProps, NumberField } from "./fields";
import { Icon } from "./icons";
import { QuietButton } from "./quiet_button";
import { Row } from "./row";

export type CurveKind = Extract<Kind, { type: "periodicCurve" }>;

/** Degrees that one arrow key and one pixel of a scrub turn a knot. */
const TURN_STEP = 1;
/** Points of the picture, one for every two degrees. */
const STEPS = 180;

/** A line for each knot, and a button for one more. */
export function CurveField({ kind, ...props }: FieldProps<PeriodicCurve> & { kind: CurveKind }) {
  const { label, doc, value, binding, disabled } = props;
  const knots = value ?? [];
  const isFull = knots.length >= kind.maxKnots;
  const clampValue = (number: number) => Math.min(Math.max(number, kind.min), kind.max);
  const withKnot = (index: number, knot: Knot): PeriodicCurve => knots.with(index, knot);
  return (
    <Row {...props}>
      <div class="curve">
        {knots.map(([degrees, number], index) => {
          const name = `${label} ${index + 1}`;
          return (
            // biome-ignore lint/suspicious/noArrayIndexKey: a knot is what it is by its place in the list
            <div class="knot" key={index}>
              <NumberField
                tag="∠"
                label={`${name}: degrees`}
                doc={doc}
                value={degrees}
                binding={through(binding, (at: number) => withKnot(index, [at, number]))}
                clamp={(at) => clampDegrees(knots, index, at)}
                step={TURN_STEP}
                unit="°"
                disabled={disabled}
              />
              <NumberField
                tag="↔"
                label={`${name}: value`}
                doc={doc}
                value={number}
                binding={through(binding, (to: number) => withKnot(index, [degrees, to]))}
                clamp={clampValue}
                step={kind.step}
                disabled={disabled}
              />
              <QuietButton
                title={`Take ${name} out`}
                disabled={disabled}
                press={() => binding.set(without(knots, index))}
              >
                <Icon name="close" />
              </QuietButton>
            </div>
          );
        })}
        <div class="curve-foot">
          <QuietButton
            title={isFull ? `${label} has at most ${kind.maxKnots} knots` : `Add a knot to ${label}`}
            disabled={disabled || isFull}
            press={() => binding.set(withOneMore(value, kind.max))}
          >
            <Icon name="plus" />
          </QuietButton>
          {knots.length === 0 ? (
            <span class="curve-none">{kind.none}</span>
          ) : (
            <Outline knots={knots} max={kind.max} />
          )}
        </div>
      </div>
    </Row>
  );
}

/** Outline that the knots make of a circle, as seen along the light. */
function Outline({ knots, max }: { knots: readonly Knot[]; max: number }) {
  const points = outlineOf(knots, STEPS).map((point) => point.map((x) => (x / max).toFixed(3)).join(","));
  return (
    <svg class="curve-outline" viewBox="-1.1 -1.1 2.2 2.2" aria-hidden="true">
      <circle r="1" />
      <polygon points={points.join(" ")} />
    </svg>
  );
}
