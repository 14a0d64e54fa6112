// Results of probes for tests.

import type { Probed, ProbedLight } from "../src/core/protocol";

const place = {
  t: 1,
  v: 0,
  w: 0,
  radius: 1,
  pathLength: 1,
  direction: [0, 1, 0] as [number, number, number],
};

export function probed(light: number, state: ProbedLight["state"], gives: number): ProbedLight {
  const isLit = state === "lit";
  return {
    light,
    name: `light ${light}`,
    state,
    disabledBy: null,
    shadowedBy: state === "shadowed" ? { node: "vase", position: [0, 1, 0] } : null,
    place,
    irradiance: [gives, gives, gives],
    radiance: isLit ? [gives, gives, gives] : [0, 0, 0],
    share: isLit ? 1 : 0,
    path: [],
  };
}

export function found(...lights: ProbedLight[]): Probed {
  const seen = {
    node: "table",
    material: null,
    position: [1, 2, 3],
    normal: [0, 1, 0],
    depth: 1,
    fill: [0, 0, 0],
  };
  return { seen, lights } as Probed;
}
