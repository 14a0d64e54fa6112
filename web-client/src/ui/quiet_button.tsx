// A button without a frame.

import type { ComponentChildren } from "preact";

interface QuietButtonProps {
  /** Further classes. */
  class?: string;
  title: string;
  /** What it is called where that is not the title. */
  label?: string;
  /** Whether it is on, of one that stays so. */
  pressed?: boolean;
  /** Whether what it opens is open, of one that opens something; and that one's id. */
  expanded?: boolean;
  controls?: string;
  /** Whether it can do nothing now. It is grey then and keeps the focus, which a `disabled` one would lose. */
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
