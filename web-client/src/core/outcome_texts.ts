// Results of drags of features, in words.

import { ALTERNATIVE_NAMES, changesText } from "./alternatives";
import type { DragAlternative, DragConstraint, DragLimit, DragOutcome, DragReason } from "./protocol";

const LIMITS: { [L in DragLimit]: string } = {
  fold: "the tube would fold",
  overlap: "the tube would overlap itself",
  radius: "it would be thinner than nothing",
  tubeEdge: "it would lie outside the light",
  noDescent: "nothing small brings it nearer",
  sourceInside: "the source would go through a surface",
  pin: "a pin holds it",
  tooMuchWork: "too much work; choose fewer control points or remove pins",
};

const REASONS: { [R in Exclude<DragReason, "limited">]: string } = {
  nothingAtStart: "nothing is seen where the drag began",
  nothingAtEnd: "nothing is seen under the pointer",
  outsideTheLight: "this lies outside the light",
  noShadow: "no shadow falls here",
  notBendy: "the light has no control points",
  noSuchPoint: "the light has no such control point",
  noWeight: "these control points do not reach it",
  pinDoesNotHold: "a pin does not hold",
  tooLittleRoom: "too little room behind the caster",
};

const RELAXED: { [C in DragConstraint]: string } = {
  picture: "the rest of the picture counts less",
  softPins: "soft pins do not count",
  radii: "the light gets narrower",
};

/** Parts of a result that texts are made of. */
export type Told = Pick<DragOutcome, "status" | "limit" | "reason" | "residualPx">;

/** Texts of the pin that a result names. */
export type PinName = string | null;

/** Reason why the feature is not under the cursor; `null` where it is. */
export function shortText({ status, limit, reason, residualPx }: Told, pin: PinName = null): string | null {
  if (status === "landed") return null;
  if (status === "refused") {
    const why =
      reason === undefined || reason === "limited" ? limitText(limit, pin) : reasonText(reason, pin);
    return `Refused: ${why}`;
  }
  const short = residualPx === null ? "Out of the picture" : `${pixels(residualPx)} px short`;
  return `${short}: ${limitText(limit, pin)}`;
}

/** Few digits: a pixel's tenths count only near the cursor. */
const pixels = (px: number): string => (px < 10 ? px.toFixed(1) : px.toFixed(0));

function limitText(limit: DragLimit | undefined, pin: PinName): string {
  return limit === "pin" && pin !== null ? `the pin “${pin}” holds it` : LIMITS[limit ?? "noDescent"];
}

function reasonText(reason: Exclude<DragReason, "limited">, pin: PinName): string {
  return reason === "pinDoesNotHold" && pin !== null ? `the pin “${pin}” does not hold` : REASONS[reason];
}

/** Largest change of what the picture shows of pinned objects. */
function pinnedText(change: number): string {
  const steps = Math.round(255 * change);
  return steps === 0 ? "pinned objects stay as they are" : `pinned objects change by ${steps} of 255 at most`;
}

/** Constraints that gave way so that the feature lands. */
function relaxedText(relaxed: readonly DragConstraint[] = []): string | null {
  return relaxed.length === 0 ? null : `To get there ${relaxed.map((one) => RELAXED[one]).join(", ")}`;
}

/**
 * Lines about a drag that is under way: the residual, what changes, the alternative that was taken, what gave way, and what pinned
 * objects change.
 */
export function dragLines(outcome: DragOutcome, taken: DragAlternative | null, pin: PinName): string[] {
  const { changedShare, pinnedChange, relaxed, shadowedBy, status } = outcome;
  const changes = changesText(changedShare);
  const name = taken === null ? null : ALTERNATIVE_NAMES[taken];
  const lines = [
    shortText(outcome, pin),
    shadowedBy === null || status === "refused" ? null : `${shadowedBy} shadows this too`,
    [name, changes].filter((part) => part !== null).join(", "),
    relaxedText(relaxed),
    pinnedChange === undefined ? null : pinnedText(pinnedChange),
  ];
  return lines.filter((line) => line !== null && line !== "") as string[];
}
