// The controls that panels are made of. A value arrives as a property and leaves through its target.

import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import type { Vec3 } from "../core/vector";
import { usePage } from "./page";
import { followPointer } from "./pointer";
import { stepsOf } from "./presses";
import { type Target, through, useLooseDrag, type ValueDrag } from "./target";

interface FieldProps<V> {
  label: string;
  value: V;
  target: Target<V>;
  disabled: boolean;
}

interface NumberProps extends FieldProps<number> {
  min?: number;
  max?: number;
  /** What one arrow key and one pixel of a scrub change it by. */
  step: number;
  unit?: string;
  /** How exactly it is shown. */
  decimals?: number;
}

/** A row: what it is, and the control for it. */
export function Row({ label, children }: { label: string; children: ComponentChildren }) {
  return (
    <div class="row">
      <span class="row-label">{label}</span>
      <div class="row-control">{children}</div>
    </div>
  );
}

/** A number as people read it: at most `decimals`, and fewer the larger it is. */
export function formatNumber(value: number, decimals: number): string {
  const spare = Math.floor(Math.log10(Math.max(Math.abs(value), 1)));
  return String(Number(value.toFixed(Math.max(0, decimals - spare))));
}

const clamp = (value: number, { min = -Infinity, max = Infinity }: { min?: number; max?: number }) =>
  Math.min(Math.max(value, min), max);

/** A number to type, to step by arrow keys and, where it has a tag, to scrub by dragging that. */
export function NumberField({ tag, ...props }: NumberProps & { tag?: string }) {
  const { label, value, target, disabled, step, unit, decimals = 3 } = props;
  const { presses } = usePage();
  const shown = formatNumber(value, decimals);
  const [draft, setDraft] = useState<string | null>(null);

  const finish = () => {
    presses.commit();
    if (draft === null) return;
    const typed = Number(draft.replace(",", "."));
    setDraft(null);
    if (draft.trim() !== "" && Number.isFinite(typed) && draft !== shown) target.set(clamp(typed, props));
  };
  const scrub = (down: PointerEvent) => {
    if (disabled || down.button !== 0) return;
    let drag: ValueDrag<number> | null = null;
    let wanted = value;
    followPointer(down, {
      move(at, by) {
        wanted = clamp(wanted + by.x * step, props);
        // A finger that goes up or down is about to scroll the panel.
        const isSideways = Math.abs(at.x - down.clientX) > Math.abs(at.y - down.clientY);
        if (isSideways) drag ??= target.drag();
        drag?.update(wanted);
      },
      end: () => drag?.commit(),
      cancel: () => drag?.cancel(),
    });
  };
  const keys = (event: KeyboardEvent) => {
    const input = event.currentTarget as HTMLInputElement;
    if (event.key === "Enter") input.blur();
    else if (event.key === "Escape") {
      presses.cancel();
      setDraft(null);
      input.value = shown;
      input.blur();
    } else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
      event.preventDefault();
      const by = (event.key === "ArrowUp" ? step : -step) * stepsOf(event);
      setDraft(null);
      presses.press(input, value, (from) => clamp(from + by, props), target.drag);
    }
  };
  return (
    <span class="number">
      {tag !== undefined && (
        <span class="number-tag" title={`Drag to change ${label}`} onPointerDown={scrub}>
          {tag}
        </span>
      )}
      <input
        aria-label={label}
        inputMode="decimal"
        disabled={disabled}
        value={draft ?? shown}
        data-typed={draft !== null}
        onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => setDraft(event.currentTarget.value)}
        onKeyDown={keys}
        onBlur={finish}
      />
      {unit !== undefined && <span class="number-unit">{unit}</span>}
    </span>
  );
}

interface SliderProps extends NumberProps {
  /** Ends of the slider; the number beside it may go on to `min` and `max`. */
  from: number;
  to: number;
}

/** A slider with its number. */
export function Slider({ from, to, ...props }: SliderProps) {
  const { label, value, target, disabled, step } = props;
  const { presses } = usePage();
  const drag = useLooseDrag(target);
  /** What moves it. Nothing does after Escape, or once the browser takes the touch for scrolling. */
  const movedBy = useRef<"pointer" | "keys" | "nothing">("pointer");
  const rest = useRef({ from, to, value });
  const dragging = useRef(false);
  // The ends stay where they are under the hand, and make room for the value at rest.
  if (!dragging.current) rest.current = { from: Math.min(from, value), to: Math.max(to, value), value };
  const ends = rest.current;
  const cancel = (input: HTMLInputElement) => {
    movedBy.current = "nothing";
    dragging.current = false;
    presses.cancel();
    drag.cancel();
    input.value = String(rest.current.value);
  };
  const share = (value - ends.from) / Math.max(ends.to - ends.from, 1e-9);
  return (
    <Row label={label}>
      <input
        type="range"
        aria-label={`${label} slider`}
        disabled={disabled}
        min={ends.from}
        max={ends.to}
        step={step / 10}
        value={value}
        style={{ "--share": String(clamp(share, { min: 0, max: 1 })) }}
        onInput={(event) => {
          const input = event.currentTarget;
          const wanted = Number(input.value);
          if (movedBy.current === "keys") {
            presses.press(input, value, () => wanted, target.drag);
          } else if (movedBy.current === "pointer") {
            dragging.current = true;
            drag.update(wanted);
          } else {
            input.value = String(value);
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

const AXES = ["X", "Y", "Z"] as const;

/** Three numbers. */
export function VectorField({
  label,
  value,
  target,
  disabled,
  step,
  tags = AXES,
  min,
}: FieldProps<Vec3> & { step: number; tags?: readonly [string, string, string]; min?: number }) {
  return (
    <Row label={label}>
      {tags.map((tag, axis) => (
        <NumberField
          key={tag}
          tag={tag}
          label={`${label} ${tag}`}
          value={value[axis] ?? 0}
          target={through(target, (component: number) => withComponent(value, axis, component))}
          disabled={disabled}
          step={step}
          decimals={2}
          {...(min === undefined ? {} : { min })}
        />
      ))}
    </Row>
  );
}

function withComponent(vector: Vec3, axis: number, component: number): Vec3 {
  const [x, y, z] = vector.with(axis, component);
  return [x ?? 0, y ?? 0, z ?? 0];
}

/** One of a few. */
export function Choice<V extends string>({
  label,
  value,
  target,
  disabled,
  options,
}: FieldProps<V> & { options: Readonly<{ [K in V]: string }> }) {
  return (
    <Row label={label}>
      <select
        aria-label={label}
        disabled={disabled}
        value={value}
        onChange={(event) => target.set(event.currentTarget.value as V)}
      >
        {(Object.keys(options) as V[]).map((option) => (
          <option key={option} value={option}>
            {options[option]}
          </option>
        ))}
      </select>
    </Row>
  );
}

/** A line of text. */
export function TextField({
  label,
  value,
  set,
  disabled,
  autofocus = false,
}: {
  label: string;
  value: string;
  set(text: string): void;
  disabled: boolean;
  autofocus?: boolean;
}) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (autofocus) input.current?.select();
  }, [autofocus]);
  return (
    <input
      class="text"
      ref={input}
      aria-label={label}
      disabled={disabled}
      value={value}
      maxLength={200}
      onKeyDown={(event) => {
        if (event.key === "Escape") event.currentTarget.value = value;
        if (event.key === "Escape" || event.key === "Enter") event.currentTarget.blur();
      }}
      onBlur={(event) => event.currentTarget.value !== value && set(event.currentTarget.value)}
    />
  );
}

const linearFromSrgb = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const srgbFromLinear = (c: number) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

function hexOf(color: Vec3): string {
  const byte = (c: number) => Math.round(srgbFromLinear(clamp(c, { min: 0, max: 1 })) * 255);
  return `#${color.map((c) => byte(c).toString(16).padStart(2, "0")).join("")}`;
}

function linearOf(hex: string): Vec3 {
  const channel = (at: number) => linearFromSrgb(Number.parseInt(hex.slice(at, at + 2), 16) / 255);
  return [channel(1), channel(3), channel(5)];
}

/** A linear colour: a swatch to pick by eye, and its numbers, which may exceed 1. */
export function ColorField({ label, value, target, disabled }: FieldProps<Vec3>) {
  const drag = useLooseDrag(target);
  return (
    <>
      <Row label={label}>
        <input
          type="color"
          aria-label={`${label} swatch`}
          disabled={disabled}
          value={hexOf(value)}
          onInput={(event) => drag.update(linearOf(event.currentTarget.value))}
          onChange={() => drag.commit()}
        />
      </Row>
      <VectorField
        label={`${label} RGB`}
        value={value}
        target={target}
        disabled={disabled}
        step={0.01}
        tags={["R", "G", "B"]}
        min={0}
      />
    </>
  );
}
