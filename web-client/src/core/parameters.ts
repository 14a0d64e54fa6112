// The table of parameters: who has which, where a value stands, what may be set, what a picture shows of it.

import type { Command, Parameter, ParameterTable } from "./protocol";

/** Owner of parameters: a light of a shape, a control point, a camera. */
export type Owner = Parameter["of"][number];

/** Kind of a parameter's values. */
export type Kind = Parameter["kind"];
export type NumberKind = Extract<Kind, { type: "number" }>;

/** The rows of `owner`, in the order in which people see them. */
export const rowsOf = ({ parameters }: ParameterTable, owner: Owner): Parameter[] =>
  parameters.filter(({ of }) => of.includes(owner));

const rowOf = (table: ParameterTable, owner: Owner, name: string): Parameter | undefined =>
  rowsOf(table, owner).find((row) => row.name === name);

/** Rows that stand together under a heading. */
export interface Section {
  group: string;
  rows: Parameter[];
}

/** The rows of `owner` by their groups, which come in the order of their first rows. */
export function sectionsOf(table: ParameterTable, owner: Owner): Section[] {
  const rows = rowsOf(table, owner);
  const groups = [...new Set(rows.map(({ group }) => group))];
  return groups.map((group) => ({ group, rows: rows.filter((row) => row.group === group) }));
}

/** True if a picture can show the row's value of this owner, whose JSON is given. */
export function hasEffect(table: ParameterTable, owner: Owner, row: Parameter, json: object): boolean {
  const { needs, idleOf = [] } = row;
  if (idleOf.includes(owner)) return false;
  const other = needs === undefined ? undefined : rowOf(table, owner, needs.parameter);
  if (needs === undefined || other === undefined) return true;
  const value = valueIn(other, owner, json);
  const isAmong = (values: readonly unknown[]) => values.some((one) => isSameValue(one, value));
  return "oneOf" in needs.value ? isAmong(needs.value.oneOf) : !isAmong(needs.value.noneOf);
}

/** A number is an index in a list. */
type Path = readonly (string | number)[];

/** Path of a value in a light's or camera's JSON; that of a control point is in a list of its light's. */
function pathOf(path: string, point?: number): Path {
  const steps = path.split("/");
  return point === undefined ? steps : [...steps, point];
}

/** The row's value in the JSON of its owner (of a control point: its light), which may leave out what is the default. */
export function valueIn(row: Parameter, owner: Owner, json: object, point?: number): unknown {
  const found = pathOf(row.path, point).reduce<unknown>(stepInto, json);
  return found ?? (isOptional(row.kind) ? null : row.default[owner]);
}

const stepInto = (json: unknown, step: string | number): unknown =>
  typeof json === "object" && json !== null ? (json as { [key: string | number]: unknown })[step] : undefined;

/**
 * The JSON of an owner (of a control point: its light) with `values` set, which go by the names of rows. A row that the
 * table lacks stands under its own name. Nothing is set in lists that are not there or are shorter.
 */
export function withValues<T extends object>(
  table: ParameterTable,
  owner: Owner,
  json: T,
  values: object,
  point?: number,
): T {
  return Object.entries(values).reduce<T>((json, [name, value]) => {
    const path = rowOf(table, owner, name)?.path ?? name;
    return withValueAt(json, pathOf(path, point), value) as T;
  }, json);
}

/** `null` is written by leaving the value out. */
function withValueAt(json: unknown, [step, ...further]: Path, value: unknown): unknown {
  if (step === undefined) return value;
  if (typeof step === "number") {
    if (!Array.isArray(json) || step >= json.length) return json;
    return json.with(step, withValueAt(json[step], further, value));
  }
  const { [step]: old, ...others } = (json ?? {}) as { [key: string]: unknown };
  const changed = withValueAt(old, further, value);
  return changed === null || changed === undefined ? others : { ...others, [step]: changed };
}

/** True if a picture can show that the owner's `values`, by the names of rows, have changed (SPEC, FRAME-7). */
export const touchPicture = (table: ParameterTable, owner: Owner, values: object): boolean =>
  Object.keys(values).some((name) => rowOf(table, owner, name)?.touches !== "nothing");

/** Sets a parameter of a light or of one of its control points. */
export function setParameter(light: number, { name }: Parameter, value: unknown, point?: number): Command {
  const parameter = { [name]: value };
  const command =
    point === undefined
      ? { type: "setLight", light, parameter }
      : { type: "setPoint", light, point, parameter };
  return command as Command;
}

/** True if two values of a parameter are the same. */
export const isSameValue = (a: unknown, b: unknown): boolean => JSON.stringify(a) === JSON.stringify(b);

const isOptional = (kind: Kind): boolean =>
  kind.type === "links" ||
  kind.type === "periodicCurve" ||
  (kind.type === "number" && kind.none !== undefined);

/** The share of a step by which a number that may only come near to a limit stays away from it. */
const NEAR = 0.1;

/** `value`, or the limit that it is beyond. */
export function clampTo(kind: NumberKind, value: number): number {
  const { min = -Infinity, max = Infinity, exclusiveMin = -Infinity, exclusiveMax = Infinity, step } = kind;
  if (value <= exclusiveMin) return exclusiveMin + NEAR * step;
  if (value >= exclusiveMax) return exclusiveMax - NEAR * step;
  return Math.min(Math.max(value, min), max);
}

/** End of a step from one number to another: a step stays on the slider; numbers beyond it are typed. */
export function stepTo(kind: NumberKind, from: number, wanted: number): number {
  const [least, most] = kind.slider ?? [-Infinity, Infinity];
  const isOn = least <= from && from <= most;
  return clampTo(kind, isOn ? Math.min(Math.max(wanted, least), most) : wanted);
}

/** Steps of a slider where neither the row nor a value says how far it goes. */
const SOME_STEPS = 100;

/** Ends of the slider for one of `values`; where the row says none, it has room for twice as much as the largest. */
export function sliderEnds(kind: NumberKind, values: readonly number[]): [number, number] {
  if (kind.slider !== undefined) return kind.slider;
  const reach = 2 * Math.max(0, ...values.map(Math.abs));
  const from = kind.min ?? kind.exclusiveMin ?? (Math.min(0, ...values) < 0 ? -reach : 0);
  const to = reach > from ? reach : from + SOME_STEPS * kind.step;
  return [from, Math.min(to, kind.max ?? kind.exclusiveMax ?? Infinity)];
}

/** A value to begin with where there was none: a round number in the slider's first half. */
export function firstValue(kind: NumberKind): number {
  const [from, to] = sliderEnds(kind, []);
  return clampTo(kind, Number((from + (to - from) / 4).toPrecision(1)));
}
