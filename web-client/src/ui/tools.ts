// Tools at work: a shadow or a highlight is taken in the picture and follows the pointer, or keys; places are pinned.

import type { Pixel } from "../core/camera";
import { lightOf } from "../core/document";
import type { Drag } from "../core/drags";
import type { PixelQuestion } from "../core/probing";
import type { DragKind, ProbedLight } from "../core/protocol";
import {
  dragsFeatures,
  featureDrag,
  nothingTaken,
  pinAt,
  type Seen,
  takenLight,
  type Tool,
} from "../core/tools";
import { isFree } from "./light_actions";
import { type Page, reachFor, selectLight } from "./page";
import { clickOf, inPicture, questionOn } from "./picture_press";
import { followPointer } from "./pointer";

/** Takes up a tool; what the last one said is gone. */
export function takeTool({ toolbox }: Page, tool: Tool): void {
  toolbox.tool.value = tool;
  toolbox.said.value = null;
}

/** Features and pins are for who sees through a camera of which the server knows. */
function seenBy({ session }: Page, size: PixelQuestion["size"]): Seen | null {
  const camera = session.viewer.cameraOf(session.frame.value);
  return camera === null ? null : { camera, size };
}

/** With Shift what is dragged goes this much of the pointer's way. */
const FINE = 0.1;

/** A feature on its way: taken once the server has said which light makes it. */
interface TakenFeature {
  /** By so many pixels of the picture. */
  moveBy(way: Pixel): void;
  end(): void;
  cancel(): void;
}

/** Takes the feature at `question`, where a light makes one. */
function takeFeature(page: Page, kind: DragKind, question: PixelQuestion): TakenFeature {
  const { session, toolbox } = page;
  const way: Pixel = { x: 0, y: 0 };
  let drag: Drag | null = null;
  let isLetGo = false;
  let isCancelled = false;

  function update(): void {
    const { value: dragged } = toolbox.dragged;
    if (drag === null || dragged === null) return;
    const { id, light, from, seen } = dragged;
    const to = { x: from.x + way.x, y: from.y + way.y };
    toolbox.dragged.value = { ...dragged, to };
    // A press that goes nowhere moves nothing.
    if (way.x === 0 && way.y === 0 && session.ownDrag.value === null) return;
    drag.update(featureDrag(kind, [id, light], toolbox.following.value, seen, [from, to]));
  }

  function begin({ light: id, highlight }: ProbedLight): void {
    const light = lightOf(session.document.value, id);
    const seen = seenBy(page, question.size);
    if (light === undefined || seen === null) return;
    if (!reachFor(page, id)) return;
    selectLight(page, id);
    // A highlight goes on from its centre, so that it does not jump under the pointer.
    const from =
      highlight === undefined || highlight === null ? question.pixel : { x: highlight[0], y: highlight[1] };
    toolbox.dragged.value = { kind, id, light, from, to: from, seen };
    drag = session.drag(id);
    update();
    if (isLetGo) end();
  }

  function end(): void {
    isLetGo = true;
    if (drag === null) return;
    toolbox.dragged.value = null;
    drag.commit();
  }

  function cancel(): void {
    isCancelled = true;
    if (drag === null) return;
    toolbox.dragged.value = null;
    drag.cancel();
  }

  toolbox.said.value = null;
  session.probe("tool", { ...question, highlights: kind === "highlight" }, (found) => {
    // A second finger cancels the query of the first one, which then has no effect.
    if (found === null || isCancelled) return;
    const taken = takenLight(kind, found, page.selectedLight.value);
    if (taken !== null) begin(taken);
    else toolbox.said.value = nothingTaken(kind, found);
  });
  return {
    moveBy(by) {
      way.x += by.x;
      way.y += by.y;
      update();
    },
    end,
    cancel,
  };
}

/** Gives a press on the picture to the active tool. Returns true if the tool takes it. */
export function pressTool(down: PointerEvent, page: Page): boolean {
  const stage = down.currentTarget as HTMLElement;
  const kind = page.toolbox.tool.value;
  if (kind === "select" || clickOf(page) !== null || down.button !== 0 || down.altKey) return false;
  const question = questionOn(stage, page, inPicture(stage, down));
  if (question === null) return false;
  down.preventDefault();
  stage.focus({ preventScroll: true });
  if (!dragsFeatures(kind)) {
    // The release has no effect: a pin is placed at the pressed point.
    followPointer(down, { move: () => {}, end: () => addPin(page, question) });
    return true;
  }
  const feature = takeFeature(page, kind, question);
  const shown = stage.querySelector("canvas")?.getBoundingClientRect();
  const scale = shown === undefined ? 1 : question.size.width / shown.width;
  followPointer(down, {
    move(_, by, event) {
      const share = scale * (event.shiftKey ? FINE : 1);
      feature.moveBy({ x: share * by.x, y: share * by.y });
    },
    end: feature.end,
    cancel: feature.cancel,
  });
  return true;
}

/** Pins the pressed point of the picture or its object, for the selected light. */
export function addPin(page: Page, question: PixelQuestion): void {
  const { session, selectedLight, toolbox } = page;
  session.probe("tool", question, (found) => {
    const light = selectedLight.value;
    if (found === null || light === null) return;
    const pin = pinAt(toolbox.nextPin.value, light, found);
    if (typeof pin === "string") {
      toolbox.said.value = pin;
      return;
    }
    toolbox.said.value = null;
    if (isFree(page, light)) session.edit({ type: "addPin", pin });
  });
}

/** Directions of a drag by arrow keys, y down. */
const WAYS: { [key: string]: Pixel } = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: -1 },
  ArrowDown: { x: 0, y: 1 },
};
const LARGE_STEPS = 10;

/** Keys in the place of a pointer: Enter takes what is there and lets it go, arrows move it, Escape takes it back. What it gives says
 * whether a key was for the tool. */
export function toolKeys(page: Page, here: () => PixelQuestion | null): (event: KeyboardEvent) => boolean {
  let feature: TakenFeature | null = null;
  const leave = (how: (feature: TakenFeature) => void) => {
    if (feature !== null) how(feature);
    feature = null;
  };

  function take(): boolean {
    const kind = page.toolbox.tool.value;
    const question = here();
    if (kind === "select" || question === null) return false;
    if (dragsFeatures(kind)) feature = takeFeature(page, kind, question);
    else addPin(page, question);
    return true;
  }

  return (event) => {
    const { key, shiftKey } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    if (feature === null) return key === "Enter" && take();
    const way = WAYS[key];
    const steps = shiftKey ? LARGE_STEPS : 1;
    if (way !== undefined) feature.moveBy({ x: steps * way.x, y: steps * way.y });
    else if (key === "Enter") leave(({ end }) => end());
    else if (key === "Escape") leave(({ cancel }) => cancel());
    else return false;
    return true;
  };
}
