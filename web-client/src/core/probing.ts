// Questions about pixels (SPEC, PROBE-1 to PROBE-5): one is on its way at a time, and of each asker's the latest counts.

import type { Pixel, Size } from "./camera";
import type { Host } from "./connection";
import type { ClientMessage, ProbeAnswer, Probed } from "./protocol";

/** Purpose of a probe: the panel at the pointer, a drag that snaps, a light that is aimed, an object that is linked, a tool's feature under the
 * pointer and the grabbed one, a view that turns, pins that are checked, an object that is looked for. */
export type Asker = "panel" | "snap" | "aim" | "link" | "hover" | "tool" | "orbit" | "pin" | "find";

/** A pixel of a picture of one's view, which is `size` pixels large. */
export interface PixelQuestion {
  pixel: Pixel;
  size: Size;
  /** True if the positions of highlights are queried. */
  highlights?: boolean;
}

/** Told what is there; `null` where the server does not say. Of a question that a later one replaced, never. */
export type OnProbed = (found: Probed | null) => void;

export interface Probing {
  ask(asker: Asker, question: PixelQuestion, onProbed: OnProbed): void;
  answered(answer: ProbeAnswer): void;
  /** The connection is gone, and with it all answers. */
  lost(): void;
}

export interface ProbingParts {
  host: Host;
  send(message: ClientMessage): boolean;
}

interface Asked extends PixelQuestion {
  onProbed: OnProbed;
}

export function probing({ host, send }: ProbingParts): Probing {
  const waiting = new Map<Asker, Asked>();
  let onItsWay: { name: string; onProbed: OnProbed } | null = null;

  function sendNext(): void {
    const [next] = waiting;
    if (onItsWay !== null || next === undefined) return;
    const [asker, { pixel, size, highlights = false, onProbed }] = next;
    waiting.delete(asker);
    const name = host.newId();
    onItsWay = { name, onProbed };
    const isSent = send({
      type: "probe",
      probe: name,
      pixel: [pixel.x, pixel.y],
      size: [size.width, size.height],
      highlights,
    });
    if (!isSent) lost();
  }

  function lost(): void {
    const all = [...(onItsWay === null ? [] : [onItsWay]), ...waiting.values()];
    onItsWay = null;
    waiting.clear();
    for (const { onProbed } of all) onProbed(null);
  }

  return {
    ask(asker, question, onProbed) {
      waiting.set(asker, { ...question, onProbed });
      sendNext();
    },
    answered({ probe, found }) {
      if (onItsWay?.name !== probe) return;
      const { onProbed } = onItsWay;
      onItsWay = null;
      onProbed(found);
      sendNext();
    },
    lost,
  };
}

/** The question for `pixel` of a picture that is shown as large as `shown` and has `size` pixels; `null` outside of it. */
export function questionAt(pixel: Pixel, shown: Size, size: Size): PixelQuestion | null {
  const isInside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < shown.width && pixel.y < shown.height;
  if (!isInside) return null;
  const inPixels: Pixel = {
    x: (pixel.x / shown.width) * size.width,
    y: (pixel.y / shown.height) * size.height,
  };
  return { pixel: inPixels, size: { width: size.width, height: size.height } };
}
