import { beforeEach, expect, test } from "vitest";

import type { AlternativeAnswer, AlternativesReply, FeatureCommand } from "../src/core/alternatives";
import { LINGER_MS, type OtherAnswers, otherAnswers, REST_MS } from "../src/core/other_answers";
import type { DragAlternative } from "../src/core/protocol";
import { BENDY, CAMERA } from "./examples";
import { type FakeHost, fakeHost } from "./fake_host";

let host: FakeHost;
let answers: OtherAnswers;
let asked: { command: FeatureCommand; reply(reply: AlternativesReply): Promise<void> }[];
let taken: DragAlternative | null;

beforeEach(() => {
  host = fakeHost();
  asked = [];
  taken = "controlPoints";
  answers = otherAnswers({
    after: host.after,
    ask: (command) =>
      new Promise((resolve) => {
        asked.push({
          command,
          async reply(reply) {
            resolve(reply);
            await Promise.resolve();
          },
        });
      }),
  });
  answers.begin({ taken: () => taken, take: (alternative) => (taken = alternative) });
});

const to = (x: number): FeatureCommand => ({
  type: "dragFeature",
  light: 1,
  kind: "shadow",
  alternative: "best",
  radii: "keep",
  camera: CAMERA,
  size: [64, 36],
  from: [0, 0],
  to: [x, 0],
});

const answer = (alternative: DragAlternative): AlternativeAnswer => ({
  alternative,
  status: "landed",
  residualPx: 0,
  light: BENDY,
});
const ALL = { alternatives: [answer("controlPoints"), answer("narrower"), answer("wholeLight")] };

const replyTo = (k: number, reply: AlternativesReply = ALL) => asked[k]?.reply(reply);
const over = () => answers.over({ taken: () => taken, take: () => {} });

test("nobody is asked before the first step, and that goes on once the answer is there", async () => {
  answers.moved(to(1));
  host.pass(REST_MS * 3);
  expect(asked).toHaveLength(0);
  answers.step(1);
  expect(asked).toHaveLength(1);
  expect(answers.shown.value).toMatchObject({ all: null, isAsking: true });
  answers.step(1);
  expect(taken, "nothing is known yet").toBe("controlPoints");
  await replyTo(0);
  expect(taken, "two steps").toBe("wholeLight");
  answers.step(-1);
  expect(taken).toBe("narrower");
  expect(asked).toHaveLength(1);
});

test("a cursor that rests elsewhere is asked about, one request at a time", async () => {
  answers.moved(to(1));
  answers.step(1);
  answers.moved(to(2));
  host.pass(REST_MS);
  answers.moved(to(3));
  host.pass(REST_MS);
  expect(asked, "one is under way").toHaveLength(1);
  await replyTo(0);
  host.pass(REST_MS);
  expect(asked.map(({ command }) => command.to[0])).toEqual([1, 3]);
  await replyTo(1);
  answers.moved(to(4));
  host.pass(REST_MS - 1);
  answers.moved(to(5));
  host.pass(REST_MS - 1);
  expect(asked, "it does not rest").toHaveLength(2);
  host.pass(1);
  expect(asked[2]?.command.to[0]).toBe(5);
});

test("a cursor that comes back to where it was asked about asks nothing", async () => {
  answers.moved(to(1));
  answers.step(1);
  await replyTo(0);
  answers.moved(to(2));
  answers.moved(to(1));
  host.pass(REST_MS * 2);
  expect(asked).toHaveLength(1);
});

test("a failure is said, earlier answers stay, and the next answer ends it", async () => {
  answers.moved(to(1));
  answers.step(1);
  await replyTo(0);
  answers.moved(to(2));
  host.pass(REST_MS);
  await replyTo(1, { why: "busy" });
  expect(answers.shown.value).toMatchObject({ failure: "busy", isAsking: false });
  expect(answers.shown.value?.all).toHaveLength(3);
  answers.moved(to(3));
  host.pass(REST_MS);
  await replyTo(2);
  expect(answers.shown.value?.failure).toBeNull();
});

test("a first request that fails is made again by the next step", async () => {
  answers.moved(to(1));
  answers.step(1);
  await replyTo(0, { why: "busy" });
  answers.step(1);
  expect(asked).toHaveLength(2);
});

test("a finger's drag shows them once it rests", async () => {
  answers.openAtRest();
  answers.moved(to(1));
  host.pass(REST_MS - 1);
  answers.moved(to(2));
  host.pass(REST_MS - 1);
  expect(answers.shown.value).toBeNull();
  host.pass(1);
  expect(asked.map(({ command }) => command.to[0])).toEqual([2]);
  await replyTo(0);
  expect(taken, "nobody has chosen").toBe("controlPoints");
});

test("they outlive the drag for a while, unless somebody is at them", async () => {
  answers.moved(to(1));
  answers.step(1);
  await replyTo(0);
  over();
  expect(answers.shown.value?.isOver).toBe(true);
  answers.moved(to(9));
  host.pass(LINGER_MS - 1);
  expect(asked, "what is over asks nothing").toHaveLength(1);
  answers.hold(true);
  host.pass(LINGER_MS * 2);
  expect(answers.shown.value).not.toBeNull();
  answers.hold(false);
  host.pass(LINGER_MS);
  expect(answers.shown.value).toBeNull();
});

test("after the drag another answer takes the place of its record", async () => {
  answers.moved(to(1));
  answers.step(1);
  await replyTo(0);
  let replaced: DragAlternative | null = null;
  answers.over({ taken: () => taken, take: (alternative) => (replaced = alternative) });
  const before = taken;
  answers.take("wholeLight");
  expect([replaced, taken]).toEqual(["wholeLight", before]);
});

test("a reply that comes after the drag still counts, and one to an earlier drag does not", async () => {
  answers.moved(to(1));
  answers.step(1);
  over();
  await replyTo(0);
  expect(answers.shown.value).toMatchObject({ isOver: true, isAsking: false });
  expect(answers.shown.value?.all).toHaveLength(3);
  expect(taken, "what is over takes no step").toBe("controlPoints");

  answers.begin({ taken: () => taken, take: (alternative) => (taken = alternative) });
  answers.moved(to(1));
  answers.step(1);
  answers.begin({ taken: () => taken, take: (alternative) => (taken = alternative) });
  answers.moved(to(7));
  answers.step(1);
  expect(asked, "one at a time").toHaveLength(2);
  await replyTo(1);
  expect(answers.shown.value?.all, "it was another drag's").toBeNull();
  expect(asked[2]?.command.to[0]).toBe(7);
});

test("without a strip nothing outlives the drag", () => {
  answers.moved(to(1));
  over();
  expect(answers.shown.value).toBeNull();
});
