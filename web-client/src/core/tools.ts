// Tools on the picture: features of lights, which are dragged, and points that are pinned.

import type { Pixel, Size } from "./camera";
import { lightOf } from "./document";
import type { LightId } from "./ids";
import { namesOf } from "./node_tree";
import type {
  Camera,
  Command,
  Document,
  DragKind,
  DragLimit,
  DragOutcome,
  DragRadii,
  Light,
  Pin,
  PinKind,
  Probed,
  ProbedLight,
} from "./protocol";

export const FEATURES: readonly DragKind[] = ["shadow", "hotspot", "highlight", "diffuse"];

export type Tool = "select" | DragKind | "pin";

export const TOOLS: readonly Tool[] = ["select", ...FEATURES, "pin"];

/** Freedom of a light that follows a dragged feature. */
export interface Following {
  /** True if the light bends; else it moves as a whole. */
  bends: boolean;
  /** Control points that stay where they are, of those that can be dragged at all. */
  resting: ReadonlySet<number>;
  radii: DragRadii;
  /** True if the source may not pass through a surface. */
  sourceOutside: boolean;
}

/** True if a tool drags features. */
export const dragsFeatures = (tool: Tool): tool is DragKind => tool !== "select" && tool !== "pin";

/** Rec. 709's luminance. */
const luminance = ([r, g, b]: readonly [number, number, number]): number =>
  0.2126 * r + 0.7152 * g + 0.0722 * b;

/** A selected light is taken before one that gives this many times as much. */
const SELECTED_COUNTS = 4;

/** The light that makes what is under the pointer: of a shadow the one that is kept off and would give most there, of
 * anything else the one that gives most. The selected one is preferred where it counts at all. */
export function takenLight(kind: DragKind, found: Probed, selected: LightId | null): ProbedLight | null {
  const makes = (light: ProbedLight): number => {
    if (kind === "shadow") return light.state === "shadowed" ? luminance(light.irradiance) : 0;
    return light.state === "lit" ? luminance(light.radiance) : 0;
  };
  const makers = found.lights.filter((light) => makes(light) > 0);
  const most = Math.max(0, ...makers.map(makes));
  const own = makers.find(({ light }) => light === selected);
  if (own !== undefined && SELECTED_COUNTS * makes(own) >= most) return own;
  return makers.find((light) => makes(light) === most) ?? null;
}

/** Why nothing is taken. */
export function nothingTaken(kind: DragKind, found: Probed): string {
  if (found.seen === null) return "Nothing is seen here: press on a surface";
  return kind === "shadow"
    ? "No shadow falls here: press in one"
    : "No light arrives here: press where one shines";
}

/** The control points of a light that follow: those past the source that do not rest; `undefined` for the light as a whole. */
export function movingPoints(light: Light, { bends, resting }: Following): number[] | undefined {
  if (!bends || light.type !== "bendy") return undefined;
  return light.points.flatMap((_, point) => (point === 0 || resting.has(point) ? [] : [point]));
}

/** A picture that is dragged in: who looks, and how many pixels it has. */
export interface Seen {
  camera: Camera;
  size: Size;
}

/** Command that drags the feature from `from` to `to`, in the picture's pixels. */
export function featureDrag(
  kind: DragKind,
  [id, light]: [LightId, Light],
  following: Following,
  { camera, size }: Seen,
  [from, to]: [Pixel, Pixel],
): Command {
  const points = movingPoints(light, following);
  return {
    type: "dragFeature",
    light: id,
    kind,
    ...(points === undefined ? {} : { points }),
    radii: points === undefined ? "keep" : following.radii,
    camera,
    size: [size.width, size.height],
    from: [from.x, from.y],
    to: [to.x, to.y],
    ...(following.sourceOutside ? { sourceOutside: true } : {}),
  };
}

const LIMITS: { [L in DragLimit]: string } = {
  fold: "the tube would fold",
  radius: "it would be thinner than nothing",
  tubeEdge: "it would lie outside the light",
  noDescent: "nothing small brings it nearer",
  sourceInside: "the source would go through a surface",
  pin: "a pin holds it",
  tooMuchWork: "too much work; choose fewer control points or remove pins",
};

/** Sentence for a drag that has not landed, or whose shadow is another's too; `null` otherwise. */
export function outcomeText({ status, limit, residualPx, shadowedBy }: DragOutcome): string | null {
  if (status === "limited") {
    const short = residualPx === null ? "Out of the picture" : `${residualPx.toFixed(1)} px short`;
    return `${short}: ${LIMITS[limit ?? "noDescent"]}`;
  }
  return shadowedBy === null ? null : `${shadowedBy} shadows this too`;
}

export const PIN_KINDS: readonly PinKind[] = [
  "look",
  "lit",
  "shadowed",
  "shadow",
  "direction",
  "coordinates",
];

export const PIN_TEXTS: { [K in PinKind]: string } = {
  look: "Look",
  lit: "Lit",
  shadowed: "In shadow",
  shadow: "This shadow",
  direction: "Direction",
  coordinates: "Light coordinates",
};

/** Name of a pin: what it keeps, and of which object or of whose shadow. */
export function pinText({ kind, at, caster }: Pin): string {
  const object = caster ?? (typeof at === "string" ? namesOf(at).at(-1) : undefined);
  return object === undefined ? PIN_TEXTS[kind] : `${PIN_TEXTS[kind]} of ${object}`;
}

/** Choice of the next pin. */
export interface PinChoice {
  kind: PinKind;
  hard: boolean;
  /** The pin is of the whole object, not of a point. */
  ofObject: boolean;
}

/** Pin for a probed point or its object, or the reason why there can be none. */
export function pinAt({ kind, hard, ofObject }: PinChoice, light: LightId, found: Probed): Pin | string {
  const probed = found.lights.find((other) => other.light === light);
  if (found.seen === null || probed === undefined) return "Nothing is seen here: pin a surface";
  const at = ofObject ? found.seen.node : found.seen.position;
  switch (kind) {
    case "look":
    case "direction":
    case "coordinates":
      return probed.place === null
        ? "This is outside the light: pin what it reaches"
        : { kind, light, at, hard };
    case "lit":
      return probed.state === "lit"
        ? { kind, light, at, hard }
        : "The light does not arrive here: pin what it lights";
    case "shadowed":
    case "shadow": {
      if (probed.shadowedBy === null) return "No shadow of the light falls here: pin one";
      const caster = kind === "shadow" ? { caster: probed.shadowedBy.node } : {};
      return { kind, light, at, hard, ...caster };
    }
  }
}

/** The pins of a light, with their ids. */
export function pinsOf(document: Document, light: LightId | null): { id: number; pin: Pin }[] {
  if (lightOf(document, light) === undefined) return [];
  return (document.pins ?? []).filter(({ pin }) => pin.light === light);
}
