// The controls that panels are made of. A value arrives as a property and leaves through its binding.

import { useEffect, useId, useRef, useState } from "preact/hooks";

import { readNumber } from "../core/typed_number";
import type { Vec3 } from "../core/vector";
import { type Binding, through, type ValueDrag } from "./binding";
import { formatNumber } from "./format";
import { usePage } from "./page";
import { followPointer } from "./pointer";
import { stepsOf } from "./presses";
import { Row, type RowProps } from "./row";

export interface FieldProps<V> extends RowProps {
  value: V;
  binding: Binding<V>;
}

export interface NumberProps extends FieldProps<number> {
  /** The nearest number that may be set. */
  clamp?: (value: number) => number;
  /** Change by one arrow key or one pixel of a scrub. */
  step: number;
  /** End of a step by an arrow key, if it is not `wanted` or the nearest number in range. */
  stepTo?: (from: number, wanted: number) => number;
  unit?: string | undefined;
  /** Unit, if it has no room beside the field. */
  countsIn?: string | undefined;
  /** Number of decimals. */
  decimals?: number;
}

const whatever = (value: number) => value;

/** Time that the note of a clamped number is visible. */
const NOTE_MS = 4000;

/** A number to type, to step by arrow keys and, where it has a tag, to scrub by dragging that. */
export function NumberField({ tag, ...props }: NumberProps & { tag?: string }) {
  const {
    label,
    doc,
    value,
    binding,
    disabled,
    step,
    unit,
    countsIn,
    decimals = 3,
    clamp = whatever,
  } = props;
  const { stepTo = (_, wanted) => clamp(wanted) } = props;
  const { presses } = usePage();
  const shown = formatNumber(value, decimals);
  const [draft, setDraft] = useState<string | null>(null);
  /** Note about the typed text. */
  const [note, setNote] = useState<{ text: string; isWrong: boolean } | null>(null);
  const noteId = useId();
  // The note of a clamped number is visible for a while; that of a wrong text until it is corrected.
  useEffect(() => {
    if (note === null || note.isWrong) return undefined;
    const timer = setTimeout(() => setNote(null), NOTE_MS);
    return () => clearTimeout(timer);
  }, [note]);

  const finish = () => {
    presses.commit();
    if (draft === null) return;
    if (draft.trim() === "" || draft === shown) {
      setDraft(null);
      return;
    }
    const typed = readNumber(draft, value, countsIn ?? unit?.trim());
    if ("problem" in typed) {
      // It stays, so that it can be mended.
      setNote({ text: typed.problem, isWrong: true });
      return;
    }
    setDraft(null);
    const taken = clamp(typed.value);
    if (taken !== typed.value) {
      const end = taken < typed.value ? "most" : "least";
      setNote({ text: `${formatNumber(taken, decimals)}${unit ?? ""} is the ${end}`, isWrong: false });
    }
    binding.set(taken);
  };
  const scrub = (down: PointerEvent) => {
    if (disabled || down.button !== 0) return;
    let drag: ValueDrag<number> | null = null;
    let wanted = value;
    followPointer(down, {
      move(at, by) {
        wanted = clamp(wanted + by.x * step);
        // A finger that goes up or down is about to scroll the panel.
        const isSideways = Math.abs(at.x - down.clientX) > Math.abs(at.y - down.clientY);
        if (isSideways) drag ??= binding.drag();
        drag?.update(wanted);
      },
      end: () => drag?.commit(),
      cancel: () => drag?.cancel(),
    });
  };
  const keys = (event: KeyboardEvent) => {
    const input = event.currentTarget as HTMLInputElement;
    setNote(null);
    if (event.key === "Enter") input.blur();
    else if (event.key === "Escape") {
      presses.cancel();
      setDraft(null);
      setNote(null);
      input.value = shown;
      input.blur();
    } else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
      event.preventDefault();
      const by = (event.key === "ArrowUp" ? step : -step) * stepsOf(event);
      setDraft(null);
      presses.press(input, value, (from) => stepTo(from, from + by), binding.drag);
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
        title={doc}
        inputMode="decimal"
        disabled={disabled}
        value={draft ?? shown}
        data-typed={draft !== null}
        aria-invalid={note?.isWrong === true}
        aria-describedby={note === null ? undefined : noteId}
        onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => {
          setNote(null);
          setDraft(event.currentTarget.value);
        }}
        onKeyDown={keys}
        onBlur={finish}
      />
      {unit !== undefined && <span class="number-unit">{unit}</span>}
      {note !== null && (
        <span class="number-note" id={noteId} role="status" data-wrong={note.isWrong}>
          {note.text}
        </span>
      )}
    </span>
  );
}

const AXES = ["X", "Y", "Z"] as const;

interface VectorProps extends FieldProps<Vec3> {
  step: number;
  tags?: readonly [string, string, string];
  /** Range of each component. */
  clamp?: (value: number) => number;
}

/** Three numbers. */
export function VectorField({ step, tags = AXES, clamp = whatever, ...props }: VectorProps) {
  const { label, doc, value, binding, disabled } = props;
  return (
    <Row {...props}>
      {tags.map((tag, axis) => (
        <NumberField
          key={tag}
          tag={tag}
          label={`${label} ${tag}`}
          doc={doc}
          value={value[axis] ?? 0}
          binding={through(binding, (component: number) => withComponent(value, axis, component))}
          disabled={disabled}
          step={step}
          decimals={2}
          clamp={clamp}
        />
      ))}
    </Row>
  );
}

function withComponent(vector: Vec3, axis: number, component: number): Vec3 {
  const [x, y, z] = vector.with(axis, component);
  return [x ?? 0, y ?? 0, z ?? 0];
}

interface ChoiceProps extends FieldProps<string> {
  choices: readonly { name: string; label: string }[];
}

/** One of a few. */
export function Choice({ choices, ...props }: ChoiceProps) {
  const { label, doc, value, binding, disabled } = props;
  return (
    <Row {...props}>
      <select
        aria-label={label}
        title={doc}
        disabled={disabled}
        value={value}
        onChange={(event) => binding.set(event.currentTarget.value)}
      >
        {choices.map((choice) => (
          <option key={choice.name} value={choice.name}>
            {choice.label}
          </option>
        ))}
      </select>
    </Row>
  );
}

/** On or off. */
export function Checkbox(props: FieldProps<boolean>) {
  const { label, doc, value, binding, disabled } = props;
  return (
    <Row {...props}>
      <input
        type="checkbox"
        aria-label={label}
        title={doc}
        disabled={disabled}
        checked={value}
        onChange={(event) => binding.set(event.currentTarget.checked)}
      />
    </Row>
  );
}

interface TextProps {
  label: string;
  doc?: string | undefined;
  value: string;
  set(text: string): void;
  disabled: boolean;
  /** In UTF-16 units, as fields count. */
  maxLength?: number;
  autofocus?: boolean;
}

const LONGEST_TEXT = 200;

/** A line of text. */
export function TextField(props: TextProps) {
  const { label, doc, value, set, disabled, maxLength = LONGEST_TEXT, autofocus = false } = props;
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (autofocus) input.current?.select();
  }, [autofocus]);
  return (
    <input
      class="text"
      ref={input}
      aria-label={label}
      title={doc}
      disabled={disabled}
      value={value}
      maxLength={maxLength}
      onKeyDown={(event) => {
        if (event.key === "Escape") event.currentTarget.value = value;
        if (event.key === "Escape" || event.key === "Enter") event.currentTarget.blur();
      }}
      onBlur={(event) => event.currentTarget.value !== value && set(event.currentTarget.value)}
    />
  );
}
