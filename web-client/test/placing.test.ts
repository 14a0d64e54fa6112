import { expect, test } from "vitest";

import { project, type View, withAspect } from "../src/core/camera";
import { FORMATS, formatOf } from "../src/core/formats";
import { besideTheEye, brightnessFor, cameraOf } from "../src/core/placing";
import type { Camera } from "../src/core/protocol";
import { aboutAxis, compose, length, rotate, sub, unit, type Vec3 } from "../src/core/vector";

const LENSES: Camera["projection"][] = [
  { perspective: { yfov: 0.3, aspectRatio: 16 / 9, znear: 0.01 } },
  { perspective: { yfov: 1.8, aspectRatio: 16 / 9, znear: 0.01 } },
  { orthographic: { ymag: 2, aspectRatio: 16 / 9, znear: 0, zfar: 100 } },
];

/** Looks at `aim` from `away`, turned. */
function lookingAt(aim: Vec3, away: number, projection: Camera["projection"]): Camera {
  const rotation = compose(aboutAxis([0, 1, 0], 0.7), aboutAxis([1, 0, 0], -0.4));
  const back = rotate(rotation, [0, 0, away]);
  return {
    name: "",
    translation: [aim[0] + back[0], aim[1] + back[1], aim[2] + back[2]],
    rotation,
    projection,
  };
}

test("a new light is in sight and aimed at what is in the middle", () => {
  const aim: Vec3 = [1, 2, -3];
  for (const projection of LENSES) {
    const camera = lookingAt(aim, 6, projection);
    const view: View = { camera, width: 1600, height: 900 };
    for (const place of besideTheEye(camera, aim)) {
      const at = project(view, place.translation);
      expect(at !== null && at.x > 0 && at.x < 1600 && at.y > 0 && at.y < 450).toBe(true);
      const shines = rotate(place.rotation, [0, 0, -1]);
      const way = sub(aim, place.translation);
      // Rotations are normalised in doubles: what is left is their rounding.
      expect(length(sub(shines, unit(way)))).toBeLessThan(1e-12);
      expect(place.distance).toBeCloseTo(length(way), 12);
      const seen = project({ camera: cameraOf(place), width: 2, height: 2 }, aim);
      expect([seen?.x, seen?.y].map((side) => side?.toFixed(9))).toEqual(["1.000000000", "1.000000000"]);
    }
  }
});

test("what is at the aim gets an irradiance of pi, whatever the decay", () => {
  for (const distance of [0.03, 1, 740]) {
    const arrives = {
      none: brightnessFor("none", distance),
      linear: brightnessFor("linear", distance) / distance,
      inverseSquare: brightnessFor("inverseSquare", distance) / distance ** 2,
    };
    // Three digits are kept.
    for (const irradiance of Object.values(arrives)) {
      expect(Math.abs(irradiance / Math.PI - 1)).toBeLessThan(0.005);
    }
  }
});

test("a format is known by its ratio, rounded as files round it", () => {
  for (const { label, aspect } of FORMATS) {
    expect(formatOf(Number(aspect.toFixed(4)))?.label).toBe(label);
    expect(formatOf(aspect * 1.002)).toBeUndefined();
  }
  const camera = lookingAt([0, 0, 0], 1, { perspective: { yfov: 1, znear: 0.1 } });
  expect(withAspect(camera, 2.39).projection).toEqual({
    perspective: { yfov: 1, znear: 0.1, aspectRatio: 2.39 },
  });
});
