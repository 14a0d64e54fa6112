import { expect, test } from "vitest";

import { depthOf, type Pixel, project, type View } from "../src/core/camera";
import { abscissa } from "../src/core/curve";
import { predict } from "../src/core/document";
import {
  type Drawn,
  grab,
  type Handle,
  handlesOf,
  positionOf,
  turnAxis,
  turnRadius,
} from "../src/core/handles";
import { arrowHead, circle, ringAt, sideways, silhouette, sphereOf, tubeOf } from "../src/core/outline";
import type { Light } from "../src/core/protocol";
import { add, cross, dot, perpendicular, rotate, scale, sub } from "../src/core/vector";
import { BENDY, CAMERA, DIRECTIONAL, DOCUMENT, OMNI, SPOT, unhindered } from "./examples";
import { TABLE } from "./parameters_fixture";

const VIEW: View = { camera: CAMERA, width: 900, height: 600 };
const REACH = 2;

const drawn = (light: Light): Drawn => ({
  id: 1,
  light,
  tube: tubeOf(light, REACH),
  view: VIEW,
  radii: "keep",
});

/** The light after `handle` was dragged by `way`, and where that handle should be and is then. */
function dragged(light: Light, handle: Handle, way: Pixel) {
  const start = project(VIEW, positionOf(handle, drawn(light))) ?? { x: NaN, y: NaN };
  const to = { x: start.x + way.x, y: start.y + way.y };
  const command = grab(handle, drawn(light), start)(to);
  const document = predict(
    TABLE,
    { ...DOCUMENT, lights: [{ id: 1, layout: 1, light }] },
    unhindered(command),
  );
  const after = document.lights[0]?.light ?? light;
  return { to, at: project(VIEW, positionOf(handle, drawn(after))) ?? start, after };
}

const distance = (a: Pixel, b: Pixel) => Math.hypot(a.x - b.x, a.y - b.y);

// Rounding of some dozens of operations on pixels up to 1e3; see camera.test.ts.
const PIXEL_ROUNDING = 1e-9;

test("a control point and the source end under the pointer", () => {
  const handles: Handle[] = [{ kind: "source" }, ...handlesOf(BENDY).filter(({ kind }) => kind === "point")];
  expect(handles).toHaveLength(4);
  for (const handle of handles) {
    const { to, at } = dragged(BENDY, handle, { x: 41, y: -17 });
    expect(distance(to, at)).toBeLessThan(PIXEL_ROUNDING);
  }
});

test("a control point is dragged with radii as the page has chosen", () => {
  const handle: Handle = { kind: "point", point: 2 };
  for (const radii of ["keep", "follow"] as const) {
    const start = { ...drawn(BENDY), radii };
    const at = project(VIEW, positionOf(handle, start)) ?? { x: NaN, y: NaN };
    expect(grab(handle, start, at)(at)).toMatchObject({ type: "dragPoint", light: 1, point: 2, radii });
  }
});

test("a drag that ends where it began changes nothing, whatever lay between", () => {
  const handle: Handle = { kind: "point", point: 2 };
  const start = project(VIEW, positionOf(handle, drawn(BENDY))) ?? { x: 0, y: 0 };
  const command = grab(handle, drawn(BENDY), start);
  const once = command({ x: 300, y: 200 });
  command({ x: 10, y: 20 });
  expect(command({ x: 300, y: 200 })).toEqual(once);
});

test("the tube's edge follows the pointer across the tube", () => {
  for (const point of BENDY.points.keys()) {
    const handle: Handle = { kind: "radius", point };
    const { tube } = drawn(BENDY);
    const t = abscissa(BENDY.points.length, point);
    const edge = positionOf(handle, drawn(BENDY));
    // A way along the tube's own side, so that the edge can go all of it.
    const ahead = project(VIEW, add(edge, scale(sideways(tube, t, CAMERA), 0.05)));
    const start = project(VIEW, edge);
    if (ahead === null || start === null) throw new Error("the handle is not seen");
    const { to, at, after } = dragged(BENDY, handle, { x: ahead.x - start.x, y: ahead.y - start.y });
    // The pointer moves in the picture's plane, the edge across the tube: the same as far as that lies in it.
    expect(distance(to, at)).toBeLessThan(0.35 * distance(to, start));
    expect(after.type === "bendy" && (after.radii[point] ?? 0) > (BENDY.radii[point] ?? 0)).toBe(true);
  }
});

test("a radius never becomes negative", () => {
  const { after } = dragged(BENDY, { kind: "radius", point: 1 }, { x: -4000, y: -4000 });
  const { after: other } = dragged(BENDY, { kind: "radius", point: 1 }, { x: 4000, y: 4000 });
  const radii = [after, other].map((light) => (light.type === "bendy" ? light.radii[1] : NaN));
  expect(Math.min(...(radii as number[]))).toBe(0);
});

test("a ring turns with the pointer wherever its near half is grabbed, and the light's source stays", () => {
  const start = drawn(BENDY);
  const source = BENDY.transform.translation;
  let grabbed = 0;
  for (const axis of [0, 1, 2] as const) {
    const about = turnAxis(BENDY, axis);
    const radius = turnRadius(start);
    for (const onRing of circle(source, about, radius)) {
      if (depthOf(CAMERA, onRing) > depthOf(CAMERA, source) - 0.2 * radius) continue;
      grabbed += 1;
      const radians = 0.001;
      const ahead = add(onRing, scale(cross(about, sub(onRing, source)), radians));
      const [from, to] = [project(VIEW, onRing), project(VIEW, ahead)];
      if (from === null || to === null) throw new Error("the ring is not seen");
      const command = grab({ kind: "turn", axis }, start, from)(to);
      if (command.type !== "placeLight" || command.rotation === undefined) throw new Error("no rotation");
      expect(command.translation).toBeUndefined();
      const arm = perpendicular(about);
      const angle = Math.asin(dot(rotate(command.rotation, arm), cross(about, arm)));
      expect(angle).toBeGreaterThan(0);
      // The ring is grabbed at the nearest of 96 points, within 1.9 degrees: 1 / cos is 1.0006; perspective
      // over a step of the ring adds less than a hundredth.
      expect(angle).toBeLessThan(radians * 1.02);
    }
  }
  expect(grabbed).toBeGreaterThan(20);
});

test("a spotlight's cone opens and closes within the model's angles", () => {
  const handle = handlesOf(SPOT)[0];
  expect(handle).toEqual({ kind: "cone" });
  const angles = [-4000, -20, 0, 20, 4000].map((x) => {
    const { after } = dragged(SPOT, { kind: "cone" }, { x: 0, y: x });
    return after.type === "spot" ? after.coneAngle : NaN;
  });
  expect(angles[2]).toBeCloseTo(SPOT.coneAngle, 9);
  expect(Math.min(...angles)).toBeGreaterThan(0);
  expect(Math.max(...angles)).toBeLessThan(90);
  expect(new Set(angles).size).toBe(5);
});

test("omni and directional lights are moved and turned", () => {
  for (const light of [OMNI, DIRECTIONAL]) {
    expect(handlesOf(light)).toEqual([]);
    const { to, at } = dragged(light, { kind: "source" }, { x: 41, y: -17 });
    expect(distance(to, at)).toBeLessThan(PIXEL_ROUNDING);
    const { after } = dragged(light, { kind: "turn", axis: 1 }, { x: 60, y: 9 });
    expect(after.transform.rotation).not.toEqual(light.transform.rotation);
  }
});

test("an omni light is a sphere of its range, a directional light parallel lines", () => {
  const spheres = sphereOf(drawn({ ...OMNI, range: 3 }).tube, OMNI.transform.rotation);
  expect(spheres).toHaveLength(3);
  for (const point of spheres.flat()) {
    expect(Math.hypot(...sub(point, OMNI.transform.translation))).toBeCloseTo(3, 12);
  }
  const { tube } = drawn({ ...DIRECTIONAL, width: 4 });
  expect(tube.radii).toEqual([2, 2, 2]);
  const axis = rotate(DIRECTIONAL.transform.rotation, [0, 0, -1]);
  const { right, left } = silhouette(tube, CAMERA);
  const ends = [right.at(-1), left.at(-1), arrowHead(tube, CAMERA)[1]];
  for (const end of ends) {
    const along = dot(sub(end ?? [NaN, NaN, NaN], DIRECTIONAL.transform.translation), axis);
    expect(along).toBeCloseTo(REACH, 12);
  }
});

test("rings are round, closed and across the tube", () => {
  const { tube } = drawn(BENDY);
  const ring = ringAt(tube, 1);
  const first = ring[0] ?? [NaN, NaN, NaN];
  const last = ring.at(-1) ?? [NaN, NaN, NaN];
  // cos and sin of 2 pi are off by 2.5e-16.
  expect(Math.hypot(first[0] - last[0], first[1] - last[1], first[2] - last[2])).toBeLessThan(1e-15);
});
