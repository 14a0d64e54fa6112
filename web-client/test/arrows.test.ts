import { expect, test } from "vitest";

import { type Arrow, arrowName, arrowsOf, grabArrow, spanOf } from "../src/core/arrows";
import { type Pixel, project, screenVelocity, type View } from "../src/core/camera";
import { predict } from "../src/core/document";
import { type Drawn, positionOf } from "../src/core/handles";
import { tubeOf } from "../src/core/outline";
import type { Camera, Light } from "../src/core/protocol";
import { aboutAxis, add, compose, dot, length, rotate, scale, sub, type Vec3 } from "../src/core/vector";
import { BENDY, CAMERA, DOCUMENT, seeded, SPOT, unhindered } from "./examples";
import { TABLE } from "./parameters_fixture";

const TURNED = compose(aboutAxis([0, 1, 0], 0.4), aboutAxis([1, 0, 0], -0.3));
const PERSPECTIVE: View = {
  camera: { ...CAMERA, translation: [1.5, 3.5, 4.5], rotation: TURNED },
  width: 900,
  height: 600,
};
const ORTHOGRAPHIC: View = {
  ...PERSPECTIVE,
  camera: {
    ...PERSPECTIVE.camera,
    projection: { orthographic: { ymag: 3, znear: 0, zfar: 100 } },
  },
};
const VIEWS = [PERSPECTIVE, ORTHOGRAPHIC];

const drawn = (light: Light, view: View): Drawn => ({
  id: 1,
  light,
  tube: tubeOf(light, 2),
  view,
  radii: "keep",
});

const seen = (view: View, point: Vec3): Pixel => {
  const pixel = project(view, point);
  if (pixel === null) throw new Error("it is not seen");
  return pixel;
};

/** Position of the thing that `arrow` moves after the pointer went by `by` from the arrow's tip. */
function pulledTo(arrow: Arrow, light: Light, view: View, by: Pixel): Vec3 {
  const start = drawn(light, view);
  const tip = spanOf(arrow, start)?.tip ?? { x: NaN, y: NaN };
  const command = grabArrow(arrow, start, tip)({ x: tip.x + by.x, y: tip.y + by.y });
  const document = { ...DOCUMENT, lights: [{ id: 1, layout: 1, light }] };
  const after = predict(TABLE, document, unhindered(command)).lights[0]?.light ?? light;
  return positionOf(arrow.moves, drawn(after, view));
}

/** Rounding of some dozens of operations on numbers up to 1e3. */
const ROUNDING = 1e-9;

test("what is selected has its arrows: a control point, or the source", () => {
  const moved = (light: Light, point: number | null) => arrowsOf(light, point)[0]?.moves;
  expect(moved(BENDY, 2)).toEqual({ kind: "point", point: 2 });
  for (const point of [null, 0, 99]) expect(moved(BENDY, point)).toEqual({ kind: "source" });
  expect(moved(SPOT, 2)).toEqual({ kind: "source" });
  expect(arrowsOf(BENDY, 2).map(arrowName)).toEqual(["pull-x", "pull-y", "pull-z", "pull-depth"]);
});

test("the velocity on the screen is what projecting two near points gives", () => {
  const random = seeded(5);
  for (const view of VIEWS) {
    for (let k = 0; k < 50; k += 1) {
      const point: Vec3 = [random() * 2 - 1, random() * 2, random() * 2 - 4];
      const direction: Vec3 = [random() - 0.5, random() - 0.5, random() - 0.5];
      const step = 1e-5;
      const [a, b] = [-step, step].map((by) => seen(view, add(point, scale(direction, by))));
      const { x, y } = screenVelocity(view, point, direction);
      // Central differences have an error of their step squared, and the rounding of pixels over the step.
      expect(Math.abs((b?.x ?? NaN) - (a?.x ?? NaN) - 2 * step * x) / (2 * step)).toBeLessThan(1e-5);
      expect(Math.abs((b?.y ?? NaN) - (a?.y ?? NaN) - 2 * step * y) / (2 * step)).toBeLessThan(1e-5);
    }
  }
});

test("an axis arrow moves along its axis alone, to beside the pointer", () => {
  for (const view of VIEWS) {
    for (const point of [2, null]) {
      for (const arrow of arrowsOf(BENDY, point).filter(({ way }) => way !== "depth")) {
        const before = positionOf(arrow.moves, drawn(BENDY, view));
        const span = spanOf(arrow, drawn(BENDY, view));
        if (span === null) throw new Error("the arrow is not seen");
        const along = { x: span.tip.x - span.tail.x, y: span.tip.y - span.tail.y };
        const size = Math.hypot(along.x, along.y);
        for (const by of [
          { x: 37, y: -12 },
          { x: -55, y: 20 },
        ]) {
          const after = pulledTo(arrow, BENDY, view, by);
          const way = sub(after, before);
          const others = way.filter((_, axis) => axis !== arrow.way);
          expect(Math.max(...others.map(Math.abs))).toBeLessThan(ROUNDING);
          const [from, to] = [seen(view, before), seen(view, after)];
          const wanted = (by.x * along.x + by.y * along.y) / size;
          expect(((to.x - from.x) * along.x + (to.y - from.y) * along.y) / size).toBeCloseTo(wanted, 6);
        }
      }
    }
  }
});

test("the depth arrow moves along the way to the eye, and never behind it", () => {
  for (const view of VIEWS) {
    const [arrow] = arrowsOf(BENDY, 2).filter(({ way }) => way === "depth");
    if (arrow === undefined) throw new Error("there is no such arrow");
    const span = spanOf(arrow, drawn(BENDY, view)) ?? { tail: { x: 0, y: 0 }, tip: { x: 0, y: 0 } };
    const arrowLength = Math.hypot(span.tip.x - span.tail.x, span.tip.y - span.tail.y);
    const by = (px: number): Pixel => ({
      x: ((span.tip.x - span.tail.x) / arrowLength) * px,
      y: ((span.tip.y - span.tail.y) / arrowLength) * px,
    });
    const before = positionOf(arrow.moves, drawn(BENDY, view));
    const eye = view.camera.translation;
    const depths = [-4000, -30, 0, 30].map((px) => {
      const after = pulledTo(arrow, BENDY, view, by(px));
      const [from, to] = [seen(view, before), seen(view, after)];
      // A far point is a small difference of large numbers.
      expect(Math.hypot(to.x - from.x, to.y - from.y)).toBeLessThan(1e-6);
      return length(sub(after, eye));
    });
    expect(depths).toEqual([...depths].sort((a, b) => b - a));
    if (view === PERSPECTIVE) {
      const near = pulledTo(arrow, BENDY, view, by(4000));
      expect(dot(sub(near, eye), sub(before, eye))).toBeGreaterThan(0);
    }
  }
});

test("where an axis is seen end on it has no arrow, and towards its vanishing point nothing leaps", () => {
  const ahead: Camera = { ...CAMERA, translation: [0, 2, 4.5] };
  const view: View = { camera: ahead, width: 900, height: 600 };
  const shown = arrowsOf(BENDY, null).map((arrow) => spanOf(arrow, drawn(BENDY, view)) !== null);
  expect(shown).toEqual([true, true, false, true]);
  const z = arrowsOf(BENDY, 2)[2] as Arrow;
  const before = positionOf(z.moves, drawn(BENDY, PERSPECTIVE));
  for (const px of [-1e5, -1e3, 1e3, 1e5]) {
    const after = pulledTo(z, BENDY, PERSPECTIVE, { x: px, y: px });
    expect(length(sub(after, before))).toBeLessThan(1e5);
  }
});

test("the depth arrow keeps clear of the axes, wherever it is looked at from", () => {
  const random = seeded(9);
  let nearest = Math.PI;
  for (let k = 0; k < 500; k += 1) {
    const rotation = compose(aboutAxis([0, 1, 0], random() * 7), aboutAxis([1, 0, 0], random() * 3 - 1.5));
    const translation = add(BENDY.transform.translation, rotate(rotation, [0, 0, 6]));
    const view: View = { ...PERSPECTIVE, camera: { ...CAMERA, rotation, translation } };
    const angles = arrowsOf(BENDY, null).map((arrow) => {
      const span = spanOf(arrow, drawn(BENDY, view));
      return span === null ? null : Math.atan2(span.tip.y - span.tail.y, span.tip.x - span.tail.x);
    });
    const depth = angles.pop() ?? NaN;
    for (const angle of angles) {
      if (angle === null) continue;
      nearest = Math.min(nearest, Math.abs(Math.atan2(Math.sin(angle - depth), Math.cos(angle - depth))));
    }
  }
  expect(nearest).toBeGreaterThanOrEqual(0.45);
});
