// All pins in words: those of the selected light first.

import { lightLabel } from "../core/document";
import type { LightId } from "../core/ids";
import type { Pin } from "../core/protocol";
import { Icon } from "./icons";
import { isFree } from "./light_actions";
import { Name } from "./name";
import { usePage } from "./page";
import { pinName, showPin } from "./pin_facts";
import { pinState } from "./pin_marks";
import { QuietButton } from "./quiet_button";
import { FoldingSection } from "./sections";

export function PinPanel({ id }: { id: LightId }) {
  const { session, passing } = usePage();
  const { pins: all = [], lights } = session.document.value;
  const pins = [...all.filter(({ pin }) => pin.light === id), ...all.filter(({ pin }) => pin.light !== id)];
  if (pins.length === 0) return null;
  const labelOf = (light: LightId) => {
    const entry = lights.find((other) => other.id === light);
    return entry === undefined ? "a light that is gone" : lightLabel(entry);
  };
  return (
    <FoldingSection group="Pins" heading="Pins" openAtFirst>
      <ul class="pins">
        {pins.map(({ id: number, pin }) => (
          <PinRow key={number} id={number} pin={pin} light={labelOf(pin.light)} />
        ))}
      </ul>
      <p class="pins-foot">
        <QuietButton
          title="Drag handles and set values as if there were no pins (hold P)"
          label="Pass over pins"
          pressed={passing.on.value || passing.held.value}
          press={() => (passing.on.value = !passing.on.value)}
        >
          Pass over pins
        </QuietButton>
      </p>
    </FoldingSection>
  );
}

/** A pin by its kind, its object and its light; a press finds it in the picture. */
function PinRow({ id, pin, light }: { id: number; pin: Pin; light: string }) {
  const page = usePage();
  const { session, toolbox } = page;
  const name = pinName(page, id, pin);
  const state = pinState(page, id);
  const disabled = !isFree(page, pin.light);
  return (
    <li data-current={toolbox.selectedPin.value === id} data-state={state}>
      <button
        class="quiet pin-name"
        title={`Show this pin: ${name}, of ${light}`}
        onClick={() => showPin(page, id, pin)}
      >
        <Name name={name} />
        <span class="pin-light clipped">
          {light}
          {state === "broken" && <strong class="pin-broken">, broken</strong>}
          {state === "holds" && <strong>, holds</strong>}
        </span>
      </button>
      <QuietButton
        title={pin.hard ? "It holds whatever is asked" : "It holds as far as what is asked lets it"}
        label={`Hard: ${name}`}
        pressed={pin.hard}
        disabled={disabled}
        press={() => session.edit({ type: "setPin", pin: id, hard: !pin.hard })}
      >
        {pin.hard ? "Hard" : "Soft"}
      </QuietButton>
      <QuietButton
        title="Remove this pin"
        label={`Remove: ${name}`}
        disabled={disabled}
        press={() => session.edit({ type: "removePin", pin: id })}
      >
        <Icon name="trash" />
      </QuietButton>
    </li>
  );
}
