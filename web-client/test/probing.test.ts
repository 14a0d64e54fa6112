import { beforeEach, expect, test } from "vitest";

import { drawnWay, mattering, splitAt } from "../src/core/probed";
import { type PixelQuestion, questionAt } from "../src/core/probing";
import type { ClientProbe, Probed, ProbedLight, ProbeState } from "../src/core/protocol";
import type { Session } from "../src/core/session";
import { length, sub, type Vec3 } from "../src/core/vector";
import { WELCOME } from "./examples";
import { type FakeHost, fakeHost, sessionOn } from "./fake_host";

let host: FakeHost;
let session: Session;
let heard: string[];

beforeEach(() => {
  host = fakeHost();
  session = sessionOn(host);
  heard = [];
  welcome();
});

function welcome(): void {
  host.socket().events.open();
  host.socket().receive({ type: "welcome", ...WELCOME });
}

const sent = () => host.socket().sent.filter((m): m is ClientProbe => m.type === "probe");
const at = (x: number): PixelQuestion => ({ pixel: { x, y: 0.5 }, size: { width: 640, height: 360 } });
const NOTHING: Probed = { seen: null, lights: [] };
const hear = (what: string) => (found: Probed | null) =>
  void heard.push(`${what}: ${found === null ? "no answer" : "answered"}`);

/** The server answers what it was asked last. */
function answer(found: Probed | null): void {
  const probe = sent().at(-1)?.probe ?? "";
  const refused = found === null ? { code: "badMessage" as const, message: "no" } : null;
  host.socket().receive({ type: "probed", probe, logSeq: 3, liveRevision: 0, found, refused });
}

test("one question is on its way at a time, and of those that come meanwhile the latest of each asker is next", () => {
  for (const x of [1, 2, 3, 4]) session.probe("panel", at(x), hear(`panel ${x}`));
  session.probe("aim", at(5), hear("aim 5"));
  session.probe("panel", at(6), hear("panel 6"));
  expect(sent().map(({ pixel }) => pixel[0])).toEqual([1]);
  for (const _ of [1, 2, 3]) answer(NOTHING);
  expect(sent().map(({ pixel }) => pixel[0])).toEqual([1, 6, 5]);
  expect(sent().every(({ size }) => size?.[0] === 640 && size[1] === 360)).toBe(true);
  expect(heard).toEqual(["panel 1: answered", "panel 6: answered", "aim 5: answered"]);
});

test("a refusal is no answer, and the next question is asked", () => {
  session.probe("panel", at(1), hear("first"));
  session.probe("panel", at(2), hear("second"));
  answer(null);
  answer(NOTHING);
  expect(heard).toEqual(["first: no answer", "second: answered"]);
});

test("an answer to another question counts for nothing", () => {
  session.probe("panel", at(1), hear("first"));
  host.socket().receive({
    type: "probed",
    probe: "another",
    logSeq: 3,
    liveRevision: 0,
    found: NOTHING,
    refused: null,
  });
  expect(heard).toEqual([]);
});

test("a lost connection answers all that waits with nothing, and asking goes on after it", () => {
  session.probe("panel", at(1), hear("panel"));
  session.probe("snap", at(2), hear("snap"));
  host.socket().events.closed();
  expect(heard).toEqual(["panel: no answer", "snap: no answer"]);
  session.probe("aim", at(3), hear("aim"));
  expect(heard.at(-1)).toBe("aim: no answer");
  host.pass(1000);
  welcome();
  session.probe("aim", at(4), hear("again"));
  answer(NOTHING);
  expect(heard.at(-1)).toBe("again: answered");
});

test("a pixel of what is shown is the same place in the picture, and there is none beside it", () => {
  const [shown, size] = [
    { width: 500, height: 250 },
    { width: 1000, height: 500 },
  ];
  expect(questionAt({ x: 125, y: 249 }, shown, size)).toEqual({ pixel: { x: 250, y: 498 }, size });
  for (const pixel of [
    { x: -1, y: 5 },
    { x: 500, y: 5 },
    { x: 5, y: 250 },
  ]) {
    expect(questionAt(pixel, shown, size)).toBeNull();
  }
});

const PATH: Vec3[] = [
  [0, 0, 0],
  [1, 0, 0],
  [1, 1, 0],
];

function light(id: number, state: ProbeState, share = 0): ProbedLight {
  const path = state === "outside" ? [] : PATH;
  return {
    light: id,
    name: `light ${id}`,
    state,
    share,
    path,
    disabledBy: null,
    irradiance: [1, 1, 1],
    place: null,
    radiance: [0, 0, 0],
    shadowedBy: state === "shadowed" ? { node: "vase", position: [1, 0.25, 0] } : null,
  };
}

const FOUND: Probed = {
  seen: null,
  lights: [
    light(1, "outside"),
    light(2, "lit", 0.2),
    light(3, "shadowed"),
    light(4, "lit", 0.8),
    light(5, "facingAway"),
  ],
};

test("what gives most comes first, then what is shadowed, and what has no room is counted", () => {
  const ids = (most: number) => mattering(FOUND, most).lights.map(({ light }) => light);
  expect(ids(9)).toEqual([4, 2, 3, 1, 5]);
  expect(ids(2)).toEqual([4, 2]);
  expect(mattering(FOUND, 2).left).toBe(3);
  expect(mattering(FOUND, 9).left).toBe(0);
});

test("the way that is drawn is the selected light's where it goes there, else that of what gives most", () => {
  const way = (selected: number | null) => drawnWay(FOUND, selected)?.light;
  expect(way(2)).toBe(2);
  expect(way(3)).toBe(3);
  for (const selected of [null, 1, 5, 99]) expect(way(selected)).toBe(4);
  expect(drawnWay({ ...FOUND, lights: [light(1, "outside")] }, 1)).toBeNull();
});

test("a way is split where it meets its obstacle, and none of it is lost", () => {
  const { before, after } = splitAt(PATH, [1.1, 0.25, 0]);
  expect(before).toEqual([...PATH.slice(0, 2), [1, 0.25, 0]]);
  expect(after).toEqual([[1, 0.25, 0], PATH[2]]);
  const all = (path: readonly Vec3[]) =>
    path.slice(1).reduce((sum, point, k) => sum + length(sub(point, path[k] ?? point)), 0);
  expect(all(before) + all(after)).toBe(all(PATH));
  expect(splitAt(PATH, [-3, -1, 0]).before).toEqual([PATH[0], PATH[0]]);
  expect(splitAt(PATH, [1, 9, 0]).after).toEqual([PATH[2], PATH[2]]);
});
