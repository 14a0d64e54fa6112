// States of the page that several of its parts share.

import type { LightId } from "../core/ids";
import type { LinkList } from "../core/links";
import type { Orbit } from "../core/navigation";
import type { Camera, Parameter } from "../core/protocol";

/** State of aiming: the next click in the picture aims the selected light; `missed` if the last click hit nothing. */
export type Aiming = "off" | "on" | "missed";

/** A view through a light, and the one before it. */
export interface Excursion {
  light: LightId;
  name: string;
  camera: Camera;
  before: Orbit;
}

/** Target of clicks in the picture that link objects. */
export interface Linking {
  light: LightId;
  /** The light's links to nodes that it lights, or to those that throw shadows in it. */
  row: Parameter;
  list: LinkList;
  /** Result of the last click; `null` before the first. */
  said: string | null;
}

/** A light that goes if a person says so. */
export interface Removal {
  light: LightId;
  /** Gives the focus away before what has it goes. */
  leave(): void;
}
