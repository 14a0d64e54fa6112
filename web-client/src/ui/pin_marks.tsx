// Marks of the selected light's pins over the picture.

import { project, type View } from "../core/camera";
import { pinsOf } from "../core/pins";
import type { Pin } from "../core/protocol";
import { isFree } from "./light_actions";
import { type Page, usePage } from "./page";
import { pinName, placeOf } from "./pin_facts";

/** The pins of the selected light. Delete removes the one that has the focus. */
export function PinMarks({ view }: { view: View }) {
  const page = usePage();
  const pins = pinsOf(page.session.document.value, page.selectedLight.value);
  return (
    <>
      {pins.map(({ id, pin }) => (
        <PinMark key={id} view={view} id={id} pin={pin} page={page} />
      ))}
    </>
  );
}

/** State of a pin as marks and the list show it. */
export type PinState = "holds" | "broken" | "atRest";

/** A pin holds a drag back, is broken, or is at rest. */
export function pinState({ session, toolbox }: Page, id: number): PinState {
  const outcome = session.ownDrag.value?.outcome ?? null;
  if (outcome?.pin === id) return outcome.reason === "pinDoesNotHold" ? "broken" : "holds";
  return toolbox.pinFacts.value.broken.has(id) ? "broken" : "atRest";
}

/** A drop, and for a broken pin a crossed diamond. */
const DROP = "M0 0-4.5-7a5.4 5.4 0 1 1 9 0z";
const DIAMOND = "M0 1-8-7 0-15 8-7z";
const CROSS = "M-2.8-9.8 2.8-4.2M2.8-9.8-2.8-4.2";

function PinMark({ view, id, pin, page }: { view: View; id: number; pin: Pin; page: Page }) {
  const { session, toolbox } = page;
  const place = placeOf(page, id, pin);
  const at = place === null ? null : project(view, place);
  if (at === null) return null;
  const state = pinState(page, id);
  const said = `${pin.hard ? "Hard" : "Soft"} pin: ${pinName(page, id, pin)}${state === "broken" ? ", broken" : ""}`;
  return (
    <g
      class="pin"
      data-pin={id}
      data-kind={pin.kind}
      data-hard={pin.hard}
      data-state={state}
      data-current={toolbox.selectedPin.value === id}
      data-flash={toolbox.flash.value?.pin === id}
      transform={`translate(${at.x.toFixed(2)} ${at.y.toFixed(2)})`}
      role="button"
      tabIndex={0}
      aria-label={said}
      onFocus={() => (toolbox.selectedPin.value = id)}
      onPointerDown={(event) => {
        event.stopPropagation();
        toolbox.selectedPin.value = id;
      }}
      onKeyDown={(event) => {
        if ((event.key !== "Delete" && event.key !== "Backspace") || !isFree(page, pin.light)) return;
        event.preventDefault();
        session.edit({ type: "removePin", pin: id });
      }}
    >
      <title>{said}</title>
      <circle class="reach" r={12} />
      {toolbox.flash.value?.pin === id && <circle class="flash" r={16} cy={-6} />}
      <path class="mark" d={state === "broken" ? DIAMOND : DROP} />
      {state === "broken" && (
        <>
          <path class="cross" d={CROSS} />
          <text class="light-name" x={11} y={-4}>
            broken
          </text>
        </>
      )}
    </g>
  );
}
