import { expect, test } from "vitest";

import type { FrameHeader } from "../src/core/frame";
import { pictures } from "../src/core/pictures";

/** A frame message with the number `frame`. */
function message(frame: number): ArrayBuffer {
  const bytes = new ArrayBuffer(70);
  const view = new DataView(bytes);
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setBigUint64(8, BigInt(frame), true);
  return bytes;
}

/** A sink whose decoder finishes when told to. */
function slowSink() {
  const decoding: { header: FrameHeader; finish(): void; fail(): void }[] = [];
  const shown: number[] = [];
  const acks: number[] = [];
  const failures: string[] = [];
  const feed = pictures<number>({
    decode: (header) =>
      new Promise((resolve, reject) => {
        decoding.push({ header, finish: () => resolve(header.frame), fail: () => reject(new Error("torn")) });
      }),
    beforeRepaint: (task) => task(),
    show: (_, picture) => shown.push(picture),
    ack: (frame) => acks.push(frame),
    failed: (reason) => failures.push(reason),
  });
  const step = async (end: "finish" | "fail") => {
    decoding.at(-1)?.[end]();
    await new Promise((resolve) => setImmediate(resolve));
  };
  return { feed, decoding, shown, acks, failures, step };
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

test("a frame that cannot be decoded is said and does not stop the next", async () => {
  const { feed, shown, acks, failures, step } = slowSink();
  feed.receive(message(1));
  await step("fail");
  feed.receive(message(2));
  await step("finish");
  expect([shown, acks]).toEqual([[2], [1, 2]]);
  expect(failures).toHaveLength(1);
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
