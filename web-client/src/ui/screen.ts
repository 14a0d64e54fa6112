// Decoded pictures on a canvas.

import type { FrameHeader } from "../core/frame";
import type { DecodedTile } from "../core/pictures";

export interface Screen {
  /** Draws on `canvas` from now on. */
  attach(canvas: HTMLCanvasElement | null): void;
  decode(header: FrameHeader, payload: ArrayBuffer): Promise<ImageBitmap>;
  draw(tiles: readonly DecodedTile<ImageBitmap>[]): void;
}

export function canvasScreen(): Screen {
  let canvas: HTMLCanvasElement | null = null;
  return {
    attach(element) {
      canvas = element;
    },
    decode(header, payload) {
      const picture = new Blob([payload], { type: `image/${header.codec}` });
      return createImageBitmap(picture, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    },
    draw(tiles) {
      const context = canvas?.getContext("2d", { alpha: false });
      if (canvas === null || context === null || context === undefined) return;
      for (const { header, picture } of tiles) {
        resize(canvas, context, header);
        context.drawImage(picture, header.tile.x, header.tile.y);
        picture.close();
      }
    },
  };
}

/** Gives the canvas the frame's size. What it shows stays, as large as it was, until tiles have covered it. */
function resize(
  canvas: HTMLCanvasElement,
  context: CanvasRenderingContext2D,
  { width, height }: FrameHeader,
): void {
  // Setting the size clears the canvas, so only where it changes.
  if (canvas.width === width && canvas.height === height) return;
  const before = new OffscreenCanvas(Math.max(canvas.width, 1), Math.max(canvas.height, 1));
  before.getContext("2d")?.drawImage(canvas, 0, 0);
  Object.assign(canvas, { width, height });
  context.drawImage(before, 0, 0, width, height);
}
