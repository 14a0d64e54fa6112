import { expect, test } from "vitest";

import { EMPTY } from "../src/core/document";
import { atPin, isNode, pinHolds } from "../src/core/pin_state";
import { pinAt, pinsOf, pinText } from "../src/core/pins";
import type { Pin } from "../src/core/protocol";
import { found, probed } from "./probes";

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
  expect(pinText({ ...pin, kind: "lit", at: [0, 1, 2] }, "room/table")).toBe("Lit on table");
  expect(pinText({ ...pin, kind: "shadow", at: [0, 1, 2], caster: "lamp" })).toBe("This shadow of lamp");
});

test("pins of a light that is gone are not shown", () => {
  const pin = { kind: "lit", light: 5, at: [0, 0, 0], hard: true } as const;
  expect(pinsOf({ ...EMPTY, pins: [{ id: 9, pin: { ...pin, at: [0, 0, 0] } }] }, 5)).toEqual([]);
});

const PIN: Pin = { kind: "lit", light: 1, at: [1, 2, 3], hard: true };

test("a pin is broken where the light no longer does what it keeps", () => {
  const [lit, dark] = [probed(1, "lit", 1), probed(1, "shadowed", 1)];
  expect(pinHolds(PIN, lit, null)).toBe(true);
  expect(pinHolds(PIN, dark, null)).toBe(false);
  expect(pinHolds({ ...PIN, kind: "shadowed" }, dark, null)).toBe(true);
  expect(pinHolds({ ...PIN, kind: "shadowed" }, lit, null)).toBe(false);
  expect(pinHolds({ ...PIN, kind: "shadow", caster: "vase" }, dark, null)).toBe(true);
  expect(pinHolds({ ...PIN, kind: "shadow", caster: "lamp" }, dark, null), "another's shadow").toBe(false);
  expect(pinHolds({ ...PIN, kind: "look" }, lit, "lit")).toBe(true);
  expect(pinHolds({ ...PIN, kind: "look" }, lit, "shadowed"), "it was dark").toBe(false);
  expect(pinHolds({ ...PIN, kind: "look" }, lit, null), "nobody knows what it was").toBeNull();
  expect(pinHolds({ ...PIN, kind: "direction" }, { ...dark, place: null }, null)).toBe(false);
  expect(pinHolds(PIN, probed(1, "disabled", 0), null), "a light that is off says nothing").toBeNull();
});

test("a pinned point is judged only where the probe sees it", () => {
  const seen = found(probed(1, "lit", 1), probed(2, "lit", 1));
  expect(atPin(PIN, [1, 2, 3], seen)?.light).toBe(1);
  expect(atPin({ ...PIN, light: 2 }, [1, 2, 3], seen)?.light).toBe(2);
  expect(atPin(PIN, [1, 2, 3.1], seen), "something else is in front of it").toBeNull();
  expect(atPin(PIN, [1, 2, 3], { seen: null, lights: [] })).toBeNull();
});

test("a node is meant by its path, its name, or one above it", () => {
  expect(isNode("room/vase", "room/vase")).toBe(true);
  expect(isNode("room/vase/rim", "room/vase")).toBe(true);
  expect(isNode("room/vase", "vase")).toBe(true);
  expect(isNode("room/vase 2", "room/vase")).toBe(false);
  expect(isNode(undefined, "vase")).toBe(false);
});
