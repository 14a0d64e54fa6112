// Alternatives of a drag: several lights that have the feature under the cursor, solved under different constraints.

import type { Command, Document, DragAlternative, DragOutcome, Light } from "./protocol";

export const ALTERNATIVE_NAMES: { [A in DragAlternative]: string } = {
  wholeLight: "Whole light",
  controlPoints: "Control points",
  narrower: "Narrower",
  pastCaster: "Past the caster",
  linkedCopy: "Linked copy",
};

/** Result of one alternative, as `POST /sessions/S/drags` gives it. */
export interface AlternativeAnswer extends Pick<
  DragOutcome,
  "status" | "limit" | "reason" | "pin" | "residualPx" | "changedShare"
> {
  alternative: DragAlternative;
  light: Light;
  /** PNG of 160 pixels width, in base64. */
  thumbnail?: string;
}

/** Results, or a sentence that says why there are none. */
export type AlternativesReply = { alternatives: readonly AlternativeAnswer[] } | { why: string };

/** Command that drags a feature. */
export type FeatureCommand = Extract<Command, { type: "dragFeature" }>;

/** A drag in a request; names its light by its place in the order of ids. */
export type AlternativesRequest = Omit<FeatureCommand, "type" | "alternative"> & { alternatives: true };

/** Request for all alternatives of `command`; `null` if its light is gone. */
export function requestOf(command: FeatureCommand, document: Document): AlternativesRequest | null {
  const place = document.lights.findIndex(({ id }) => id === command.light);
  if (place < 0) return null;
  const { type: _, alternative: __, ...drag } = command;
  return { ...drag, light: place, alternatives: true };
}

/** True if both commands drag the same feature to the same place. */
export const isSameWay = (a: FeatureCommand, b: FeatureCommand): boolean =>
  a.light === b.light && a.kind === b.kind && isSame(a.from, b.from) && isSame(a.to, b.to);

const isSame = (a: readonly [number, number], b: readonly [number, number]): boolean =>
  a[0] === b[0] && a[1] === b[1];

/** True if the light can be had: the feature is under the cursor, or on its way there. */
export const canBeTaken = ({ status }: Pick<AlternativeAnswer, "status">): boolean => status !== "refused";

/**
 * The alternative that lies `by` further than `taken` among those that can be had, around the end; `null` where there is
 * no other. From none the first step leads to the best.
 */
export function stepped(
  all: readonly AlternativeAnswer[],
  taken: DragAlternative | null,
  by: number,
): DragAlternative | null {
  const names = all.filter(canBeTaken).map(({ alternative }) => alternative);
  const at = taken === null ? -1 : names.indexOf(taken);
  const start = at < 0 && by < 0 ? 0 : at;
  const next = names[(((start + by) % names.length) + names.length) % names.length];
  return next === undefined || next === taken ? null : next;
}

/** Text of the share of the picture that changes; a little is not nothing. Its number and unit stay on one line. */
export function changesText(share: number | undefined): string | null {
  if (share === undefined) return null;
  if (share > 0 && share < 0.005) return "changes < 1\u00a0%";
  return `changes ${Math.round(100 * share)}\u00a0%`;
}
