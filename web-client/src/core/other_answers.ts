// Answers to a drag besides the one under the hand: asked for on demand, gone through, and kept for a while after the drag.

import { type ReadonlySignal, signal } from "@preact/signals-core";

import {
  type AlternativeAnswer,
  type AlternativesReply,
  type FeatureCommand,
  isSameWay,
  stepped,
} from "./alternatives";
import type { Host } from "./connection";
import type { DragAlternative } from "./protocol";

/** A cursor that stays in one place for so long rests there. */
export const REST_MS = 300;
/** Answers stay for so long after the drag, unless somebody is at them. */
export const LINGER_MS = 8000;

/** Answers as the page shows them. */
export interface Answers {
  /** Best first; `null` before the first reply. */
  all: readonly AlternativeAnswer[] | null;
  /** True if a request is under way. */
  isAsking: boolean;
  /** Reason of the last failure. */
  failure: string | null;
  /** True if the drag is a record. */
  isOver: boolean;
}

/** Drag that the answers belong to. */
export interface AnsweredDrag {
  /** The alternative that is shown now; `null` while that is not known. */
  taken(): DragAlternative | null;
  /** Shows another one. */
  take(alternative: DragAlternative): void;
}

export interface OtherAnswers {
  shown: ReadonlySignal<Answers | null>;
  /** A drag begins: answers to another one are gone. */
  begin(drag: AnsweredDrag): void;
  /** The drag asks for `command`, in which any alternative may be taken. */
  moved(command: FeatureCommand): void;
  /** Shows the answers once the cursor rests. */
  openAtRest(): void;
  /** Takes the answer that lies `by` further, as soon as the answers are known. */
  step(by: number): void;
  /** Takes an answer. */
  take(alternative: DragAlternative): void;
  /** The drag is a record, which the answers outlive for a while; `record` takes another in its place. */
  over(record: AnsweredDrag): void;
  /** Somebody is at the answers, or no longer: meanwhile they stay. */
  hold(isHeld: boolean): void;
  close(): void;
}

export interface OtherAnswersParts {
  after: Host["after"];
  ask(command: FeatureCommand): Promise<AlternativesReply>;
}

const NOTHING: Answers = { all: null, isAsking: false, failure: null, isOver: false };

export function otherAnswers({ after, ask }: OtherAnswersParts): OtherAnswers {
  const shown = signal<Answers | null>(null);
  let drag: AnsweredDrag | null = null;
  let wanted: FeatureCommand | null = null;
  let asked: FeatureCommand | null = null;
  let steps = 0;
  let opensAtRest = false;
  let isUnderWay = false;
  /** Numbers the drags: a reply to an earlier one has no effect. */
  let number = 0;
  let stopClock = () => {};

  const set = (changed: Partial<Answers>) => {
    if (shown.value !== null) shown.value = { ...shown.value, ...changed };
  };

  function request(): void {
    if (isUnderWay || wanted === null || shown.value?.isOver !== false) return;
    const [command, of] = [wanted, number];
    isUnderWay = true;
    asked = command;
    set({ isAsking: true });
    void ask(command).then((reply) => {
      isUnderWay = false;
      // Another drag asks for itself, also where it began meanwhile.
      if (number === of) take(reply, command);
      else request();
    });
  }

  function take(reply: AlternativesReply, command: FeatureCommand): void {
    if ("why" in reply) set({ isAsking: false, failure: reply.why });
    else set({ isAsking: false, failure: null, all: reply.alternatives });
    if (shown.value?.isOver === true) {
      linger();
      return;
    }
    if (steps !== 0) go();
    // The cursor may rest elsewhere by now.
    if (wanted !== null && !isSameWay(wanted, command)) rest();
  }

  function go(): void {
    const all = shown.value?.all ?? null;
    if (all === null || drag === null) return;
    const next = stepped(all, drag.taken(), steps);
    steps = 0;
    if (next !== null) drag.take(next);
  }

  function rest(): void {
    stopClock();
    stopClock = after(REST_MS, () => {
      if (shown.value === null && opensAtRest) shown.value = NOTHING;
      request();
    });
  }

  function close(): void {
    stopClock();
    number += 1;
    shown.value = null;
    drag = null;
    wanted = null;
    asked = null;
    steps = 0;
    opensAtRest = false;
  }

  function linger(): void {
    stopClock();
    stopClock = after(LINGER_MS, close);
  }

  return {
    shown,
    begin(next) {
      close();
      drag = next;
    },
    moved(command) {
      if (drag === null) return;
      const isNew = wanted === null || !isSameWay(wanted, command);
      wanted = command;
      if (!isNew || (shown.value === null && !opensAtRest)) return;
      if (asked === null || !isSameWay(asked, command)) rest();
      else stopClock();
    },
    openAtRest() {
      opensAtRest = true;
    },
    step(by) {
      if (drag === null || wanted === null) return;
      steps += by;
      if (shown.value === null) {
        shown.value = NOTHING;
        request();
      } else if (shown.value.all !== null) go();
      else request();
    },
    take: (alternative) => drag?.take(alternative),
    over(record) {
      // A reply that is under way still belongs to the drag.
      if (shown.value === null || (shown.value.all === null && !isUnderWay)) {
        close();
        return;
      }
      drag = record;
      set({ isOver: true });
      linger();
    },
    hold(isHeld) {
      if (shown.value?.isOver !== true) return;
      if (isHeld) stopClock();
      else linger();
    },
    close,
  };
}
