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
  /** Whether it can do nothing now. It is grey then and keeps the focus, which a `disabled` one would lose. */
  disabled?: boolean;
  press(button: HTMLElement): void;
  children: ComponentChildren;
}

export function QuietButton(props: QuietButtonProps) {
  const { title, label = title, pressed, disabled = false, press, children } = props;
  return (
    <button
      class={`quiet ${props.class ?? ""}`}
      title={title}
      aria-label={label}
      aria-pressed={pressed}
      aria-disabled={disabled}
      onClick={(event) => disabled || press(event.currentTarget)}
    >
      {children}
    </button>
  );
}
