// Strip of the other answers to a drag: a picture of each, with its residual and what changes.

import { useRef } from "preact/hooks";

import { ALTERNATIVE_NAMES, type AlternativeAnswer, canBeTaken, changesText } from "../core/alternatives";
import type { Answers } from "../core/other_answers";
import { shortText } from "../core/outcome_texts";
import type { DragAlternative } from "../core/protocol";
import { takenNow } from "./feature_drag";
import { Icon } from "./icons";
import { type Page, usePage } from "./page";
import { pinNameOf } from "./pin_facts";
import { QuietButton } from "./quiet_button";

/** A cursor below this share of the picture's height has the strip above it. */
const LOW_SHARE = 0.6;

export function AnswerStrip() {
  const page = usePage();
  const { answers, toolbox } = page;
  // It stays where it is once the drag is over.
  const side = useRef<"top" | "bottom">("bottom");
  const shown = answers.shown.value;
  if (shown === null) return null;
  const { all, isAsking, isOver } = shown;
  const dragged = toolbox.dragged.value;
  if (dragged !== null) side.current = dragged.to.y > LOW_SHARE * dragged.seen.size.height ? "top" : "bottom";
  const taken = isOver ? toolbox.answered.value : takenNow(page);
  return (
    <section
      class="answers"
      aria-label="Other answers"
      data-over={isOver}
      data-side={side.current}
      onPointerEnter={() => answers.hold(true)}
      onPointerLeave={() => answers.hold(false)}
      onFocusIn={() => answers.hold(true)}
      onFocusOut={() => answers.hold(false)}
      onKeyDown={(event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        leave(page);
      }}
    >
      <header>
        <span role="status">{noteOf(shown, dragged?.byFinger === true)}</span>
        {isOver && (
          <QuietButton title="Close (Escape)" label="Close the other answers" press={() => leave(page)}>
            <Icon name="close" />
          </QuietButton>
        )}
      </header>
      {all !== null && (
        <ul data-old={isAsking}>
          {all.map((answer) => (
            <li key={answer.alternative}>
              <Answer answer={answer} isTaken={answer.alternative === taken} />
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

/** Closes the strip; keys go on in the picture. */
function leave({ answers }: Page): void {
  answers.close();
  document.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
}

function noteOf({ all, isAsking, failure, isOver }: Answers, byFinger: boolean): string {
  if (failure !== null) return `${all === null ? "No other answers" : "Not solved again"}: ${failure}`;
  if (all === null) return "Solving the other answers";
  if (isOver) return "Other answers: press one to take it instead";
  if (isAsking) return "Solving again for this place";
  return byFinger ? "Let go, then press an answer" : "Tab: next answer, Shift+Tab: the one before";
}

const ANSWER_TITLES: { [A in DragAlternative]: string } = {
  wholeLight: "Move the light as a whole",
  controlPoints: "Bend the light by its control points",
  narrower: "Bend the light, and narrow it where it would fold",
  pastCaster: "Change the light past what casts the shadow alone",
  linkedCopy: "Add a linked copy of the light, which lights the rest as before",
};

function Answer({ answer, isTaken }: { answer: AlternativeAnswer; isTaken: boolean }) {
  const page = usePage();
  const { alternative, thumbnail, changedShare, pin } = answer;
  const name = ALTERNATIVE_NAMES[alternative];
  const lines = [shortText(answer, pinNameOf(page, pin)), changesText(changedShare)].filter(
    (line) => line !== null,
  );
  const isFree = canBeTaken(answer);
  return (
    <button
      class="answer"
      title={ANSWER_TITLES[alternative]}
      aria-pressed={isTaken}
      aria-disabled={!isFree}
      data-status={answer.status}
      onClick={() => isFree && page.answers.take(alternative)}
    >
      {thumbnail === undefined ? (
        <span class="no-thumbnail" />
      ) : (
        <img src={`data:image/png;base64,${thumbnail}`} alt="" width={160} height={90} draggable={false} />
      )}
      <span class="answer-name">{name}</span>
      {lines.map((line) => (
        <span key={line} class="answer-line">
          {line}
        </span>
      ))}
    </button>
  );
}
