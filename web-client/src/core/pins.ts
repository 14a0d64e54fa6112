// Pins: properties at points or of objects that drags of a light keep.

import { lightOf } from "./document";
import type { LightId } from "./ids";
import { nodeName } from "./node_tree";
import type { Document, Pin, PinKind, Probed } from "./protocol";

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

/**
 * Name of a pin: what it keeps, and of which object or of whose shadow. `seenOn` is the node at a pinned point, where it is
 * known.
 */
export function pinText({ kind, at, caster }: Pin, seenOn: string | null = null): string {
  const object = caster ?? (typeof at === "string" ? at : undefined);
  if (object !== undefined) return `${PIN_TEXTS[kind]} of ${nodeName(object)}`;
  return seenOn === null ? PIN_TEXTS[kind] : `${PIN_TEXTS[kind]} on ${nodeName(seenOn)}`;
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
