// A name in a list, clipped in its middle where it has no room.

import { halvesOf } from "../core/clipping";

interface NameProps {
  name: string;
  /** Tooltip, if it is not the name. */
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
      {/* Screen readers read the name in one piece. */}
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
