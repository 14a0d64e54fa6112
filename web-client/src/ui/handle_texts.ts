// Texts of handles.
//
// To screen readers a handle is a slider: on one they pass arrow keys on to the page, and say the value that a press has
// made. What moves in two directions is one slider with all of it in its text, as in colour pickers.

import type { AriaAttributes } from "preact";

import { lightLabel } from "../core/document";
import type { Drawn, Handle } from "../core/handles";
import type { Light } from "../core/protocol";
import { toEulerDegrees, type Vec3 } from "../core/vector";
import { formatNumber } from "./format";

/** Tooltip of a handle: the effect of a drag. */
export function titleOf(handle: Handle): string {
  switch (handle.kind) {
    case "source":
      return "Move the light";
    case "point":
      return `Move control point ${handle.point}`;
    case "radius":
      return `Radius at control point ${handle.point}`;
    case "turn":
      return `Turn about ${"xyz"[handle.axis]}`;
    case "cone":
      return "Cone angle";
  }
}

/** Name and value of a handle, for who hears them. */
export function described(handle: Handle, drawn: Drawn): AriaAttributes {
  const { light } = drawn;
  const name = lightLabel(drawn);
  const whereabouts = (at: Vec3): AriaAttributes => ({
    "aria-roledescription": "2D slider",
    "aria-valuenow": inDigits(at[0]),
    "aria-valuetext": `x ${spoken(at[0])}, y ${spoken(at[1])}, z ${spoken(at[2])}`,
  });
  const size = (value: number, unit = ""): AriaAttributes => ({
    "aria-valuenow": inDigits(value),
    "aria-valuetext": `${spoken(value)}${unit}`,
  });
  switch (handle.kind) {
    case "source":
      return { "aria-label": `Source of ${name}`, ...whereabouts(light.transform.translation) };
    case "point":
      return {
        "aria-label": `Control point ${handle.point} of ${name}`,
        ...whereabouts(pointOf(light, handle.point)),
      };
    case "radius":
      return {
        "aria-label": `Radius at control point ${handle.point} of ${name}`,
        ...size(radiusOf(light, handle.point)),
      };
    case "turn": {
      const degrees = toEulerDegrees(light.transform.rotation)[handle.axis];
      return { "aria-label": `Turn ${name} about its ${"xyz"[handle.axis]}`, ...size(degrees, " degrees") };
    }
    case "cone":
      return { "aria-label": `Cone angle of ${name}`, ...size(coneAngleOf(light), " degrees") };
  }
}

/** Attributes of numbers take no exponents, which a number near to 0 has. */
const inDigits = (value: number) => Number(value.toFixed(6));
const spoken = (value: number) => formatNumber(value, 2);
const coneAngleOf = (light: Light): number => ("coneAngle" in light ? light.coneAngle : 0);
const pointOf = (light: Light, point: number): Vec3 =>
  (light.type === "bendy" ? light.points[point] : undefined) ?? [0, 0, 0];
const radiusOf = (light: Light, point: number): number =>
  (light.type === "bendy" ? light.radii[point] : undefined) ?? 0;
