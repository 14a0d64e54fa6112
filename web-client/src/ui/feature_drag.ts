// Drags of features: one is taken in the picture, follows the pointer or keys, and may end in another answer.

import type { FeatureCommand } from "../core/alternatives";
import type { Pixel } from "../core/camera";
import { lightOf } from "../core/document";
import type { Drag } from "../core/drags";
import { alternativeOf, featureDrag, type Seen } from "../core/following";
import type { PixelQuestion } from "../core/probing";
import type {
  DragAlternative,
  DragChoice,
  DragKind,
  DragOutcome,
  ProbedLight,
  Record,
} from "../core/protocol";
import { nothingTaken, takenLight } from "../core/tools";
import { type Page, reachFor, selectLight } from "./page";
import type { Dragged } from "./toolbox";

/** Features and pins are for who sees through a camera of which the server knows. */
function seenBy({ session }: Page, size: PixelQuestion["size"]): Seen | null {
  const camera = session.viewer.cameraOf(session.frame.value);
  return camera === null ? null : { camera, size };
}

/** A feature on its way: taken once the server has said which light makes it. */
export interface TakenFeature {
  /** By so many pixels of the picture. */
  moveBy(way: Pixel): void;
  end(): void;
  cancel(): void;
}

/** Takes the feature at `question`, where a light makes one. */
export function takeFeature(
  page: Page,
  kind: DragKind,
  question: PixelQuestion,
  byFinger: boolean,
): TakenFeature {
  const { session, toolbox, answers } = page;
  const way: Pixel = { x: 0, y: 0 };
  let drag: Drag | null = null;
  let isLetGo = false;
  let isCancelled = false;

  function update(): void {
    const { value: dragged } = toolbox.dragged;
    if (drag === null || dragged === null) return;
    const { from } = dragged;
    const moved = { ...dragged, to: { x: from.x + way.x, y: from.y + way.y } };
    toolbox.dragged.value = moved;
    // A press that goes nowhere moves nothing.
    if (way.x === 0 && way.y === 0 && session.ownDrag.value === null) return;
    drag.update(commandOf(page, moved, moved.chosen));
    answers.moved(commandOf(page, moved, "best"));
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
    toolbox.dragged.value = { kind, id, light, from, to: from, seen, chosen: null, byFinger };
    drag = session.drag(id);
    answers.begin({
      taken: () => takenNow(page),
      take(chosen) {
        if (toolbox.dragged.value === null) return;
        toolbox.dragged.value = { ...toolbox.dragged.value, chosen };
        update();
      },
    });
    // A finger has no key for it.
    if (byFinger) answers.openAtRest();
    update();
    if (isLetGo) end();
  }

  function end(): void {
    isLetGo = true;
    const { value: dragged } = toolbox.dragged;
    if (drag === null || dragged === null) return;
    const taken = takenNow(page);
    const moves = session.ownDrag.value !== null;
    toolbox.dragged.value = null;
    const end = replacing(page, dragged, taken);
    drag.commit(end.committed);
    if (moves) end.begin();
    else answers.close();
  }

  function cancel(): void {
    isCancelled = true;
    // A second finger may come after the answer that nothing is taken.
    toolbox.said.value = null;
    if (drag === null) return;
    toolbox.dragged.value = null;
    answers.close();
    drag.cancel();
  }

  toolbox.said.value = null;
  answers.close();
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

function commandOf(
  { toolbox }: Page,
  { kind, id, light, seen, from, to }: Dragged,
  chosen: DragChoice | null,
): FeatureCommand {
  return featureDrag(kind, [id, light], toolbox.following.value, seen, [from, to], chosen);
}

/** The alternative under the hand, as far as it is known. */
export function takenNow({ session, toolbox }: Page): DragAlternative | null {
  const { outcome } = session.ownDrag.value ?? {};
  return toolbox.dragged.value?.chosen ?? outcome?.alternative ?? alternativeOf(toolbox.following.value.mode);
}

/** Lets another answer take the place of a drag that is over, as long as it is the latest step. */
function replacing(page: Page, dragged: Dragged, first: DragAlternative | null) {
  const { session, answers } = page;
  let taken = first;
  /** The record that an answer would replace; `null` while it is under way. */
  let seq: number | null = null;

  function committed(record: Record): void {
    seq = record.seq;
    taken = outcomeOf(record)?.alternative ?? taken;
    page.toolbox.answered.value = taken;
  }

  function take(alternative: DragAlternative): void {
    if (seq === null || alternative === taken) return;
    // Later steps would be taken back in its place.
    const { value: history } = session.history;
    const isKnown = history !== null && history.seq >= seq;
    if (isKnown && history.undo.mine?.seq !== seq) {
      page.say("Something has been changed since the drag: undo that, or drag again");
      answers.close();
      return;
    }
    seq = null;
    session.undo("mine");
    session.edit(commandOf(page, dragged, alternative), committed);
  }

  return {
    committed,
    begin() {
      page.toolbox.answered.value = taken;
      answers.over({ taken: () => taken, take });
    },
  };
}

function outcomeOf({ action }: Record): DragOutcome | undefined {
  return "outcome" in action ? (action.outcome ?? undefined) : undefined;
}
