// Decoded pictures on a canvas.

import type { FrameHeader } from "../core/frame";

export interface Screen {
  /** Draws on `canvas` from now on. */
  attach(canvas: HTMLCanvasElement | null): void;
  decode(header: FrameHeader, payload: ArrayBuffer): Promise<ImageBitmap>;
  show(header: FrameHeader, picture: ImageBitmap): void;
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
    show({ width, height, tile }, picture) {
      const context = canvas?.getContext("2d", { alpha: false });
      if (canvas === null || context === null || context === undefined) return;
      // Setting the size clears the canvas, so only where it changes.
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      context.drawImage(picture, tile.x, tile.y);
      picture.close();
    },
  };
}
