import { expect, test } from "vitest";

import { latencyMeter } from "../src/core/latency";

const frame = (logSeq: number, liveRevision = 0, cameraRevision = 0) => ({
  logSeq,
  liveRevision,
  cameraRevision,
});

test("measures to the first picture that shows the change", () => {
  const meter = latencyMeter();
  expect(meter.medianMs()).toBeNull();
  meter.expect("logSeq", 5, 1000);
  meter.shown(frame(4), 1010);
  expect(meter.medianMs()).toBeNull();
  meter.shown(frame(6), 1030);
  meter.shown(frame(7), 1090);
  expect(meter.medianMs()).toBe(30);
});

test("finds the picture that came before it was known which revision the change became", () => {
  const meter = latencyMeter();
  meter.shown(frame(3, 8), 990);
  meter.shown(frame(3, 9), 1025);
  meter.shown(frame(3, 10), 1050);
  meter.expect("liveRevision", 9, 1000);
  expect(meter.medianMs()).toBe(25);
});

test("forgets what it waits for with the connection", () => {
  const meter = latencyMeter();
  meter.expect("cameraRevision", 2, 1000);
  meter.restart();
  meter.shown(frame(1, 1, 5), 60_000);
  expect(meter.medianMs()).toBeNull();
});
