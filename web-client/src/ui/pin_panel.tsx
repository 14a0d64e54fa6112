// The pins of the selected light, in words.

import type { LightId } from "../core/ids";
import { pinsOf, pinText } from "../core/tools";
import { Icon } from "./icons";
import { Name } from "./name";
import { usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { FoldingSection } from "./sections";

export function PinPanel({ id, disabled }: { id: LightId; disabled: boolean }) {
  const { session, toolbox } = usePage();
  const pins = pinsOf(session.document.value, id);
  if (pins.length === 0) return null;
  return (
    <FoldingSection group="Pins" heading="Pins" openAtFirst>
      <ul class="pins">
        {pins.map(({ id: number, pin }) => (
          <li key={number} data-current={toolbox.selectedPin.value === number}>
            <Name name={pinText(pin)} />
            <QuietButton
              title={pin.hard ? "It holds whatever is asked" : "It holds as far as what is asked lets it"}
              label={`Hard: ${pinText(pin)}`}
              pressed={pin.hard}
              disabled={disabled}
              press={() => session.edit({ type: "setPin", pin: number, hard: !pin.hard })}
            >
              {pin.hard ? "Hard" : "Soft"}
            </QuietButton>
            <QuietButton
              title="Remove this pin"
              label={`Remove: ${pinText(pin)}`}
              disabled={disabled}
              press={() => session.edit({ type: "removePin", pin: number })}
            >
              <Icon name="trash" />
            </QuietButton>
          </li>
        ))}
      </ul>
    </FoldingSection>
  );
}
