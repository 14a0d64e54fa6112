import { expect, test } from "vitest";

import { aimedAt, axisOf, cameraThrough } from "../src/core/aiming";
import { gateOf, project, type View } from "../src/core/camera";
import { tangentAt } from "../src/core/curve";
import { predict } from "../src/core/document";
import { type Drawn, type Movable, positionOf } from "../src/core/handles";
import { tubeOf } from "../src/core/outline";
import type { Bounds, Light, Probed, ProbedSurface } from "../src/core/protocol";
import { laidOn, snapping } from "../src/core/snapping";
import {
  aboutAxis,
  add,
  compose,
  cross,
  inverse,
  length,
  perpendicular,
  rotate,
  scale,
  sub,
  unit,
} from "../src/core/vector";
import { BENDY, CAMERA, DIRECTIONAL, DOCUMENT, OMNI, seeded, someVector, SPOT, unhindered } from "./examples";
import { TABLE } from "./parameters_fixture";

const LIGHTS: Light[] = [BENDY, SPOT, OMNI, DIRECTIONAL];
const BOUNDS: Bounds = { min: [-2, 0, -2], max: [2, 2, 2] };

/** `light` as `command` leaves it. */
function after(light: Light, command: Parameters<typeof predict>[2] | null): Light {
  if (command === null) throw new Error("there is no command");
  const document = { ...DOCUMENT, lights: [{ id: 1, layout: 1, light }] };
  return predict(TABLE, document, unhindered(command)).lights[0]?.light ?? light;
}

const turned = (light: Light): Light => ({
  ...light,
  transform: { ...light.transform, rotation: compose(aboutAxis([0, 1, 0], 0.8), aboutAxis([1, 0, 0], -0.5)) },
});

/** Rounding of a rotation and a normalisation. */
const ROUNDING = 1e-12;

test("a light's axis is how its light leaves the source", () => {
  const { points } = tubeOf(turned(BENDY), 2);
  expect(length(sub(axisOf(turned(BENDY)), unit(tangentAt(points, 0))))).toBeLessThan(ROUNDING);
  const ahead = rotate(turned(SPOT).transform.rotation, [0, 0, -1]);
  expect(length(sub(axisOf(turned(SPOT)), ahead))).toBeLessThan(ROUNDING);
});

test("an aimed light shines at its target, from where it was, turned the shortest way", () => {
  const random = seeded(3);
  for (const light of LIGHTS.map(turned)) {
    const source = light.transform.translation;
    const behind = sub(source, scale(axisOf(light), 3));
    const targets = [behind, ...Array.from({ length: 50 }, () => someVector(random, 5))];
    for (const target of targets) {
      const aimed = after(light, aimedAt(1, light, target));
      expect(aimed.transform.translation).toEqual(source);
      expect(length(sub(axisOf(aimed), unit(sub(target, source))))).toBeLessThan(1e-6);
      if (target === behind) continue;
      expect(length(sub(axisOf(aimed), unit(sub(target, source))))).toBeLessThan(1e-9);
      // A vector square to both directions does not change.
      const hinge = unit(cross(axisOf(light), sub(target, source)));
      const local = rotate(inverse(light.transform.rotation), hinge);
      expect(length(sub(rotate(aimed.transform.rotation, local), hinge))).toBeLessThan(1e-9);
    }
  }
  expect(aimedAt(1, SPOT, SPOT.transform.translation)).toBeNull();
});

test("who looks through a light sees what its cone holds, and no more in the gate", () => {
  for (const light of [turned(SPOT), turned({ ...BENDY, coneAngle: 33 })]) {
    const camera = cameraThrough(light, BOUNDS);
    expect(camera.translation).toEqual(light.transform.translation);
    const view: View = { camera, width: 900, height: 600 };
    const axis = axisOf(light);
    const middle = project(view, add(camera.translation, axis));
    expect(middle?.x).toBeCloseTo(450, 9);
    expect(middle?.y).toBeCloseTo(300, 9);
    const coneAngle = "coneAngle" in light ? light.coneAngle : NaN;
    const edge = scale(perpendicular(axis), Math.tan((coneAngle * Math.PI) / 180));
    const rim = project(view, add(camera.translation, add(axis, edge)));
    const gate = gateOf(view);
    // The cone's rim is a circle in the square of the gate.
    expect(gate.width).toBeCloseTo(gate.height, 9);
    expect(Math.hypot((rim?.x ?? NaN) - 450, (rim?.y ?? NaN) - 300)).toBeCloseTo(gate.height / 2, 9);
  }
});

test("a directional light is looked through from outside, at its window or at all of the scene", () => {
  const light = turned({ ...DIRECTIONAL, width: 3, height: 2 });
  const { rotation, translation } = light.transform;
  const view: View = { camera: cameraThrough(light, BOUNDS), width: 900, height: 600 };
  const corner = project(view, add(translation, rotate(rotation, [1.5, 1, 0])));
  const gate = gateOf(view);
  expect([corner?.x, corner?.y].map((x) => x?.toFixed(6))).toEqual([
    (gate.x + gate.width).toFixed(6),
    gate.y.toFixed(6),
  ]);
  const all: View = { camera: cameraThrough(turned(DIRECTIONAL), BOUNDS), width: 600, height: 600 };
  for (const x of [-2, 2]) {
    for (const z of [-2, 2]) {
      const seen = project(all, [x, 2, z]);
      expect(seen !== null && seen.x > 0 && seen.x < 600 && seen.y > 0 && seen.y < 600).toBe(true);
    }
  }
});

const SURFACE: ProbedSurface = {
  node: "table",
  material: null,
  position: [0.4, 0, -1],
  normal: [0, 1, 0],
  depth: 5,
  fill: [0, 0, 0],
};
const seen = (surface: ProbedSurface | null): Probed => ({ seen: surface, lights: [] });

test("what is laid on a surface lies there, the source a little above it", () => {
  const view: View = { camera: CAMERA, width: 900, height: 600 };
  const drawn = (light: Light): Drawn => ({ id: 1, light, tube: tubeOf(light, 2), view, radii: "keep" });
  const laid = (handle: Movable) =>
    positionOf(handle, drawn(after(BENDY, laidOn(handle, drawn(BENDY), SURFACE, BOUNDS))));
  expect(length(sub(laid({ kind: "point", point: 2 }), SURFACE.position))).toBeLessThan(1e-12);
  const [x, y, z] = laid({ kind: "source" });
  expect([x, z]).toEqual([0.4, -1]);
  // A ten-thousandth of the diagonal, which is 6.
  expect(y).toBeCloseTo(6e-4, 12);
});

test("a drag that ends before its last answer waits for it, and one that stops snapping waits for none", () => {
  const answers: ((found: Probed | null) => void)[] = [];
  const laid: number[] = [];
  const snap = snapping(
    (_, onProbed) => void answers.push(onProbed),
    ({ depth }) => void laid.push(depth),
  );
  const answer = (depth: number | null) =>
    answers.shift()?.(seen(depth === null ? null : { ...SURFACE, depth }));
  let ended = 0;
  const end = () => {
    ended += 1;
  };
  snap.to({ x: 1, y: 1 });
  snap.to({ x: 2, y: 2 });
  answer(1);
  snap.afterLast(end);
  expect([laid, ended]).toEqual([[1], 0]);
  answer(null);
  expect([laid, ended]).toEqual([[1], 1]);

  snap.to({ x: 3, y: 3 });
  snap.stop();
  answer(3);
  snap.afterLast(end);
  expect([laid, ended]).toEqual([[1], 2]);
});
