// Presses on the picture beside all handles: tools that work on the picture take them before the view does.

import type { Pixel, Size } from "../core/camera";
import { viewSizeOf } from "../core/frame";
import { orbit, pan } from "../core/navigation";
import { type PixelQuestion, questionAt } from "../core/probing";
import { aimAt, isAiming } from "./directing";
import { isLinking, linkAt } from "./linking";
import type { Vec3 } from "../core/vector";
import type { Page } from "./page";
import { followPointer } from "./pointer";
import { isProbing } from "./probe_view";

const RADIANS_PER_PIXEL = 0.006;
/** A press that moves less is a click. */
const CLICK_PX = 4;

/** Position of a pointer in the picture of the stage under it. */
export function inPicture(stage: Element, { clientX, clientY }: MouseEvent): Pixel {
  const { x, y } = stage.querySelector("canvas")?.getBoundingClientRect() ?? { x: 0, y: 0 };
  return { x: clientX - x, y: clientY - y };
}

/** Query of a pixel of the picture on the stage; `null` beside the picture, and while there is none. */
export function questionOn(stage: Element, { session }: Page, pixel: Pixel): PixelQuestion | null {
  const [shown, frame] = [stage.querySelector("canvas")?.getBoundingClientRect(), session.frame.value];
  return shown === undefined || frame === null ? null : questionAt(pixel, shown, viewSizeOf(frame));
}

/** `size` is the stage's. */
export function pressPicture(down: PointerEvent, page: Page, size: Size): void {
  if (down.button === 2) return;
  down.preventDefault();
  const stage = down.currentTarget as HTMLElement;
  stage.focus({ preventScroll: true });
  const click = clickOf(page);
  // A finger cannot hover: while pixels are asked about, it points at them.
  if (down.pointerType === "touch" && isProbing(page) && click === null) return;
  // Such a click leaves drags to the view.
  const take = () => click?.(page, questionOn(stage, page, inPicture(stage, down)));
  navigate(down, page, size, click === null ? null : take);
}

/** Task of a click in the picture, if the user has chosen one: then neither handles nor tools get the click. */
export function clickOf(page: Page): ((page: Page, question: PixelQuestion | null) => void) | null {
  if (isAiming(page)) return aimAt;
  return isLinking(page) ? linkAt : null;
}

/** Alt with the left button or the left button on nothing orbits, about what is seen under the press; shift or the middle button
 * pans. A click does `click`, or else selects the light as a whole. */
function navigate(down: PointerEvent, page: Page, size: Size, click: (() => void) | null): void {
  const { viewer } = page.session;
  const pans = down.button === 1 || down.shiftKey;
  const pressed = questionOn(
    down.currentTarget as Element,
    page,
    inPicture(down.currentTarget as Element, down),
  );
  let way = 0;
  // Until the answer is there, and where nothing is, it is what the camera looks at.
  let about: Vec3 | undefined;
  const ask = () => {
    if (pressed === null || pans || viewer.following.value !== null) return;
    page.session.probe("orbit", pressed, (found) => (about = found?.seen?.position));
  };
  followPointer(down, {
    move(_, by) {
      if (way === 0) ask();
      way += Math.hypot(by.x, by.y);
      if (way < CLICK_PX) return;
      const [yaw, pitch] = [-by.x * RADIANS_PER_PIXEL, -by.y * RADIANS_PER_PIXEL];
      viewer.move((from) => (pans ? pan(from, size, by) : orbit(from, yaw, pitch, about)));
    },
    end() {
      if (way >= CLICK_PX || pans) return;
      if (click === null) page.selectedPoint.value = null;
      else click();
    },
  });
}

/** Follows the pointer over the picture, for what is asked about the pixel under it. */
export function hovering({ probe }: Page) {
  const follow = (event: PointerEvent) => {
    probe.at.value = inPicture(event.currentTarget as Element, event);
    probe.byFinger.value = event.pointerType === "touch";
  };
  return {
    onPointerDown: follow,
    onPointerMove: follow,
    // A finger that is lifted leaves what it has asked in sight.
    onPointerLeave: (event: PointerEvent) => {
      if (event.pointerType !== "touch") probe.at.value = null;
    },
  };
}
