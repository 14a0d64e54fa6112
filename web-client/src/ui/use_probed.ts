// Probes a pixel again for every picture.

import { useEffect, useState } from "preact/hooks";

import type { Pixel, View } from "../core/camera";
import { viewSizeOf } from "../core/frame";
import { type Asker, questionAt } from "../core/probing";
import type { Probed } from "../core/protocol";
import { usePage } from "./page";

/** The latest answer about a pixel of the picture as `view` shows it; `null` before the first and outside of the picture. */
export function useProbed(asker: Asker, { width, height }: View, { x, y }: Pixel): Probed | null {
  const { session } = usePage();
  const frame = session.frame.value;
  const [found, setFound] = useState<Probed | null>(null);
  // Another picture may show something else there.
  useEffect(() => {
    const question = frame === null ? null : questionAt({ x, y }, { width, height }, viewSizeOf(frame));
    if (question === null) setFound(null);
    else session.probe(asker, question, setFound);
  }, [session, asker, x, y, width, height, frame]);
  return found;
}
