import { expect, test } from "vitest";

import { type FrameHeader, HEADER_BYTES, readHeader } from "../src/core/frame";
import { vectors } from "./vectors";

test("a header is read as the server writes it, and every byte of it counts", () => {
  const { hex, header } = vectors<{ hex: string; header: FrameHeader }>("frame.json");
  const bytes = Uint8Array.from(Buffer.from(hex, "hex"));
  expect(readHeader(bytes.buffer)).toEqual(header);
  expect(bytes.length).toBeGreaterThanOrEqual(HEADER_BYTES);
  // Offsets of SPEC, section 8: one byte of each field after the kind and the codec.
  for (const offset of [2, 4, 8, 16, 24, 28, 32, 36, 38, 40, 42, 44, 46, 48, 52, 56]) {
    const changed = bytes.slice();
    changed[offset] = (changed[offset] ?? 0) ^ 1;
    expect(readHeader(changed.buffer), `offset ${offset}`).not.toEqual(header);
  }
});

test("what is no header is refused with a sentence", () => {
  expect(() => readHeader(new ArrayBuffer(63))).toThrow(/shorter than its header/);
  expect(() => readHeader(new ArrayBuffer(64))).toThrow(/kind 0/);
});
