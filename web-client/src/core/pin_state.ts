// State of pins, as probes of their points show it.

import { namesOf } from "./node_tree";
import type { Pin, Probed, ProbedLight, ProbeState } from "./protocol";
import { length, sub, type Vec3 } from "./vector";

/** A pinned point as a probe saw it. */
export interface PinSight {
  /** Path of the node that the point lies on. */
  node: string;
  state: ProbeState;
}

/** Share of its depth that a seen surface may lie away from a pinned point that it is taken for. */
const NEAR = 0.01;

/** The light of `pin` at the pinned point `at`; `null` where the probe saw something in front of it. */
export function atPin(pin: Pin, at: Vec3, { seen, lights }: Probed): ProbedLight | null {
  if (seen === null || length(sub(seen.position, at)) > NEAR * seen.depth) return null;
  return lights.find(({ light }) => light === pin.light) ?? null;
}

/**
 * True if the pin holds in what a probe of its point found. `first` is the state that the page first saw there, which a pin
 * of a look keeps. `null` where the probe cannot tell.
 */
export function pinHolds(
  { kind, caster }: Pin,
  found: ProbedLight,
  first: ProbeState | null,
): boolean | null {
  const { state, shadowedBy, place } = found;
  // A light that is off or not linked says nothing of what it would do.
  if (state === "disabled" || state === "unlinked") return null;
  switch (kind) {
    case "lit":
      return state === "lit";
    case "shadowed":
      return state === "shadowed";
    case "shadow":
      return state === "shadowed" && (caster === undefined || isNode(shadowedBy?.node, caster));
    case "look":
      return first === null ? null : state === first;
    case "direction":
    case "coordinates":
      return place !== null;
  }
}

/** True if `named`, a name or a path, means the node at `path` or one above it. */
export function isNode(path: string | undefined, named: string): boolean {
  if (path === undefined) return false;
  return path === named || path.startsWith(`${named}/`) || namesOf(path).includes(named);
}
