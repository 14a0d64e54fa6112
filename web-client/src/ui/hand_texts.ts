// Values under the hand while a handle or an arrow is dragged, in words.

import { toWorld } from "../core/outline";
import type { Command, Light } from "../core/protocol";
import { compose, inverse, length, type Quat, sub, type Vec3 } from "../core/vector";
import { formatNumber } from "./format";

/** Lines about a drag: the value of `now` that `command` changes, against the light before the drag. */
export function handLines(command: Command, before: Light, now: Light): string[] {
  switch (command.type) {
    case "placeLight": {
      const turned = degreesBetween(before.transform.rotation, now.transform.rotation);
      if (command.rotation != null) return [`turned ${formatNumber(turned, 2)}°`];
      return [movedText(before.transform.translation, now.transform.translation)];
    }
    case "dragPoint": {
      const [from, to] = [before, now].map((light) => pointOf(light, command.point));
      return from == null || to == null ? [] : [movedText(from, to), ...thinnerText(before, now)];
    }
    case "setPoint":
      return "radius" in command.parameter ? [`radius ${formatNumber(command.parameter.radius, 3)}`] : [];
    case "setLight":
      return "coneAngle" in command.parameter
        ? [`cone angle ${formatNumber(command.parameter.coneAngle, 2)}°`]
        : [];
    default:
      return [];
  }
}

/** A distance in units of the scene. */
const movedText = (from: Vec3, to: Vec3): string => `moved ${formatNumber(length(sub(to, from)), 3)}`;

/** The control point in the world. */
function pointOf(light: Light, point: number): Vec3 | null {
  const at = light.type === "bendy" ? light.points[point] : undefined;
  return at === undefined ? null : toWorld(light.transform, at);
}

/** Says by how much the radius shrinks that shrinks most, with radii that follow. */
function thinnerText(before: Light, now: Light): string[] {
  if (before.type !== "bendy" || now.type !== "bendy") return [];
  const shares = before.radii.map((radius, k) => (radius > 0 ? (now.radii[k] ?? radius) / radius : 1));
  const least = Math.min(1, ...shares);
  return least > 0.995 ? [] : [`radius down to ${Math.round(100 * least)} %`];
}

function degreesBetween(a: Quat, b: Quat): number {
  const [x, y, z, w] = compose(b, inverse(a));
  return (2 * Math.atan2(Math.hypot(x, y, z), Math.abs(w)) * 180) / Math.PI;
}
