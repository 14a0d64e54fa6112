// Displayed parts of a probe's answer, in their order.

import type { LightId } from "./ids";
import type { Probed, ProbedLight } from "./protocol";
import { add, dot, length, scale, sub, type Vec3 } from "./vector";

/** The lights that matter most: what gives most, what is only kept from it, the others; and how many are left out. */
export function mattering(found: Probed, most: number): { lights: ProbedLight[]; left: number } {
  const rank = ({ share, state }: ProbedLight) => share + (state === "shadowed" ? 0 : share > 0 ? 1 : -1);
  const lights = [...found.lights].sort((a, b) => rank(b) - rank(a) || a.light - b.light);
  return { lights: lights.slice(0, most), left: Math.max(0, lights.length - most) };
}

/** The light whose way is drawn: the selected one where light of it goes here, else what gives most. */
export function drawnWay(found: Probed, selected: LightId | null): ProbedLight | null {
  const going = mattering(found, found.lights.length).lights.filter(
    ({ state, path }) => (state === "lit" || state === "shadowed") && path.length > 1,
  );
  return going.find(({ light }) => light === selected) ?? going[0] ?? null;
}

/** The polyline up to its point nearest to `at`, and from there on. */
export function splitAt(path: readonly Vec3[], at: Vec3): { before: Vec3[]; after: Vec3[] } {
  let nearest = { segment: 0, point: path[0] ?? at, distance: Infinity };
  for (const [segment, end] of path.slice(1).entries()) {
    const start = path[segment] ?? end;
    const along = sub(end, start);
    const squared = dot(along, along);
    const share = squared === 0 ? 0 : Math.min(1, Math.max(0, dot(sub(at, start), along) / squared));
    const point = add(start, scale(along, share));
    const distance = length(sub(at, point));
    if (distance < nearest.distance) nearest = { segment, point, distance };
  }
  const { segment, point } = nearest;
  return {
    before: [...path.slice(0, segment + 1), point],
    after: [point, ...path.slice(segment + 1)],
  };
}
