// A number over an angle, as knots `[degrees, number]` in order (SPEC, CURVE-1).

/** A value of such a parameter; `null` for none. */
export type PeriodicCurve = readonly Knot[] | null;
export type Knot = readonly [degrees: number, value: number];

const TURN = 360;
/** Minimum distance of two knots on the page, degrees. */
const NEAREST = 0.1;

/** The number at an angle: linear from knot to knot, and around from the last to the first. */
export function valueAt(knots: readonly Knot[], degrees: number): number | undefined {
  const [first, last] = [knots[0], knots.at(-1)];
  if (first === undefined || last === undefined) return undefined;
  const line: Knot[] = [[last[0] - TURN, last[1]], ...knots, [first[0] + TURN, first[1]]];
  const next = line.findIndex(([at]) => at > degrees);
  const [[from, a], [to, b]] = [line[next - 1] ?? last, line[next] ?? first];
  return a + ((b - a) * (degrees - from)) / (to - from);
}

/** The knots with one more in the middle of the widest gap, on the line that was there; the first has `value` at 0. */
export function withOneMore(curve: PeriodicCurve, value: number): readonly Knot[] {
  const knots = curve ?? [];
  const [first] = knots;
  if (first === undefined) return [[0, value]];
  const ends = [...knots.slice(1), [first[0] + TURN, first[1]] as const];
  const gaps = knots.map(([from], index) => ({ from, length: (ends[index]?.[0] ?? from) - from }));
  const widest = gaps.reduce((a, b) => (b.length > a.length ? b : a));
  const degrees = (widest.from + widest.length / 2) % TURN;
  const more: Knot = [degrees, valueAt(knots, degrees) ?? value];
  return [...knots, more].sort(([a], [b]) => a - b);
}

/** The knots without one; `null` where none is left. */
export function without(knots: readonly Knot[], index: number): PeriodicCurve {
  const left = knots.filter((_, other) => other !== index);
  return left.length === 0 ? null : left;
}

/** The nearest degrees that a knot may have between those beside it. */
export function clampDegrees(knots: readonly Knot[], index: number, degrees: number): number {
  const least = index === 0 ? 0 : (knots[index - 1]?.[0] ?? 0) + NEAREST;
  const most = (knots[index + 1]?.[0] ?? TURN) - NEAREST;
  return Math.min(Math.max(degrees, least), Math.max(most, least));
}

/** The curve around a circle of radius 1, `steps` points from the left over the top, y down as in pictures. */
export function outlineOf(knots: readonly Knot[], steps: number): [number, number][] {
  return Array.from({ length: steps }, (_, step) => {
    const degrees = (TURN * step) / steps;
    const [angle, out] = [(degrees * Math.PI) / 180, valueAt(knots, degrees) ?? 1];
    return [-out * Math.cos(angle), -out * Math.sin(angle)];
  });
}
