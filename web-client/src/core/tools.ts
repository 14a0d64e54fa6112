// Tools on the picture, and the light whose feature one of them takes.

import type { LightId } from "./ids";
import { nodeName } from "./node_tree";
import type { DragKind, Probed, ProbedLight } from "./protocol";

export const FEATURES: readonly DragKind[] = ["shadow", "hotspot", "highlight", "diffuse"];

export type Tool = "select" | DragKind | "pin";

export const TOOLS: readonly Tool[] = ["select", ...FEATURES, "pin"];

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

/** Name of the feature that a tool would take. */
export function featureText(kind: DragKind, { shadowedBy }: Pick<ProbedLight, "shadowedBy">): string {
  switch (kind) {
    case "shadow":
      return shadowedBy === null ? "shadow" : `shadow of ${nodeName(shadowedBy.node)}`;
    case "hotspot":
      return "hotspot";
    case "highlight":
      return "highlight";
    case "diffuse":
      return "brightest side";
  }
}
