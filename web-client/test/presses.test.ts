import { beforeEach, describe, expect, test } from "vitest";

import { lightOf } from "../src/core/document";
import type { ClientMessage, Command } from "../src/core/protocol";
import type { Session } from "../src/core/session";
import { committing, type Presses, startPresses } from "../src/ui/presses";
import { lightBinding } from "../src/ui/binding";
import { BENDY, WELCOME } from "./examples";
import { type FakeHost, fakeHost, sessionOn } from "./fake_host";

let host: FakeHost;
/** Without the page's order. */
let bare: Session;
let session: Session;
let presses: Presses;

beforeEach(() => {
  host = fakeHost();
  bare = sessionOn(host);
  presses = startPresses(host, bare);
  session = committing(bare, presses);
  host.socket().events.open();
  host.socket().receive({ type: "welcome", ...WELCOME });
});

const setRadius = (point: number, to: number): Command => ({
  type: "setPoint",
  light: 1,
  point,
  parameter: { radius: to },
});

/** Presses an arrow in the field of a control point's radius, as often as `count` says. */
function press(point: number, count = 1): void {
  const binding = lightBinding(session, 1, (radius: number) => setRadius(point, radius));
  for (let k = 0; k < count; k += 1) {
    presses.press(`radius ${point}`, radius(point), (from) => from + 0.25, binding.drag);
  }
}

function radius(point: number): number {
  const light = lightOf(session.document.value, 1);
  return (light?.type === "bendy" ? light.radii[point] : undefined) ?? NaN;
}

/** The messages since the welcome, those of a drag with the command that they mean. */
function said(): string[] {
  const radiusIn = (command: Command) =>
    command.type === "setPoint" && "radius" in command.parameter ? command.parameter.radius : command.type;
  const line = (message: ClientMessage) =>
    "command" in message ? `${message.type} ${radiusIn(message.command)}` : message.type;
  return host
    .socket()
    .sent.slice(3)
    .filter(({ type }) => type !== "ping")
    .map(line);
}

const START = BENDY.radii[1] ?? NaN;

describe("presses", () => {
  test("that follow each other within a second are one record, of where the last one led", () => {
    press(1, 2);
    host.frame();
    host.pass(900);
    press(1, 3);
    host.frame();
    host.pass(900);
    expect(said()).toEqual(["gestureBegin", `gestureUpdate ${START + 0.5}`, `gestureUpdate ${START + 1.25}`]);
    expect(radius(1)).toBe(START + 1.25);
    host.pass(200);
    expect(said().slice(3)).toEqual(["gestureCommit"]);
    host.pass(5000);
    expect(said()).toHaveLength(4);
  });

  test("after a second's rest are another record", () => {
    press(1);
    host.pass(1000);
    press(1);
    host.pass(1000);
    expect(said().filter((line) => line === "gestureCommit")).toHaveLength(2);
  });

  test("add up even before the page has shown the first of them", () => {
    const binding = lightBinding(session, 1, (to: number) => setRadius(1, to));
    for (let k = 0; k < 4; k += 1) presses.press("field", 2, (from) => from + 1, binding.drag);
    expect(radius(1)).toBe(6);
  });

  test("are a record before what is asked for next", () => {
    for (const [task, then] of [
      [() => session.undo("mine"), "undo"],
      [() => session.redo("session"), "redo"],
      [() => session.edit(setRadius(3, 0.5)), "edit 0.5"],
    ] as const) {
      const before = said().length;
      press(1, 2);
      task();
      const [begin, , commit, next, ...more] = said().slice(before);
      expect([begin, commit, next, more]).toEqual(["gestureBegin", "gestureCommit", then, []]);
    }
  });

  test("are a record before the pointer drags, and before another control's", () => {
    press(1);
    press(2);
    expect(said().slice(0, 3)).toEqual(["gestureBegin", `gestureUpdate ${START + 0.25}`, "gestureCommit"]);
    const drag = session.drag(1);
    expect(said().slice(3, 6).at(-1)).toBe("gestureCommit");
    drag.update(setRadius(3, 0.5));
    drag.commit();
    expect(said().filter((line) => line === "gestureCommit")).toHaveLength(3);
  });

  test("do nothing while the pointer drags", () => {
    const drag = session.drag(1);
    drag.update(setRadius(3, 0.5));
    press(1);
    expect(radius(1)).toBe(START);
    drag.commit();
    expect(said()).toEqual(["gestureBegin", "gestureUpdate 0.5", "gestureCommit"]);
  });

  test("that change nothing leave no trace", () => {
    const binding = lightBinding(session, 1, (to: number) => setRadius(1, to));
    presses.press("field", 2, (from) => from, binding.drag);
    host.pass(5000);
    expect(said()).toEqual([]);
  });

  test("that are taken back leave no trace", () => {
    press(1, 3);
    host.frame();
    presses.cancel();
    host.pass(5000);
    expect(said()).toEqual(["gestureBegin", `gestureUpdate ${START + 0.75}`, "gestureCancel"]);
    expect(radius(1)).toBe(START);
  });

  test("planted: a session that does not wait for them lets an undo overtake them", () => {
    press(1);
    bare.undo("mine");
    expect(said()).toEqual(["undo"]);
  });
});
