import { expect, test } from "vitest";

import {
  depthOf,
  gateOf,
  inPlaneOf,
  project,
  seeTheSame,
  type View,
  withShape,
  worldPerPixel,
} from "../src/core/camera";
import {
  fitBall,
  type Fingers,
  orbit,
  orbitFrom,
  pan,
  pinch,
  pivotOf,
  zoom,
  zoomTo,
} from "../src/core/navigation";
import type { Camera, Projection } from "../src/core/protocol";
import { add, fromEulerDegrees, length, rotate, sub, toEulerDegrees, unitQuat } from "../src/core/vector";
import { difference, seeded, someVector } from "./examples";

const PROJECTIONS: Projection[] = [
  { perspective: { yfov: 0.7, znear: 0.1 } },
  { orthographic: { ymag: 2, znear: 0, zfar: 100 } },
  { perspective: { yfov: 0.7, aspectRatio: 3, znear: 0.1 } },
  { orthographic: { ymag: 2, aspectRatio: 2.5, znear: 0, zfar: 100 } },
];
const BOUNDS = { min: [-2, 0, -2], max: [2, 2, 2] } as {
  min: [number, number, number];
  max: [number, number, number];
};

/** 200 cameras near the origin that look any way, of both projections. */
function cameras(): Camera[] {
  const next = seeded(1);
  return Array.from({ length: 200 }, (_, k) => ({
    name: "",
    translation: someVector(next, 5),
    rotation: unitQuat([next() - 0.5, next() - 0.5, next() - 0.5, next() - 0.5]),
    projection: PROJECTIONS[k % PROJECTIONS.length] as Projection,
  }));
}

const SIZE = { width: 640, height: 360 };
const view = (camera: Camera): View => ({ camera, ...SIZE });

// Some dozen operations on numbers up to 1e3 (pixels): rounding stays below 1e3 * 2^-52 * 100 = 2.2e-11.
const PIXEL_ROUNDING = 1e-9;
// The same on coordinates up to 10.
const WORLD_ROUNDING = 1e-11;

test("a point in the plane of the picture is seen under its pixel", () => {
  const next = seeded(2);
  for (const camera of cameras()) {
    const through = add(camera.translation, rotate(camera.rotation, [next(), next(), -1 - 4 * next()]));
    const pixel = { x: next() * 640, y: next() * 360 };
    const point = inPlaneOf(view(camera), pixel, through);
    const seen = project(view(camera), point);
    expect(seen).not.toBeNull();
    expect(Math.hypot((seen?.x ?? NaN) - pixel.x, (seen?.y ?? NaN) - pixel.y)).toBeLessThan(PIXEL_ROUNDING);
    expect(Math.abs(depthOf(camera, point) - depthOf(camera, through))).toBeLessThan(WORLD_ROUNDING);
  }
});

test("a picture of the wrong size is noticed", () => {
  const [camera] = cameras();
  if (camera === undefined) throw new Error("no camera");
  const point = inPlaneOf(
    view(camera),
    { x: 100, y: 100 },
    add(camera.translation, rotate(camera.rotation, [0, 0, -2])),
  );
  const seen = project({ ...view(camera), width: 642 }, point);
  expect(Math.abs((seen?.x ?? 100) - 100)).toBeGreaterThan(PIXEL_ROUNDING);
});

test("nothing behind the camera is seen", () => {
  for (const camera of cameras()) {
    expect(project(view(camera), add(camera.translation, rotate(camera.rotation, [0, 0, 1])))).toBeNull();
  }
});

test("what the view turns about or goes to stays under its pixel", () => {
  const next = seeded(11);
  for (const camera of cameras()) {
    const from = orbitFrom(camera, BOUNDS);
    const pixel = { x: 640 * next(), y: 360 * next() };
    const depth = add(from.camera.translation, rotate(from.camera.rotation, [0, 0, -2 - next()]));
    const about = inPlaneOf(view(from.camera), pixel, depth);
    const away = (after: Camera) => {
      const seen = project(view(after), about);
      return Math.hypot((seen?.x ?? NaN) - pixel.x, (seen?.y ?? NaN) - pixel.y);
    };
    const turned = orbit(from, 0.3, 0, about);
    expect(length(sub(turned.camera.translation, about))).toBeCloseTo(
      length(sub(from.camera.translation, about)),
      9,
    );
    expect(turned.distance).toBeCloseTo(depthOf(from.camera, about), 9);
    expect(away(turned.camera)).toBeLessThan(PIXEL_ROUNDING * 10);
    const still = inPlaneOf(view(from.camera), pixel, pivotOf(from));
    const nearer = zoomTo(from, 0.8, BOUNDS, SIZE, pixel);
    const seen = project(view(nearer.camera), still);
    expect(Math.hypot((seen?.x ?? NaN) - pixel.x, (seen?.y ?? NaN) - pixel.y)).toBeLessThan(
      PIXEL_ROUNDING * 10,
    );
    // The planted fault: it goes to the middle.
    const middle = project(view(zoom(from, 0.8, BOUNDS).camera), still);
    expect(Math.hypot((middle?.x ?? NaN) - pixel.x, (middle?.y ?? NaN) - pixel.y)).toBeGreaterThan(1e-3);
  }
});

test("orbiting keeps the pivot, the distance and a level horizon", () => {
  const next = seeded(3);
  for (const camera of cameras()) {
    const level = orbitFrom({ ...camera, rotation: fromEulerDegrees([60 * next() - 30, 0, 0]) }, BOUNDS);
    let turned = level;
    for (let k = 0; k < 20; k += 1) turned = orbit(turned, next() - 0.5, next() - 0.5);
    expect(difference(pivotOf(turned), pivotOf(level))).toBeLessThan(20 * WORLD_ROUNDING);
    expect(turned.distance).toBe(level.distance);
    expect(Math.abs(rotate(turned.camera.rotation, [1, 0, 0])[1])).toBeLessThan(20 * WORLD_ROUNDING);
    expect(rotate(turned.camera.rotation, [0, 1, 0])[1]).toBeGreaterThan(0);
  }
});

test("panning takes the pivot along with the pointer", () => {
  for (const camera of cameras()) {
    const from = orbitFrom(camera, BOUNDS);
    const before = project(view(from.camera), pivotOf(from));
    const after = project(view(pan(from, SIZE, { x: 30, y: -12 }).camera), pivotOf(from));
    const moved = [(after?.x ?? NaN) - (before?.x ?? NaN), (after?.y ?? NaN) - (before?.y ?? NaN)];
    expect(difference(moved, [30, -12])).toBeLessThan(PIXEL_ROUNDING);
  }
});

test("zooming in and out again comes back, and never passes the pivot", () => {
  for (const camera of cameras()) {
    const from = orbitFrom(camera, BOUNDS);
    const back = zoom(zoom(from, 0.5, BOUNDS), 2, BOUNDS);
    expect(difference(back.camera.translation, from.camera.translation)).toBeLessThan(WORLD_ROUNDING);
    let near = from;
    for (let k = 0; k < 200; k += 1) near = zoom(near, 0.5, BOUNDS);
    expect(near.distance).toBeGreaterThan(0);
  }
});

test("framing a ball fits it into the picture", () => {
  for (const camera of cameras()) {
    for (const aspect of [0.5, 2]) {
      const framed = fitBall(orbitFrom(camera, BOUNDS), [1, 2, 3], 0.7, aspect);
      const narrow = { camera: framed.camera, width: 400 * aspect, height: 400 };
      const middle = project(narrow, [1, 2, 3]);
      expect(difference([middle?.x ?? NaN, middle?.y ?? NaN], [200 * aspect, 200])).toBeLessThan(
        PIXEL_ROUNDING,
      );
      const radius = 0.7 / worldPerPixel(narrow, [1, 2, 3]);
      // A ball's outline is a little larger than its middle's disc: this may fall short of the edge.
      expect(radius).toBeLessThanOrEqual(200 * Math.min(1, aspect) * (1 + 1e-12));
      expect(length(sub(pivotOf(framed), [1, 2, 3]))).toBeLessThan(100);
    }
  }
});

test("angles in degrees and back are the same rotation", () => {
  const next = seeded(4);
  const rotations = Array.from({ length: 500 }, () => fromEulerDegrees(someVector(next, 180)));
  const locked = [90, -90].map((y) => fromEulerDegrees([20, y, 30]));
  for (const rotation of [...rotations, ...locked]) {
    const back = fromEulerDegrees(toEulerDegrees(rotation));
    // asin loses half of the digits near 90 degrees: sqrt(2^-52) = 1.5e-8.
    expect(difference(rotate(back, [1, 2, 3]), rotate(rotation, [1, 2, 3]))).toBeLessThan(1e-6);
  }
});

// The same numbers as in render's camera.rs and scene's view_ray.rs: a camera that frames 2 by 1.
test("all that a camera frames is in the picture", () => {
  const projections: Projection[] = [
    { perspective: { yfov: 2 * Math.atan(0.5), aspectRatio: 2, znear: 0.1 } },
    { orthographic: { ymag: 0.5, aspectRatio: 2, znear: 0, zfar: 9 } },
  ];
  const pictures = [
    { width: 100, height: 100, x: 75, y: 37.5 },
    { width: 400, height: 100, x: 250, y: 25 },
    { width: 200, height: 100, x: 150, y: 25 },
  ];
  for (const projection of projections) {
    for (const { width, height, x, y } of pictures) {
      const camera: Camera = { name: "", translation: [0, 0, 0], rotation: [0, 0, 0, 1], projection };
      const pixel = project({ camera, width, height }, [0.5, 0.25, -1]);
      expect(Math.hypot((pixel?.x ?? 0) - x, (pixel?.y ?? 0) - y)).toBeLessThan(PIXEL_ROUNDING);
    }
  }
});

test("a framed ball fits a camera that keeps its width", () => {
  for (const projection of PROJECTIONS) {
    const camera: Camera = { name: "", translation: [0, 0, 9], rotation: [0, 0, 0, 1], projection };
    for (const [width, height] of [
      [400, 100],
      [100, 400],
    ] as const) {
      const framed = fitBall(orbitFrom(camera, BOUNDS), [0, 0, 0], 1, width / height).camera;
      const view = { camera: framed, width, height };
      // Its outermost tangent, or its side: at the border of the picture's shorter side, and not beyond.
      const distance = framed.translation[2];
      const sine = "perspective" in projection ? 1 / distance : 0;
      const rim = add([0, 0, 0], [Math.sqrt(1 - sine * sine), 0, sine]);
      const seen = project(view, rim);
      const reach = ((seen?.x ?? 0) - width / 2) / (Math.min(width, height) / 2);
      expect(reach).toBeCloseTo(1, 9);
    }
  }
});

test("the gate of a view is the picture that render writes, whatever the view's shape", () => {
  for (const bare of cameras()) {
    const camera = withShape(bare);
    for (const [width, height] of [
      [640, 200],
      [200, 640],
      [333, 333],
    ] as const) {
      const view = { camera, width, height };
      const gate = gateOf(view);
      const written = { ...view, width: gate.width, height: gate.height };
      const through = add(camera.translation, rotate(camera.rotation, [0, 0, -3]));
      for (const corner of [
        { x: 0, y: 0 },
        { x: gate.width, y: gate.height },
      ]) {
        const point = inPlaneOf(written, corner, through);
        const seen = project(view, point);
        expect(seen).not.toBeNull();
        const off = Math.hypot((seen?.x ?? NaN) - gate.x - corner.x, (seen?.y ?? NaN) - gate.y - corner.y);
        expect(off).toBeLessThan(PIXEL_ROUNDING);
      }
      expect(Math.min(gate.x, gate.y)).toBeGreaterThanOrEqual(-PIXEL_ROUNDING);
      const wider = gateOf({ ...view, width: width * 1.1, height: height * 1.1 });
      expect(wider.width - gate.width).toBeGreaterThan(PIXEL_ROUNDING);
    }
  }
});

test("a camera without a shape is written 16:9 with its height, in sight or not", () => {
  const camera = { ...(cameras()[0] as Camera), projection: PROJECTIONS[0] as Projection };
  expect(gateOf({ camera, width: 90, height: 90 })).toEqual({ x: -35, y: 0, width: 160, height: 90 });
  const whole = gateOf({ camera: withShape(camera), width: 160, height: 100 });
  expect([whole.x, whole.width]).toEqual([expect.closeTo(0, 9), expect.closeTo(160, 9)]);
  expect([whole.y, whole.height]).toEqual([expect.closeTo(5, 9), expect.closeTo(90, 9)]);
});

test("cameras see the same where all but their names is the same", () => {
  const [first, second] = cameras() as [Camera, Camera];
  expect(seeTheSame(first, { ...withShape(first), name: "another" })).toBe(true);
  expect(seeTheSame(first, second)).toBe(false);
  expect(seeTheSame(first, { ...first, projection: PROJECTIONS[2] as Projection })).toBe(false);
});

test("two fingers take the pivot along with their middle, and bring it nearer as they part", () => {
  const fingers = (x: number, y: number, span: number): Fingers => [
    { x: x - span / 2, y },
    { x: x + span / 2, y },
  ];
  for (const camera of cameras()) {
    const from = orbitFrom(camera, BOUNDS);
    const moved = pinch(from, SIZE, fingers(100, 100, 80), fingers(130, 88, 80), BOUNDS);
    const panned = pan(from, SIZE, { x: 30, y: -12 });
    expect(difference(moved.camera.translation, panned.camera.translation)).toBeLessThan(WORLD_ROUNDING);
    expect(moved.camera.rotation).toEqual(from.camera.rotation);
    const nearer = pinch(from, SIZE, fingers(100, 100, 80), fingers(100, 100, 160), BOUNDS);
    const [was, is] = [from, nearer].map((o) => worldPerPixel(view(o.camera), pivotOf(from)));
    expect((was ?? NaN) / (is ?? NaN)).toBeCloseTo(2, 9);
    const touching = pinch(from, SIZE, fingers(100, 100, 1), fingers(100, 100, 2), BOUNDS);
    expect(difference(touching.camera.translation, from.camera.translation)).toBeLessThan(WORLD_ROUNDING);
  }
});
