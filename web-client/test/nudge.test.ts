import { expect, test } from "vitest";

import { depthOf, type Pixel, project, type View } from "../src/core/camera";
import { predict } from "../src/core/document";
import { type Drawn, type Handle, handlesOf, positionOf } from "../src/core/handles";
import { NO_STEPS, nudge, STEP_PX, type Steps } from "../src/core/nudge";
import { tubeOf } from "../src/core/outline";
import type { Light } from "../src/core/protocol";
import { aboutAxis, toEulerDegrees } from "../src/core/vector";
import { BENDY, CAMERA, DOCUMENT, SPOT, unhindered } from "./examples";
import { TABLE } from "./parameters_fixture";

/** Looks down and a little to the side, so that no axis of the world is one of the picture. */
const VIEW: View = {
  camera: { ...CAMERA, rotation: aboutAxis([0.8, 0.6, 0], -0.3) },
  width: 900,
  height: 600,
};

const drawn = (light: Light): Drawn => ({ id: 1, light, tube: tubeOf(light, 2), view: VIEW, radii: "keep" });

/** The light after so many steps of `handle`. */
function nudged(handle: Handle, steps: Partial<Steps>): Light {
  const command = unhindered(nudge(handle, drawn(BENDY))({ ...NO_STEPS, ...steps }));
  return (
    predict(TABLE, { ...DOCUMENT, lights: [{ id: 1, layout: 1, light: BENDY }] }, command).lights[0]?.light ??
    BENDY
  );
}

function seen(handle: Handle, light: Light): Pixel & { depth: number } {
  const position = positionOf(handle, drawn(light));
  return { ...(project(VIEW, position) ?? { x: NaN, y: NaN }), depth: depthOf(VIEW.camera, position) };
}

const MOVED: Handle[] = [{ kind: "source" }, ...handlesOf(BENDY).filter(({ kind }) => kind === "point")];
// Rounding of some dozens of operations on pixels up to 1e3; see camera.test.ts.
const PIXEL_ROUNDING = 1e-9;

test("steps move in the picture's plane, as many pixels for all depths", () => {
  expect(MOVED).toHaveLength(4);
  for (const handle of MOVED) {
    const from = seen(handle, BENDY);
    const to = seen(handle, nudged(handle, { right: 3, up: 10 }));
    expect(Math.abs(to.x - from.x - 3 * STEP_PX)).toBeLessThan(PIXEL_ROUNDING);
    expect(Math.abs(to.y - from.y + 10 * STEP_PX)).toBeLessThan(PIXEL_ROUNDING);
    expect(Math.abs(to.depth - from.depth)).toBeLessThan(PIXEL_ROUNDING);
    // The planted fault: a step more.
    expect(Math.abs(seen(handle, nudged(handle, { right: 4 })).x - from.x - 3 * STEP_PX)).toBeGreaterThan(1);
  }
});

test("steps away from the eye and back change the depth", () => {
  for (const handle of MOVED) {
    const { depth } = seen(handle, BENDY);
    expect(seen(handle, nudged(handle, { away: 5 })).depth).toBeGreaterThan(depth);
    expect(seen(handle, nudged(handle, { away: -5 })).depth).toBeLessThan(depth);
  }
});

test("to the right and upwards is larger, to the left and downwards smaller", () => {
  const radius = (steps: Partial<Steps>) => {
    const light = nudged({ kind: "radius", point: 2 }, steps);
    return light.type === "bendy" ? (light.radii[2] ?? NaN) : NaN;
  };
  const before = radius({});
  expect(before).toBeCloseTo(BENDY.radii[2] ?? NaN, 12);
  for (const more of [{ right: 4 }, { up: 4 }]) expect(radius(more)).toBeGreaterThan(before);
  for (const less of [{ right: -4 }, { up: -4 }]) expect(radius(less)).toBeLessThan(before);
  expect(radius({ right: -1e6 })).toBe(0);
});

test("arrows open and close a spotlight's cone, within the model's angles", () => {
  const spot: Light = { ...SPOT, transform: BENDY.transform };
  const angle = (up: number) => {
    const command = nudge({ kind: "cone" }, drawn(spot))({ ...NO_STEPS, up });
    return command.type === "setLight" && "coneAngle" in command.parameter
      ? command.parameter.coneAngle
      : NaN;
  };
  expect(angle(0)).toBeCloseTo(spot.coneAngle, 9);
  expect(angle(5)).toBeGreaterThan(angle(1));
  expect(angle(-5)).toBeLessThan(angle(-1));
  expect([angle(-1e6), angle(1e6)].every((a) => a > 0 && a < 90)).toBe(true);
});

test("a ring turns by half a degree a step about its own axis", () => {
  const { rotation } = nudged({ kind: "turn", axis: 2 }, { up: 7 }).transform;
  const [x, y, z] = toEulerDegrees(rotation);
  expect([x, y].map(Math.abs)).toEqual([expect.closeTo(0, 9), expect.closeTo(0, 9)]);
  expect(z).toBeCloseTo(3.5, 9);
});
