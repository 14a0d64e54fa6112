import { expect, test } from "vitest";

import { display } from "../src/core/display";
import { latencyMeter } from "../src/core/latency";
import type { ClientMessage } from "../src/core/protocol";
import { fakeHost } from "./fake_host";

/** A message of a frame that is all of its picture. */
function whole(frame: number): ArrayBuffer {
  const bytes = new ArrayBuffer(70);
  const view = new DataView(bytes);
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setUint16(2, 4, true);
  view.setBigUint64(8, BigInt(frame), true);
  for (const at of [40, 42, 44, 46]) view.setUint16(at, 100, true);
  return bytes;
}

// Rules: FRAME-14
test("pictures that can never be decoded are asked for once a second, and by no connection after theirs", async () => {
  const host = fakeHost();
  const sent: ClientMessage[] = [];
  const { feed } = display<null>({
    host,
    screen: { decode: () => Promise.reject(new Error("torn")), draw: () => {} },
    send: (message) => sent.push(message) > 0,
    notify: () => {},
    latency: latencyMeter(),
  });
  const fail = async (frame: number) => {
    feed.receive(whole(frame));
    await new Promise((resolve) => setImmediate(resolve));
  };
  const asked = () => sent.flatMap((m) => (m.type === "requestKeyFrame" ? [m.frame] : []));
  await fail(1);
  // Before its acknowledgement: the server is not to send what goes onto it.
  expect(sent.map(({ type }) => type)).toEqual(["requestKeyFrame", "ack"]);
  for (const frame of [2, 3]) await fail(frame);
  expect(asked()).toEqual([1]);
  host.pass(1000);
  expect(asked()).toEqual([1, 3]);
  await fail(4);
  feed.restart();
  host.pass(5000);
  expect(asked()).toEqual([1, 3]);
});
