import { signal } from "@preact/signals-core";
import { beforeEach, expect, test } from "vitest";

import { predict } from "../src/core/document";
import { passesPins, passingPins, withPins } from "../src/core/ignored_pins";
import { withPassing } from "../src/core/passing_pins";
import type { ClientMessage, Command, Document } from "../src/core/protocol";
import type { Session } from "../src/core/session";
import { CAMERA, DOCUMENT, WELCOME } from "./examples";
import { type FakeHost, fakeHost, sessionOn } from "./fake_host";
import { TABLE } from "./parameters_fixture";

const MOVE: Command = { type: "placeLight", light: 1, translation: [1, 1, 1] };
const passes = signal(false);
let host: FakeHost;
let session: Session;

beforeEach(() => {
  passes.value = false;
  host = fakeHost();
  session = withPassing(sessionOn(host), passes);
  host.socket().events.open();
  host.socket().receive({ type: "welcome", ...WELCOME });
});

/** True for each command since the welcome that passes over pins. */
function passed(): boolean[] {
  host.frame();
  const commands = host
    .socket()
    .sent.flatMap((message: ClientMessage) => ("command" in message ? [message.command] : []));
  return commands.map(passesPins);
}

test("edits and drags pass over pins while that is asked for, also without a move", () => {
  const drag = session.drag(1);
  drag.update(MOVE);
  expect(passed()).toEqual([false]);
  passes.value = true;
  expect(passed(), "the key alone").toEqual([false, true]);
  drag.update(MOVE);
  expect(passed()).toEqual([false, true, true]);
  passes.value = false;
  expect(passed()).toEqual([false, true, true, false]);
  drag.commit();
  passes.value = true;
  expect(passed(), "a drag that is over no longer changes").toHaveLength(4);
  session.edit(MOVE);
  expect(passed().at(-1)).toBe(true);
});

test("drags of features keep pins: they are for these", () => {
  const feature: Command = {
    type: "dragFeature",
    light: 1,
    kind: "shadow",
    radii: "keep",
    camera: CAMERA,
    size: [2, 2],
    from: [0, 0],
    to: [1, 1],
  };
  expect(passingPins(feature)).toEqual(feature);
  passes.value = true;
  const drag = session.drag(1);
  drag.update(feature);
  expect(passed()).toEqual([false]);
  passes.value = false;
  expect(passed(), "the key asks for nothing again").toEqual([false]);
  expect(withPins(passingPins(MOVE))).toEqual(MOVE);
});

test("a light that a hard pin holds is shown where the server says", () => {
  const pin = { kind: "lit", light: 1, at: [0, 0, 0], hard: true } as const;
  const pinned = (hard: boolean): Document => ({
    ...DOCUMENT,
    pins: [{ id: 5, pin: { ...pin, at: [0, 0, 0], hard } }],
  });
  const placed = (document: Document, command: Command) =>
    predict(TABLE, document, command).lights[0]?.light.transform.translation;
  expect(placed(DOCUMENT, MOVE)).toEqual([1, 1, 1]);
  expect(placed(pinned(true), MOVE), "it may slide").toEqual([0, 2, -3]);
  expect(placed(pinned(true), passingPins(MOVE))).toEqual([1, 1, 1]);
  expect(placed(pinned(false), MOVE), "a soft pin holds nothing").toEqual([1, 1, 1]);
  const [light] = predict(TABLE, DOCUMENT, passingPins(MOVE)).lights;
  expect(light?.light).not.toHaveProperty("ignorePins");
});
