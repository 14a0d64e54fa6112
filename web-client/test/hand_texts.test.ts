import { expect, test } from "vitest";

import { predict } from "../src/core/document";
import type { Command, Light } from "../src/core/protocol";
import { aboutAxis, compose } from "../src/core/vector";
import { handLines } from "../src/ui/hand_texts";
import { BENDY, DOCUMENT, SPOT } from "./examples";
import { TABLE } from "./parameters_fixture";

/** The lines about `command` at `light`, once it is done. */
function lines(light: Light, command: Command): string[] {
  const document = { ...DOCUMENT, lights: [{ id: 1, layout: 1, light }] };
  const [now] = predict(TABLE, document, command).lights;
  return handLines(command, light, now?.light ?? light);
}

test("a light that is moved or turned says how far", () => {
  const { translation, rotation } = BENDY.transform;
  const [x, y, z] = translation;
  expect(lines(BENDY, { type: "placeLight", light: 1, translation: [x + 3, y, z - 4] })).toEqual(["moved 5"]);
  const turned = compose(aboutAxis([0, 1, 0], Math.PI / 6), rotation);
  expect(lines(BENDY, { type: "placeLight", light: 1, rotation: turned })).toEqual(["turned 30°"]);
});

test("a control point is measured in units of the scene, as far as it has come", () => {
  const command: Command = { type: "dragPoint", light: 1, point: 1, position: [9, 9, 9], radii: "follow" };
  const moved = BENDY.points.map((p, k) => (k === 1 ? ([p[0] + 0.4, p[1], p[2]] as typeof p) : p));
  const now = { ...BENDY, points: moved };
  expect(handLines(command, BENDY, now), "at the light's scale of 1.5").toEqual(["moved 0.6"]);
  const radii = BENDY.radii.map((r, k) => (k === 2 ? 0.8 * r : r));
  expect(handLines(command, BENDY, { ...now, radii })).toEqual(["moved 0.6", "radius down to 80 %"]);
});

test("a size that is dragged says its value", () => {
  expect(lines(BENDY, { type: "setPoint", light: 1, point: 2, parameter: { radius: 0.25 } })).toEqual([
    "radius 0.25",
  ]);
  expect(lines(SPOT, { type: "setLight", light: 1, parameter: { coneAngle: 24.52 } })).toEqual([
    "cone angle 24.5°",
  ]);
  expect(lines(SPOT, { type: "setLight", light: 1, parameter: { intensity: 2 } })).toEqual([]);
});
