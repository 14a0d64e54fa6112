// Watches whether hard pins hold: probes their points, one at a time, once the document has changed and nothing is dragged.

import { computed, effect } from "@preact/signals";

import type { View } from "../core/camera";
import type { Host } from "../core/connection";
import { atPin, pinHolds } from "../core/pin_state";
import { pinsOf } from "../core/pins";
import type { Pin, ProbedLight } from "../core/protocol";
import type { Page } from "./page";
import { pictureView, pixelOf, placeOf } from "./pin_facts";

/** After a change, so that several that come together are one. */
const SETTLE_MS = 250;

/** Watches the pins of the selected light for as long as the page lives. */
export function watchPins(page: Page, { after }: Host): void {
  const { session, selectedLight, toolbox } = page;
  let stopClock = () => {};
  /** Numbers the rounds: a newer one ends those before. */
  let round = 0;
  const isCurrent = (started: number) => () => started === round;
  const hasPicture = computed(() => session.frame.value !== null);
  effect(() => {
    // Whatever may change what a pin's point looks like, or whether it is seen.
    void session.mirror.value.seq;
    void session.viewer.revision.value;
    void toolbox.pinPlaces.value;
    const light = selectedLight.value;
    const isBusy = session.ownDrag.value !== null || session.gestures.value.length > 0;
    round += 1;
    stopClock();
    if (isBusy || !hasPicture.value || pinsOf(session.document.peek(), light).length === 0) return;
    stopClock = after(SETTLE_MS, () => check(page, pinsOf(session.document.peek(), light), isCurrent(round)));
  });
}

interface Entry {
  id: number;
  pin: Pin;
}

interface Found {
  node: string;
  light: ProbedLight;
}

function check(page: Page, pins: readonly Entry[], isCurrent: () => boolean): void {
  const view = pictureView(page);
  const [first, ...others] = pins;
  if (first === undefined || view === null || !isCurrent()) return;
  checkOne(page, view, first, () => check(page, others, isCurrent));
}

function checkOne(page: Page, view: View, { id, pin }: Entry, next: () => void): void {
  const at = placeOf(page, id, pin);
  const pixel = at === null ? null : pixelOf(view, at);
  if (at === null || pixel === null) {
    next();
    return;
  }
  page.session.probe("pin", { pixel, size: { width: view.width, height: view.height } }, (found) => {
    const light = found === null ? null : atPin(pin, at, found);
    if (found?.seen != null && light !== null) note(page, id, pin, { node: found.seen.node, light });
    next();
  });
}

/** Notes what was found at the point of a pin. */
function note({ toolbox: { pinFacts } }: Page, id: number, pin: Pin, found: Found): void {
  const { sights, broken } = pinFacts.value;
  const first = sights.get(id);
  const isBroken = pin.hard && pinHolds(pin, found.light, first?.state ?? null) === false;
  if (first !== undefined && isBroken === broken.has(id)) return;
  pinFacts.value = {
    sights:
      first === undefined ? new Map(sights).set(id, { node: found.node, state: found.light.state }) : sights,
    broken: new Set(isBroken ? [...broken, id] : [...broken].filter((other) => other !== id)),
  };
}
