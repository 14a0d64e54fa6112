import { signal } from "@preact/signals";
import { beforeEach, expect, test } from "vitest";

import type { OnProbed } from "../src/core/probing";
import type { Camera, Document, Pin, ProbedLight } from "../src/core/protocol";
import type { Vec3 } from "../src/core/vector";
import type { Page } from "../src/ui/page";
import { watchPins } from "../src/ui/pin_watch";
import { startTools } from "../src/ui/toolbox";
import { DOCUMENT } from "./examples";
import { type FakeHost, fakeHost } from "./fake_host";
import { found, probed } from "./probes";

const SETTLED_MS = 1000;
const CAMERA: Camera = {
  name: "eye",
  translation: [0, 0, 5],
  rotation: [0, 0, 0, 1],
  projection: { perspective: { yfov: 0.8, znear: 0.1 } },
};
const AT: Vec3[] = [
  [0, 0, 0],
  [0.5, 0, 0],
  [0, 0, 20],
];

let host: FakeHost;
let seq = signal(1);
let ownDrag = signal<object | null>(null);
let toolbox = startTools();
let asked: { at: Vec3; answer(light: ProbedLight): void }[];

/** A page with pins of light 1, of which the last lies behind the camera. */
beforeEach(() => {
  host = fakeHost();
  seq = signal(1);
  ownDrag = signal(null);
  toolbox = startTools();
  asked = [];
  const pins = AT.map((at, k) => {
    const pin: Pin = { kind: k === 1 ? "shadowed" : "lit", light: 1, at, hard: true };
    return { id: 10 + k, pin };
  });
  const document = signal<Document>({ ...DOCUMENT, pins });
  const session = {
    document,
    ownDrag,
    mirror: {
      get value() {
        return { seq: seq.value };
      },
    },
    gestures: signal([]),
    frame: signal({ viewWidth: 64, viewHeight: 36 }),
    viewer: { revision: signal(1), cameraOf: () => CAMERA },
    probe: (_: string, __: object, told: OnProbed) => {
      const at = AT[asked.length % 2] ?? [0, 0, 0];
      asked.push({
        at,
        answer: (light) => {
          const { seen, lights } = found(light);
          told({ seen: seen === null ? null : { ...seen, position: at }, lights });
        },
      });
    },
  };
  const page = { session, toolbox, selectedLight: signal<number | null>(1) };
  watchPins(page as unknown as Page, host);
});

const lit = probed(1, "lit", 1);
const dark = probed(1, "shadowed", 1);
const broken = () => [...toolbox.pinFacts.value.broken];

test("pins are probed one at a time once the document is at rest, and those out of sight are not", () => {
  expect(asked).toHaveLength(0);
  host.pass(SETTLED_MS);
  expect(asked).toHaveLength(1);
  asked[0]?.answer(lit);
  expect(asked).toHaveLength(2);
  asked[1]?.answer(dark);
  expect(asked, "the third lies behind the camera").toHaveLength(2);
  expect(broken()).toEqual([]);
  expect(toolbox.pinFacts.value.sights.get(10)).toEqual({ node: "table", state: "lit" });
});

test("a pin is broken while it does not hold, and no longer", () => {
  host.pass(SETTLED_MS);
  asked[0]?.answer(lit);
  asked[1]?.answer(dark);
  seq.value = 2;
  host.pass(SETTLED_MS);
  asked[2]?.answer(dark);
  asked[3]?.answer(lit);
  expect(broken()).toEqual([10, 11]);
  seq.value = 3;
  host.pass(SETTLED_MS);
  asked[4]?.answer(lit);
  asked[5]?.answer(dark);
  expect(broken()).toEqual([]);
});

test("nothing is asked while something is dragged, and an answer from before ends its round", () => {
  host.pass(SETTLED_MS);
  ownDrag.value = {};
  asked[0]?.answer(lit);
  host.pass(SETTLED_MS);
  expect(asked).toHaveLength(1);
  ownDrag.value = null;
  host.pass(SETTLED_MS);
  expect(asked).toHaveLength(2);
});
