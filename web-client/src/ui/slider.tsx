// A slider with its number.

import { useRef } from "preact/hooks";

import { useLooseDrag } from "./binding";
import { NumberField, type NumberProps } from "./fields";
import { formatNumber } from "./format";
import { usePage } from "./page";
import { Row } from "./row";

interface SliderProps extends NumberProps {
  /** Ends of the slider; the number beside it may go on. */
  from: number;
  to: number;
  /** True if equal distances are equal factors; both ends are above 0 then. */
  logarithmic?: boolean;
}

/** Steps from end to end where equal ways are equal factors. */
const LOGARITHMIC_STEPS = 1000;

/** Map between a number and its position along a slider. */
interface Track {
  step: number;
  positionOf(value: number): number;
  valueAt(position: number): number;
}

const linear = (step: number): Track => ({ step: step / 10, positionOf: (v) => v, valueAt: (p) => p });

function logarithmic(from: number, to: number): Track {
  return {
    step: Math.log(to / from) / LOGARITHMIC_STEPS,
    positionOf: (value) => Math.log(Math.max(value, from)),
    valueAt: (position) => Number(Math.exp(position).toPrecision(3)),
  };
}

export function Slider({ from, to, ...props }: SliderProps) {
  const { label, doc, value, binding, disabled, step, unit = "", decimals = 3 } = props;
  const { presses } = usePage();
  const drag = useLooseDrag(binding);
  /** Input that moves it: none after Escape, or once the browser uses the touch to scroll. */
  const movedBy = useRef<"pointer" | "keys" | "nothing">("pointer");
  const rest = useRef({ from, to, value });
  const dragging = useRef(false);
  // The ends stay where they are under the hand, and make room for the value at rest.
  if (!dragging.current) {
    const least = props.logarithmic && value <= 0 ? from : Math.min(from, value);
    rest.current = { from: least, to: Math.max(to, value), value };
  }
  const ends = rest.current;
  const track = props.logarithmic ? logarithmic(ends.from, ends.to) : linear(step);
  const [first, last, position] = [
    track.positionOf(ends.from),
    track.positionOf(ends.to),
    track.positionOf(value),
  ];
  const cancel = (input: HTMLInputElement) => {
    movedBy.current = "nothing";
    dragging.current = false;
    presses.cancel();
    drag.cancel();
    input.value = String(track.positionOf(rest.current.value));
  };
  const share = (position - first) / Math.max(last - first, 1e-9);
  return (
    <Row {...props}>
      <input
        type="range"
        aria-label={`${label} slider`}
        aria-valuetext={`${formatNumber(value, decimals)}${unit}`}
        title={doc}
        disabled={disabled}
        min={first}
        max={last}
        step={track.step}
        value={position}
        style={{ "--share": String(Math.min(Math.max(share, 0), 1)) }}
        onInput={(event) => {
          const input = event.currentTarget;
          const wanted = track.valueAt(Number(input.value));
          if (movedBy.current === "keys") {
            presses.press(input, value, () => wanted, binding.drag);
          } else if (movedBy.current === "pointer") {
            dragging.current = true;
            drag.update(wanted);
          } else {
            input.value = String(position);
          }
        }}
        onChange={() => {
          dragging.current = false;
          drag.commit();
        }}
        onPointerDown={() => (movedBy.current = "pointer")}
        onPointerCancel={(event) => cancel(event.currentTarget)}
        onKeyDown={(event) => {
          movedBy.current = "keys";
          if (event.key === "Enter") presses.commit();
          if (event.key === "Escape") cancel(event.currentTarget);
        }}
        onBlur={presses.commit}
      />
      <NumberField {...props} />
    </Row>
  );
}
