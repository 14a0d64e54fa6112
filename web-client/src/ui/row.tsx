// A row of a panel: what it is, and the control for it.

import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";

import { Icon } from "./icons";
import { QuietButton } from "./quiet_button";

/** Puts a value back to what it is by default. */
export interface Reset {
  /** The default as people read it. */
  to: string;
  run(): void;
}

export interface RowProps {
  label: string;
  /** A sentence on what it is. */
  doc?: string | undefined;
  /** Reset button, if the value is not the default. */
  reset?: Reset | undefined;
  disabled: boolean;
}

export function Row({ label, doc, reset, disabled, children }: RowProps & { children: ComponentChildren }) {
  const control = useRef<HTMLDivElement>(null);
  const run = () => {
    if (reset === undefined || disabled) return;
    // The button goes, and who hears the page is told the new value.
    control.current?.querySelector<HTMLElement>("input, select")?.focus();
    reset.run();
  };
  const hint = reset === undefined ? "" : `Double-click for ${reset.to}.`;
  return (
    <div class="row">
      <div class="row-head">
        {/* biome-ignore lint/a11y/noStaticElementInteractions: what the double click does, the button beside it does too */}
        <span
          class="row-label"
          title={[doc, hint].filter(Boolean).join(" ")}
          data-resets={reset !== undefined}
          onDblClick={run}
        >
          {label}
        </span>
        {reset !== undefined && (
          <QuietButton
            class="reset"
            title={`Reset to ${reset.to}`}
            label={`Reset ${label} to ${reset.to}`}
            disabled={disabled}
            press={run}
          >
            <Icon name="reset" />
          </QuietButton>
        )}
      </div>
      <div class="row-control" ref={control}>
        {children}
      </div>
    </div>
  );
}
