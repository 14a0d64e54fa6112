// Hints on the demo scene, one at a time beside what it speaks of, until a person has seen or closed them.

import { isInPicture, type Pixel, project, type Size, type View } from "../core/camera";
import type { Tool } from "../core/tools";
import type { Vec3 } from "../core/vector";
import { Icon } from "./icons";
import { keepHintsSeen } from "./kept";
import { type Page, usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { takeTool } from "./tools";

interface Hint {
  /** Point of the demo's world that the hint is about. */
  at: Vec3;
  text: string;
  tool: Tool;
  /** Button that selects the tool. */
  button: string;
}

/** The scene that they speak of. */
const DEMO = "demo:vases";
const HINTS: readonly Hint[] = [
  {
    at: [0.2, 0, 0.6],
    text: "Take this shadow: press it with the tool Shadow and drag it to where the picture wants it. The light follows.",
    tool: "shadow",
    button: "Shadow (2)",
  },
  {
    at: [-0.62, 0.35, 0.5],
    text: "Pin this vase: click it with the tool Pin. That point keeps its look while you drag the shadow.",
    tool: "pin",
    button: "Pin (6)",
  },
];

interface HintsProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: Size;
}

/** Pixels. */
const WIDTH = 250;
const FROM_EDGE = 8;
const BESIDE = 20;

/** No more of them, in this browser. */
function close({ hint }: Page): void {
  hint.value = null;
  keepHintsSeen();
}

export function Hints({ view, at, size }: HintsProps) {
  const page = usePage();
  const { session, hint } = page;
  const number = hint.value ?? -1;
  const said = HINTS[number];
  if (said === undefined || session.document.value.scene?.name !== DEMO) return null;
  const pixel = project(view, said.at);
  // A drag needs the room.
  if (pixel === null || !isInPicture(view, pixel) || session.ownDrag.value !== null) return null;
  const { x, y } = { x: at.x + pixel.x, y: at.y + pixel.y };
  const next = () => {
    if (number + 1 < HINTS.length) hint.value = number + 1;
    else close(page);
  };
  const onEscape = (event: KeyboardEvent) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    document.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
    close(page);
  };
  return (
    <>
      <span class="hint-mark" style={{ left: `${x}px`, top: `${y}px` }} />
      <section
        class="scene-hint"
        aria-label={`Hint ${number + 1} of ${HINTS.length}`}
        style={besideOf({ x, y }, size)}
        onKeyDown={onEscape}
      >
        <p>{said.text}</p>
        <div class="hint-foot">
          <button class="solid" onClick={() => takeTool(page, said.tool)}>
            {said.button}
          </button>
          <button class="solid" onClick={next}>
            {number + 1 < HINTS.length ? "Next" : "Done"}
          </button>
          <QuietButton title="No more hints" press={() => close(page)}>
            <Icon name="close" />
          </QuietButton>
        </div>
      </section>
    </>
  );
}

/** Above or below the place, where there is more room, and within the stage. */
function besideOf({ x, y }: Pixel, size: Size): { [side: string]: string } {
  const width = Math.min(WIDTH, size.width - 2 * FROM_EDGE);
  const left = Math.min(Math.max(x - width / 2, FROM_EDGE), size.width - width - FROM_EDGE);
  const vertical: { [side: string]: string } =
    y < size.height / 2 ? { top: `${y + BESIDE}px` } : { bottom: `${size.height - y + BESIDE}px` };
  return { ...vertical, left: `${left}px`, width: `${width}px` };
}
