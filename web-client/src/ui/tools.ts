// Tools at work: a shadow or a highlight is taken in the picture and follows the pointer, or keys; places are pinned.

import type { Pixel } from "../core/camera";
import { pinAt } from "../core/pins";
import type { PixelQuestion } from "../core/probing";
import { dragsFeatures, type Tool } from "../core/tools";
import { type TakenFeature, takeFeature } from "./feature_drag";
import { isFree } from "./light_actions";
import type { Page } from "./page";
import { rememberPlace } from "./pin_facts";
import { clickOf, inPicture, questionOn } from "./picture_press";
import { followPointer } from "./pointer";

/** Takes up a tool; what the last one said is gone. */
export function takeTool({ toolbox, answers }: Page, tool: Tool): void {
  if (answers.shown.value?.isOver === true) answers.close();
  toolbox.tool.value = tool;
  toolbox.said.value = null;
}

/** With Shift what is dragged goes this much of the pointer's way. */
const FINE = 0.1;

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
  const feature = takeFeature(page, kind, question, down.pointerType === "touch");
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
    const at = found.seen?.position;
    if (isFree(page, light))
      session.edit({ type: "addPin", pin }, (record) => rememberPlace(page, record, at));
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

/** Goes through the other answers of a drag, or after it to their strip. Returns false where there are none. */
function toAnswers({ toolbox, answers }: Page, back: boolean): boolean {
  if (toolbox.dragged.value !== null) {
    answers.step(back ? -1 : 1);
    return true;
  }
  const taken = document.querySelector<HTMLElement>('.answers[data-over="true"] [aria-pressed="true"]');
  if (taken === null || back) return false;
  taken.focus();
  return true;
}

/** Keys in the place of a pointer: Enter takes what is there and lets it go, arrows move it, Escape takes it back. During any
 * drag of a feature Tab goes through the other answers. What it gives says whether a key was for the tool. */
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
    if (dragsFeatures(kind)) feature = takeFeature(page, kind, question, false);
    else addPin(page, question);
    return true;
  }

  /** Goes on with the feature that keys drag. */
  function goOn(taken: TakenFeature, key: string, steps: number): boolean {
    const way = WAYS[key];
    if (way !== undefined) taken.moveBy({ x: steps * way.x, y: steps * way.y });
    else if (key === "Enter") leave(({ end }) => end());
    else if (key === "Escape") leave(({ cancel }) => cancel());
    else return false;
    return true;
  }

  return (event) => {
    const { key, shiftKey } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    if (key === "Tab") return toAnswers(page, shiftKey);
    if (feature !== null) return goOn(feature, key, shiftKey ? LARGE_STEPS : 1);
    return key === "Enter" && take();
  };
}
