// A scene on its way, over a corner of the picture: how much of it has gone, and what came of it.

import type { ComponentChildren } from "preact";

import { Name } from "./name";
import { type Opening, useOpening } from "./opening";
import { sentence } from "./sentence";

const MEGABYTE = 1e6;
const megabytes = (bytes: number) => (bytes / MEGABYTE).toFixed(bytes < 10 * MEGABYTE ? 1 : 0);

interface OpeningPanelProps {
  /** The id of the button that opens scenes, which gets the focus once the panel is closed. */
  opener: string;
}

export function OpeningPanel({ opener }: OpeningPanelProps) {
  const { state } = useOpening();
  const { value } = state;
  if (value === null) return null;
  const close = (end: () => void) => {
    end();
    document.getElementById(opener)?.focus();
  };
  if (value.kind === "failed") {
    const { name, why, again } = value;
    return (
      <Panel name={name}>
        <p role="alert">{sentence(why)}</p>
        <div class="opening-foot">
          {again !== null && (
            <button class="solid" onClick={again}>
              Try again
            </button>
          )}
          <button class="solid" onClick={() => close(() => (state.value = null))}>
            Close
          </button>
        </div>
      </Panel>
    );
  }
  return (
    <Panel name={value.name}>
      <p role="status">{SAID[value.kind]}</p>
      <Progress opening={value} />
      <div class="opening-foot">
        {value.kind === "sending" && (
          <span>
            {megabytes(value.sent)} of {megabytes(value.size)} MB
          </span>
        )}
        {value.kind !== "loading" && (
          <button class="solid" onClick={() => close(value.stop)}>
            Cancel
          </button>
        )}
      </div>
    </Panel>
  );
}

const SAID = {
  packing: "Its files are put together",
  sending: "It is sent to the server",
  reading: "The server reads it",
  loading: "It is loaded",
} as const;

/** Without a share, while nobody knows how long it takes. */
function Progress({ opening }: { opening: Opening }) {
  const label = "How far the scene is";
  if (opening.kind !== "sending") return <progress aria-label={label} />;
  return <progress aria-label={label} value={opening.sent} max={Math.max(1, opening.size)} />;
}

function Panel({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <section class="opening" aria-label="A scene on its way">
      <h2>
        <Name name={name} />
      </h2>
      {children}
    </section>
  );
}
