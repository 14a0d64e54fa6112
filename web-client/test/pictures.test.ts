import { expect, test } from "vitest";

import type { FrameHeader } from "../src/core/frame";
import { pictures } from "../src/core/pictures";

const KEY = 1;
const SETTLE = 2;
const LAST_TILE = 4;

/** A message of the frame with the number `frame`: `rows` of the 100 that its picture has. */
function message(frame: number, flags = LAST_TILE, rows = 100): ArrayBuffer {
  const bytes = new ArrayBuffer(70);
  const view = new DataView(bytes);
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setUint16(2, flags, true);
  view.setBigUint64(8, BigInt(frame), true);
  for (const [k, side] of [0, 0, 100, rows, 100, 100].entries()) view.setUint16(36 + 2 * k, side, true);
  return bytes;
}

/** A sink whose decoder finishes when told to. */
function slowSink() {
  const decoding: { header: FrameHeader; finish(): void; fail(): void }[] = [];
  const shown: number[] = [];
  const drawn: string[] = [];
  const acks: number[] = [];
  const torn: number[] = [];
  const failures: string[] = [];
  const feed = pictures<number>({
    decode: (header) =>
      new Promise((resolve, reject) => {
        decoding.push({ header, finish: () => resolve(header.frame), fail: () => reject(new Error("torn")) });
      }),
    beforeRepaint: (task) => task(),
    draw: (tiles) => drawn.push(tiles.map(({ header }) => `${header.frame}:${header.tile.height}`).join(" ")),
    shown: ({ frame }) => shown.push(frame),
    ack: (frame) => acks.push(frame),
    torn: (frame) => torn.push(frame),
    failed: (reason) => failures.push(reason),
  });
  const step = async (end: "finish" | "fail") => {
    for (const one of decoding) one[end]();
    await new Promise((resolve) => setImmediate(resolve));
  };
  return { feed, decoding, drawn, shown, acks, torn, failures, step };
}

test("a frame is acknowledged when it is shown, not before", async () => {
  const { feed, shown, acks, step } = slowSink();
  feed.receive(message(1));
  expect(acks).toEqual([]);
  await step("finish");
  expect([shown, acks]).toEqual([[1], [1]]);
});

test("while one is decoded the latest wins, and what it overtook is acknowledged with it", async () => {
  const { feed, decoding, shown, acks, step } = slowSink();
  for (const frame of [1, 2, 3]) feed.receive(message(frame));
  await step("finish");
  expect([shown, acks]).toEqual([[1], [1]]);
  await step("finish");
  expect([shown, acks]).toEqual([
    [1, 3],
    [1, 2, 3],
  ]);
  expect(decoding.map(({ header }) => header.frame)).toEqual([1, 3]);
});

test("the parts of a moving picture are shown together, on what was before them, and acknowledged once", async () => {
  const { feed, drawn, shown, acks, step } = slowSink();
  feed.receive(message(1));
  feed.receive(message(2, 0, 10));
  await step("finish");
  expect([drawn, shown]).toEqual([["1:100"], [1]]);
  feed.receive(message(2, LAST_TILE, 20));
  feed.receive(message(3, LAST_TILE, 30));
  await step("finish");
  await step("finish");
  expect(drawn).toEqual(["1:100", "2:10 2:20", "3:30"]);
  expect([shown, acks]).toEqual([
    [1, 2, 3],
    [1, 2, 3],
  ]);
});

test("a lossless picture grows on the screen, and a whole one takes the place of what has not come", async () => {
  const { feed, drawn, shown, acks, step } = slowSink();
  feed.receive(message(1, SETTLE, 40));
  await step("finish");
  expect([drawn, shown, acks]).toEqual([["1:40"], [], []]);
  feed.receive(message(1, SETTLE, 30));
  feed.receive(message(2));
  await step("finish");
  await step("finish");
  expect(shown).toEqual([2]);
  expect(acks).toEqual([1, 2]);
  expect(drawn.at(-1)).toBe("2:100");
});

test("a frame that cannot be decoded is said and does not stop the next", async () => {
  const { feed, shown, acks, failures, step } = slowSink();
  feed.receive(message(1));
  await step("fail");
  feed.receive(message(2));
  await step("finish");
  expect([shown, acks]).toEqual([[2], [1, 2]]);
  expect(failures).toHaveLength(1);
});

// Rules: FRAME-14
test("after a frame that cannot be decoded a whole one is asked for, once, and nothing goes onto what is torn", async () => {
  const { feed, drawn, shown, acks, torn, step } = slowSink();
  feed.receive(message(1));
  await step("finish");
  feed.receive(message(2, LAST_TILE, 10));
  await step("fail");
  expect([torn, acks]).toEqual([[2], [1, 2]]);
  feed.receive(message(3, LAST_TILE, 20));
  await step("finish");
  expect([drawn, acks]).toEqual([["1:100"], [1, 2, 3]]);
  feed.receive(message(4));
  await step("finish");
  feed.receive(message(5, LAST_TILE, 30));
  await step("finish");
  expect([drawn, shown, torn]).toEqual([["1:100", "4:100", "5:30"], [1, 4, 5], [2]]);
});

test("of a lossless frame with a torn band no more is shown, and the next in bands mends it", async () => {
  const { feed, drawn, shown, acks, torn, step } = slowSink();
  feed.receive(message(1, SETTLE, 40));
  await step("fail");
  feed.receive(message(1, SETTLE | LAST_TILE, 60));
  await step("finish");
  expect([drawn, shown, acks, torn]).toEqual([[], [], [1], [1]]);
  feed.receive(message(2, SETTLE | KEY, 40));
  await step("finish");
  feed.receive(message(2, SETTLE | LAST_TILE | KEY, 60));
  await step("finish");
  expect([drawn, shown, torn]).toEqual([["2:40", "2:60"], [2], [1]]);
});

test("a frame of the connection before is neither shown nor acknowledged", async () => {
  const { feed, shown, acks, step } = slowSink();
  feed.receive(message(9));
  feed.restart();
  await step("finish");
  expect([shown, acks]).toEqual([[], []]);
  feed.receive(message(1));
  await step("finish");
  expect([shown, acks]).toEqual([[1], [1]]);
});

test("what is no frame is said", () => {
  const { feed, failures } = slowSink();
  feed.receive(new ArrayBuffer(10));
  const unknown = message(1);
  new DataView(unknown).setUint8(1, 77);
  feed.receive(unknown);
  expect(failures).toHaveLength(2);
});
