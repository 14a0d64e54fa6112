// A button without a frame.

import type { ComponentChildren } from "preact";

interface QuietButtonProps {
  /** Further classes. */
  class?: string;
  title: string;
  /** Accessible name, if it is not the title. */
  label?: string;
  /** State of a toggle. */
  pressed?: boolean;
  /** State of the element that it opens, and that element's id. */
  expanded?: boolean;
  controls?: string;
  /** True if it can do nothing now. It is grey then and keeps the focus, which a `disabled` one would lose. */
  disabled?: boolean;
  press(button: HTMLElement): void;
  children: ComponentChildren;
}

export function QuietButton(props: QuietButtonProps) {
  const { title, label = title, pressed, expanded, controls, disabled = false, press, children } = props;
  return (
    <button
      class={`quiet ${props.class ?? ""}`}
      title={title}
      aria-label={label}
      aria-pressed={pressed}
      aria-expanded={expanded}
      aria-controls={expanded === true ? controls : undefined}
      aria-disabled={disabled}
      onClick={(event) => disabled || press(event.currentTarget)}
    >
      {children}
    </button>
  );
}
