// A name in a list, clipped in its middle where it has no room.

import { halvesOf } from "../core/clipping";

interface NameProps {
  name: string;
  /** What it says to a pointer that rests on it, if not the name. */
  title?: string;
}

export function Name({ name, title = name }: NameProps) {
  const { start, end } = halvesOf(name);
  if (end === "") {
    return (
      <span class="clipped" title={title}>
        {name}
      </span>
    );
  }
  return (
    <span class="name" title={title}>
      {/* Who hears the page hears the name in one piece. */}
      <span class="unseen">{name}</span>
      <span class="name-start" aria-hidden="true">
        {start}
      </span>
      <span class="name-end" aria-hidden="true">
        {end}
      </span>
    </span>
  );
}
