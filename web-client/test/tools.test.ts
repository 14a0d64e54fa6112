import { expect, test } from "vitest";

import type { Light, Probed, ProbedLight } from "../src/core/protocol";
import {
  featureDrag,
  movingPoints,
  nothingTaken,
  outcomeText,
  pinAt,
  pinText,
  pinsOf,
  takenLight,
} from "../src/core/tools";
import { EMPTY } from "../src/core/document";

const place = {
  t: 1,
  v: 0,
  w: 0,
  radius: 1,
  pathLength: 1,
  direction: [0, 1, 0] as [number, number, number],
};

function probed(light: number, state: ProbedLight["state"], gives: number): ProbedLight {
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

function found(...lights: ProbedLight[]): Probed {
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

test("the light that makes what is under the pointer is taken", () => {
  const all = found(
    probed(1, "lit", 2),
    probed(2, "shadowed", 5),
    probed(3, "shadowed", 7),
    probed(4, "outside", 0),
  );
  expect(takenLight("shadow", all, null)?.light).toBe(3);
  expect(takenLight("shadow", all, 2)?.light, "the selected one counts enough").toBe(2);
  expect(takenLight("shadow", all, 1)?.light, "the selected one throws no shadow here").toBe(3);
  expect(takenLight("hotspot", all, 3)?.light).toBe(1);
  const faint = found(probed(1, "lit", 1), probed(2, "lit", 9));
  expect(takenLight("highlight", faint, 1)?.light, "nobody means what can hardly be seen").toBe(2);
  expect(takenLight("diffuse", found(probed(2, "shadowed", 5)), 2)).toBeNull();
  expect(nothingTaken("shadow", faint)).toContain("No shadow");
});

test("a light follows as a whole, or by the control points that do not rest", () => {
  const bendy = { type: "bendy", points: [0, 1, 2, 3].map((z) => [0, 0, -z]) } as unknown as Light;
  const following = { bends: true, resting: new Set([2]), radii: "solve", sourceOutside: true } as const;
  expect(movingPoints(bendy, following)).toEqual([1, 3]);
  expect(movingPoints(bendy, { ...following, bends: false })).toBeUndefined();
  expect(movingPoints({ type: "spot" } as Light, following)).toBeUndefined();
  const camera = {} as Parameters<typeof featureDrag>[3]["camera"];
  const seen = { camera, size: { width: 64, height: 36 } };
  const way: Parameters<typeof featureDrag>[4] = [
    { x: 1, y: 2 },
    { x: 3, y: 4 },
  ];
  const bent = featureDrag("shadow", [7, bendy], following, seen, way);
  expect(bent).toMatchObject({
    light: 7,
    points: [1, 3],
    radii: "solve",
    size: [64, 36],
    from: [1, 2],
    to: [3, 4],
  });
  const whole = featureDrag("shadow", [7, bendy], { ...following, bends: false }, seen, way);
  expect(whole).toMatchObject({ radii: "keep" });
  expect("points" in whole).toBe(false);
  expect(whole).toHaveProperty("sourceOutside", true);
  expect(
    featureDrag("shadow", [7, bendy], { ...following, sourceOutside: false }, seen, way),
  ).not.toHaveProperty("sourceOutside");
});

test("what keeps a drag short is said", () => {
  const outcome = {
    solver: "flow",
    version: 1,
    iterations: 3,
    fromWorld: null,
    toWorld: null,
    pivotWorld: null,
  };
  const limited = {
    ...outcome,
    status: "limited",
    limit: "fold",
    residualPx: 2.345,
    shadowedBy: null,
  } as const;
  expect(outcomeText(limited)).toBe("2.3 px short: the tube would fold");
  expect(outcomeText({ ...limited, residualPx: null })).toBe("Out of the picture: the tube would fold");
  const landed = { ...outcome, status: "landed", residualPx: 0, shadowedBy: null } as const;
  expect(outcomeText(landed)).toBeNull();
  expect(outcomeText({ ...landed, shadowedBy: "lamp" })).toBe("lamp shadows this too");
});

test("only what is so can be pinned", () => {
  const lit = found(probed(1, "lit", 1));
  const dark = found(probed(1, "shadowed", 1));
  expect(pinAt({ kind: "lit", hard: true, ofObject: false }, 1, lit)).toEqual({
    kind: "lit",
    light: 1,
    at: [1, 2, 3],
    hard: true,
  });
  expect(pinAt({ kind: "lit", hard: true, ofObject: false }, 1, dark)).toContain("pin what it lights");
  expect(pinAt({ kind: "shadow", hard: false, ofObject: false }, 1, dark)).toMatchObject({
    caster: "vase",
    hard: false,
  });
  expect(pinAt({ kind: "shadowed", hard: false, ofObject: false }, 1, dark)).not.toHaveProperty("caster");
  expect(pinAt({ kind: "shadow", hard: false, ofObject: false }, 1, lit)).toContain("No shadow");
  const outside = { ...probed(1, "outside", 0), place: null };
  const look = { kind: "look", hard: true, ofObject: true } as const;
  expect(pinAt(look, 1, found(outside))).toContain("outside the light");
  expect(pinAt(look, 1, { seen: null, lights: [] })).toContain("Nothing is seen");
  expect(pinAt(look, 1, lit)).toEqual({ kind: "look", light: 1, at: lit.seen?.node, hard: true });
});

test("a pin is named by its kind and its object", () => {
  const pin = { kind: "look", light: 1, at: "table/blue vase", hard: true } as const;
  expect(pinText(pin)).toBe("Look of blue vase");
  expect(pinText({ ...pin, kind: "coordinates", at: [0, 1, 2] })).toBe("Light coordinates");
  expect(pinText({ ...pin, kind: "shadow", at: [0, 1, 2], caster: "lamp" })).toBe("This shadow of lamp");
});

test("pins of a light that is gone are not shown", () => {
  const pin = { kind: "lit", light: 5, at: [0, 0, 0], hard: true } as const;
  expect(pinsOf({ ...EMPTY, pins: [{ id: 9, pin: { ...pin, at: [0, 0, 0] } }] }, 5)).toEqual([]);
});
