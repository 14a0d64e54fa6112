// Facts about pins that the document does not have: where a pinned object was seen, and the state of pinned points.

import { isInPicture, type Pixel, project, type View } from "../core/camera";
import { viewSizeOf } from "../core/frame";
import { isNode } from "../core/pin_state";
import { pinText } from "../core/pins";
import type { Pin, Record } from "../core/protocol";
import type { Vec3 } from "../core/vector";
import { type Page, selectLight } from "./page";

/** Point at which a pin is drawn and checked; `null` for a pinned object that the page has not seen. */
export const placeOf = ({ toolbox }: Page, id: number, { at }: Pin): Vec3 | null =>
  typeof at === "string" ? (toolbox.pinPlaces.value.get(id) ?? null) : at;

/** Name of a pin, with the object that its point lies on once that is known. */
export const pinName = ({ toolbox }: Page, id: number, pin: Pin): string =>
  pinText(pin, toolbox.pinFacts.value.sights.get(id)?.node);

/** Name of the pin with this id in results; `null` where there is none. */
export function pinNameOf(page: Page, id: number | undefined): string | null {
  const entry = (page.session.document.value.pins ?? []).find((other) => other.id === id);
  return entry === undefined ? null : pinName(page, entry.id, entry.pin);
}

/** The page's picture as the server probes it; `null` while there is none. */
export function pictureView({ session }: Page): View | null {
  const frame = session.frame.value;
  const camera = session.viewer.cameraOf(frame);
  return frame === null || camera === null ? null : { camera, ...viewSizeOf(frame) };
}

/** Pixel of the picture at which `at` is seen, if nothing is in front of it. */
export function pixelOf(view: View, at: Vec3): Pixel | null {
  const pixel = project(view, at);
  return pixel !== null && isInPicture(view, pixel) ? pixel : null;
}

/** Remembers the point at which the pin that `record` adds was set. */
export function rememberPlace(
  { toolbox: { pinPlaces } }: Page,
  { changes }: Record,
  at: Vec3 | undefined,
): void {
  const added = changes.find((change) => change.type === "pin");
  if (added === undefined || at === undefined) return;
  pinPlaces.value = new Map(pinPlaces.value).set(added.pin, at);
}

/** The mark of a pin that was chosen flashes for so long. */
const FLASH_MS = 1600;
/** Pixels across and down at which a pinned object is looked for. */
const GRID = { across: 12, down: 7 };

/** Selects a pin and its light, and flashes its mark; a pinned object is looked for in the picture first. */
export function showPin(page: Page, id: number, pin: Pin): void {
  const { toolbox } = page;
  selectLight(page, pin.light);
  toolbox.selectedPin.value = id;
  const flash = { pin: id };
  const start = () => {
    toolbox.flash.value = flash;
    setTimeout(() => {
      if (toolbox.flash.value === flash) toolbox.flash.value = null;
    }, FLASH_MS);
  };
  const view = pictureView(page);
  const place = placeOf(page, id, pin);
  if (place !== null && view !== null && pixelOf(view, place) === null)
    page.say("The pin is out of the picture");
  if (place !== null || view === null || typeof pin.at !== "string") start();
  else
    findObject(page, view, pin.at, (at) => {
      if (at === null) page.say("The pinned object is not seen in this view");
      else toolbox.pinPlaces.value = new Map(toolbox.pinPlaces.value).set(id, at);
      start();
    });
}

/** Looks for a node in the picture, from the middle outwards. */
function findObject(page: Page, view: View, node: string, found: (at: Vec3 | null) => void): void {
  const pixels = gridOf(view);
  const next = (k: number) => {
    const pixel = pixels[k];
    if (pixel === undefined) found(null);
    else
      page.session.probe("find", { pixel, size: view }, (probed) => {
        const seen = probed?.seen;
        if (seen != null && isNode(seen.node, node)) found(seen.position);
        else next(k + 1);
      });
  };
  next(0);
}

function gridOf({ width, height }: View): Pixel[] {
  const middle: Pixel = { x: width / 2, y: height / 2 };
  const pixels = Array.from({ length: GRID.across * GRID.down }, (_, k): Pixel => {
    const [column, row] = [k % GRID.across, Math.floor(k / GRID.across)];
    return { x: ((column + 0.5) / GRID.across) * width, y: ((row + 0.5) / GRID.down) * height };
  });
  const distance = ({ x, y }: Pixel) => Math.hypot(x - middle.x, y - middle.y);
  return pixels.sort((a, b) => distance(a) - distance(b));
}
