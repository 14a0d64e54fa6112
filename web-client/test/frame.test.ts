import { expect, test } from "vitest";

import { type FrameHeader, HEADER_BYTES, readHeader, reductionsOf, viewSizeOf } from "../src/core/frame";
import { vectors } from "./vectors";

test("a header is read as the server writes it, and every byte of it counts", () => {
  const { hex, header } = vectors<{ hex: string; header: FrameHeader }>("frame.json");
  const bytes = Uint8Array.from(Buffer.from(hex, "hex"));
  expect(readHeader(bytes.buffer)).toEqual(header);
  expect(bytes.length).toBeGreaterThanOrEqual(HEADER_BYTES);
  // Offsets of SPEC, section 8: one byte of each field after the kind and the codec.
  for (const offset of [2, 4, 8, 16, 24, 28, 32, 34, 36, 38, 40, 42, 44, 46, 48, 52, 56, 60, 62]) {
    const changed = bytes.slice();
    changed[offset] = (changed[offset] ?? 0) ^ 1;
    expect(readHeader(changed.buffer), `offset ${offset}`).not.toEqual(header);
  }
});

test("what is no header is refused with a sentence", () => {
  expect(() => readHeader(new ArrayBuffer(63))).toThrow(/shorter than its header/);
  expect(() => readHeader(new ArrayBuffer(64))).toThrow(/kind 0/);
});

test("a reduced picture says what it lacks and keeps its view's size", () => {
  const { header } = vectors<{ header: FrameHeader }>("frame.json");
  const full = { ...header, width: 686, height: 382, viewWidth: 686, viewHeight: 382, shadowMapDivisor: 1 };
  expect(reductionsOf(full)).toBe("");
  expect(reductionsOf({ ...full, shadowMapDivisor: 2 })).toBe("half shadow map");
  expect(reductionsOf({ ...full, width: 515, height: 287 })).toBe("three-quarter resolution");
  const half = { ...full, width: 343, height: 191, shadowMapDivisor: 2 };
  expect(reductionsOf(half)).toBe("half resolution, half shadow map");
  expect(viewSizeOf(half)).toEqual({ width: 686, height: 382 });
});
