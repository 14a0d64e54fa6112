// Exposure of one's own view; the document and the pictures of other actors do not depend on it.

import type { Binding } from "./binding";
import { usePage } from "./page";
import { Slider } from "./slider";

/** Ends of the slider, stops; the number beside it goes on to those of the server. */
const SLIDER = 8;
const LIMIT = 32;
const STEP = 0.1;

export function ViewExposure() {
  const { viewer } = usePage().session;
  const { exposure } = viewer.shownSettings.value;
  const set = (stops: number) => viewer.set({ exposure: stops });
  const binding: Binding<number> = {
    set,
    drag: () => ({ update: set, commit() {}, cancel: () => set(exposure) }),
  };
  return (
    <Slider
      label="View exposure"
      doc="Brightens the picture that you see, before it is tone-mapped. In stops."
      value={exposure}
      binding={binding}
      from={-SLIDER}
      to={SLIDER}
      step={STEP}
      clamp={(stops) => Math.min(Math.max(stops, -LIMIT), LIMIT)}
      unit=" stops"
      reset={exposure === 0 ? undefined : { to: "0 stops", run: () => set(0) }}
      disabled={viewer.following.value !== null}
    />
  );
}
