// The header of a frame (SPEC, section 8).

import type { Size } from "./camera";

/** Bytes of the header; the payload follows. */
export const HEADER_BYTES = 64;

const PICTURE = 1;
const CODECS = { 1: "jpeg", 2: "png" } as const;
const KEY = 1;
const SETTLE = 2;
const LAST_TILE = 4;

export interface Tile {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface FrameHeader {
  codec: "jpeg" | "png";
  key: boolean;
  /** The lossless picture of a still view. */
  settle: boolean;
  lastTile: boolean;
  view: number;
  /** Counts from 1 for this connection. */
  frame: number;
  /** The record up to which the picture shows the document. */
  logSeq: number;
  cameraRevision: number;
  liveRevision: number;
  /** Samples a pixel. */
  samples: number;
  /** By how much the texels a side of shadow maps are divided: 1 where they are full. */
  shadowMapDivisor: number;
  tile: Tile;
  width: number;
  height: number;
  waitUs: number;
  renderUs: number;
  encodeUs: number;
  /** Width of the view, at which a picture that is reduced while something moves is displayed. */
  viewWidth: number;
  viewHeight: number;
}

/** The header of `message`; throws an `Error` that says what is wrong where it is none. */
export function readHeader(message: ArrayBuffer): FrameHeader {
  if (message.byteLength < HEADER_BYTES) {
    throw new Error(`A frame of ${message.byteLength} bytes is shorter than its header: reload the page.`);
  }
  const view = new DataView(message);
  const u16 = (at: number) => view.getUint16(at, true);
  const u32 = (at: number) => view.getUint32(at, true);
  const u64 = (at: number) => Number(view.getBigUint64(at, true));
  const codec = CODECS[view.getUint8(1) as keyof typeof CODECS];
  if (view.getUint8(0) !== PICTURE || codec === undefined) {
    throw new Error(
      `This page cannot read frames of kind ${view.getUint8(0)}, codec ${view.getUint8(1)}: reload the page.`,
    );
  }
  const flags = u16(2);
  return {
    codec,
    key: (flags & KEY) !== 0,
    settle: (flags & SETTLE) !== 0,
    lastTile: (flags & LAST_TILE) !== 0,
    view: u32(4),
    frame: u64(8),
    logSeq: u64(16),
    cameraRevision: u32(24),
    liveRevision: u32(28),
    samples: u16(32),
    shadowMapDivisor: u16(34),
    tile: { x: u16(36), y: u16(38), width: u16(40), height: u16(42) },
    width: u16(44),
    height: u16(46),
    waitUs: u32(48),
    renderUs: u32(52),
    encodeUs: u32(56),
    viewWidth: u16(60),
    viewHeight: u16(62),
  };
}

/** True if the message contains the whole picture: then no earlier one matters. */
export function isWhole({ tile, width, height }: FrameHeader): boolean {
  return tile.width === width && tile.height === height;
}

/** The pixels that the frame's picture is shown as, and that are picked, probed and dragged in, however many it has. */
export function viewSizeOf({ viewWidth, viewHeight }: FrameHeader): Size {
  return { width: viewWidth, height: viewHeight };
}

/** Names the reductions of a frame; empty if there are none. */
export function reductionsOf(header: FrameHeader): string {
  const share = header.width / header.viewWidth;
  const resolution = share > 0.9 ? [] : [share > 0.6 ? "three-quarter resolution" : "half resolution"];
  const shadowMap = header.shadowMapDivisor > 1 ? ["half shadow map"] : [];
  return [...resolution, ...shadowMap].join(", ");
}
