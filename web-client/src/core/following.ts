// Freedom of a light whose feature is dragged, and the command of such a drag.

import type { FeatureCommand } from "./alternatives";
import type { Pixel, Size } from "./camera";
import type { LightId } from "./ids";
import type { Camera, DragAlternative, DragChoice, DragKind, DragRadii, Light } from "./protocol";

/**
 * Ways in which a light follows a dragged feature.
 *
 * - `best`: The server takes the alternative that lands and changes least of what is lit.
 * - `whole`: The light moves as a whole.
 * - `points`: Control points move, the source stays.
 */
export const FOLLOW_MODES = ["best", "whole", "points"] as const;
export type FollowMode = (typeof FOLLOW_MODES)[number];

/** Freedom of a light that follows a dragged feature. */
export interface Following {
  mode: FollowMode;
  /** Control points that stay where they are, of those that can be dragged at all. */
  resting: ReadonlySet<number>;
  /** Treatment of radii, in mode `points`. */
  radii: DragRadii;
  /** True if the source may not pass through a surface. */
  sourceOutside: boolean;
}

/** The mode after `mode`, around the end. */
export const nextMode = (mode: FollowMode): FollowMode =>
  FOLLOW_MODES[(FOLLOW_MODES.indexOf(mode) + 1) % FOLLOW_MODES.length] ?? "best";

/** The alternative that the server names for a mode that names none. */
export const alternativeOf = (mode: FollowMode): DragAlternative | null =>
  (({ best: null, whole: "wholeLight", points: "controlPoints" }) as const)[mode];

/** The control points of a light that do not rest, without its source; `undefined` for a light without control points. */
export function freePoints(light: Light, resting: ReadonlySet<number>): number[] | undefined {
  if (light.type !== "bendy") return undefined;
  return light.points.flatMap((_, point) => (point === 0 || resting.has(point) ? [] : [point]));
}

/** A picture that is dragged in: who looks, and how many pixels it has. */
export interface Seen {
  camera: Camera;
  size: Size;
}

/**
 * Command that drags the feature from `from` to `to`, in the picture's pixels. `chosen` is an alternative that was chosen
 * during the drag, in place of the mode's.
 */
export function featureDrag(
  kind: DragKind,
  [id, light]: [LightId, Light],
  following: Following,
  { camera, size }: Seen,
  [from, to]: [Pixel, Pixel],
  chosen: DragChoice | null = null,
): FeatureCommand {
  return {
    type: "dragFeature",
    light: id,
    kind,
    ...freedom(light, following, chosen),
    camera,
    size: [size.width, size.height],
    from: [from.x, from.y],
    to: [to.x, to.y],
    sourceOutside: following.sourceOutside,
  };
}

type Freedom = Pick<FeatureCommand, "points" | "radii" | "alternative">;

function freedom(light: Light, { mode, resting, radii }: Following, chosen: DragChoice | null): Freedom {
  const alternative = chosen ?? (mode === "best" ? "best" : null);
  const free = mode === "whole" ? undefined : freePoints(light, resting);
  if (alternative === null) return free === undefined ? { radii: "keep" } : { points: free, radii };
  // With an alternative the server decides what moves, among the points that do not rest.
  const rests = free !== undefined && light.type === "bendy" && free.length < light.points.length - 1;
  return { ...(rests ? { points: free } : {}), radii: "keep", alternative };
}
