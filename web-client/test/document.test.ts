import { expect, test } from "vitest";

import * as core from "../src/core/document";
import type { Change, Command, Document } from "../src/core/protocol";
import { BENDY, CAMERA, DOCUMENT } from "./examples";
import { TABLE } from "./parameters_fixture";
import { vectors } from "./vectors";

const { copyName, freeName, lightLabel, lightName, lightOf } = core;
const applyChange = (document: Document, change: Change) => core.applyChange(TABLE, document, change);
const predict = (document: Document, command: Command) => core.predict(TABLE, document, command);
const changesPicture = (change: Change) => core.changesPicture(TABLE, DOCUMENT, change);

interface ChangesVector {
  name: string;
  document: Document;
  changes: Change[];
  after: Document;
}

test("changes do what they do on the server, and a missing one is noticed", () => {
  const cases = vectors<ChangesVector[]>("changes.json");
  expect(cases.length).toBeGreaterThan(0);
  for (const { name, document, changes, after } of cases) {
    expect(changes.reduce(applyChange, document), name).toEqual(after);
    if (changes.length > 0) expect(changes.slice(1).reduce(applyChange, document), name).not.toEqual(after);
  }
});

test("a document that is changed stays as it was", () => {
  const before = structuredClone(DOCUMENT);
  applyChange(DOCUMENT, { type: "lightParameter", light: 1, old: { scale: 1.5 }, new: { scale: 2 } });
  applyChange(DOCUMENT, {
    type: "point",
    light: 1,
    layout: 1,
    point: 1,
    old: { radius: 0.2 },
    new: { radius: 1 },
  });
  expect(DOCUMENT).toEqual(before);
});

test("a free name has the first number that is not taken", () => {
  expect(freeName("camera", [])).toBe("camera 1");
  expect(freeName("camera", ["camera 2"])).toBe("camera 1");
  expect(freeName("camera", ["camera 2", "key", "camera 1"])).toBe("camera 3");
});

test("a name of blanks is none", () => {
  for (const [name, label, called] of [
    ["key", "key", "“key”"],
    ["", "bendy 1", "Light 1"],
    [" \t", "bendy 1", "Light 1"],
  ] as const) {
    const entry = { id: 1, layout: 1, light: { ...BENDY, name } };
    expect(lightLabel(entry)).toBe(label);
    expect(lightName({ ...DOCUMENT, lights: [entry] }, 1)).toBe(called);
  }
});

test("lights come and go in the order of their ids", () => {
  const added = [5, 3].reduce(
    (document, light) =>
      applyChange(document, { type: "light", light, old: null, new: { layout: light, light: BENDY } }),
    DOCUMENT,
  );
  expect(added.lights.map(({ id }) => id)).toEqual([1, 3, 5]);
  const removed = applyChange(added, {
    type: "light",
    light: 3,
    old: { layout: 3, light: BENDY },
    new: null,
  });
  expect(removed.lights.map(({ id }) => id)).toEqual([1, 5]);
});

test("what is predicted is what the change then does", () => {
  const cases: [Command, Change][] = [
    [
      { type: "placeLight", light: 1, translation: [1, 2, 3] },
      { type: "lightParameter", light: 1, old: { translation: [0, 2, -3] }, new: { translation: [1, 2, 3] } },
    ],
    [
      { type: "setLight", light: 1, parameter: { coneAngle: 40 } },
      { type: "lightParameter", light: 1, old: { coneAngle: 25 }, new: { coneAngle: 40 } },
    ],
    [
      { type: "setPoint", light: 1, point: 2, parameter: { color: [1, 0, 0] } },
      {
        type: "point",
        light: 1,
        layout: 1,
        point: 2,
        old: { color: [1, 0.9, 0.8] },
        new: { color: [1, 0, 0] },
      },
    ],
    [
      { type: "setCamera", camera: 2, parameter: { name: "wide" } },
      { type: "cameraParameter", camera: 2, old: { name: "camera" }, new: { name: "wide" } },
    ],
  ];
  for (const [command, change] of cases) {
    expect(predict(DOCUMENT, command)).toEqual(applyChange(DOCUMENT, change));
    expect(predict(DOCUMENT, command)).not.toEqual(DOCUMENT);
  }
});

test("nothing is predicted for lights that are not there, and of what the server fills in", () => {
  const commands: Command[] = [
    { type: "setLight", light: 99, parameter: { coneAngle: 40 } },
    { type: "setPoint", light: 1, point: 50, parameter: { radius: 1 } },
    { type: "removeLight", light: 1 },
    { type: "insertPoint", light: 1, point: 2 },
    { type: "dragPoint", light: 1, point: 2, position: [9, 9, 9], radii: "keep" },
    { type: "addCamera", camera: CAMERA },
  ];
  for (const command of commands) expect(predict(DOCUMENT, command)).toEqual(DOCUMENT);
  expect(lightOf(DOCUMENT, 99)).toBeUndefined();
});

test("names and cameras change no picture", () => {
  const silent: Change[] = [
    { type: "lightParameter", light: 1, old: { name: "a" }, new: { name: "b" } },
    { type: "camera", camera: 3, old: null, new: CAMERA },
    { type: "cameraParameter", camera: 2, old: { translation: [0, 0, 0] }, new: { translation: [1, 0, 0] } },
    { type: "scene", old: { asset: "sha256:1", name: "a" }, new: { asset: "sha256:1", name: "b" } },
  ];
  const visible: Change[] = [
    { type: "lightParameter", light: 1, old: { scale: 1 }, new: { scale: 2 } },
    { type: "point", light: 1, layout: 1, point: 1, old: { radius: 1 }, new: { radius: 2 } },
    { type: "light", light: 1, old: null, new: { layout: 1, light: BENDY } },
    { type: "scene", old: null, new: { asset: "sha256:1", name: "a" } },
  ];
  expect(silent.filter(changesPicture)).toEqual([]);
  expect(visible.filter((change) => !changesPicture(change))).toEqual([]);
});

test("a copy has its light's name with the next number that is free", () => {
  const copy = (name: string, ...others: string[]) => copyName({ ...BENDY, name }, [name, ...others]);
  expect(copy("key")).toBe("key 2");
  expect(copy("key", "key 2")).toBe("key 3");
  expect(copy("spot 7")).toBe("spot 2");
  expect(copy("spot 2", "spot 3")).toBe("spot 4");
  expect(copy("route 66 sign")).toBe("route 66 sign 2");
  expect(copy("  ")).toBe("bendy 2");
});
