// List of keys and of actions of the pointer, on demand.

import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";

type Keys = readonly [where: string, rows: readonly [keys: string, what: string][]][];

export const FRONT_KEYS: Keys = [
  [
    "Session",
    [
      ["Tab, arrows, Home, End", "Go to another one"],
      ["Enter", "Open it"],
      ["F2", "Rename it"],
      ["D", "Duplicate it"],
      ["Delete", "Archive it; an archived one, delete it"],
    ],
  ],
  [
    "Everywhere",
    [
      ["N", "New session"],
      ["?", "This list"],
    ],
  ],
];

export const SESSION_KEYS: Keys = [
  [
    "View",
    [
      ["Drag, arrows", "Orbit, about what is pressed"],
      ["Shift with either, middle button", "Pan"],
      ["Wheel, + and −", "Zoom"],
      ["One finger", "Orbit"],
      ["Two fingers", "Pan, zoom"],
      ["A", "Frame the scene"],
      ["F", "Frame the selected light"],
      ["H", "Show or hide the handles"],
      ["G", "Show or hide the film gate"],
      ["Hold I", "Say why the pixel under the pointer is lit or not"],
    ],
  ],
  [
    "Handle",
    [
      ["Tab", "Go to the next one"],
      ["Drag, arrows", "Move, widen or turn it"],
      ["Page Up, Page Down", "Move it away from the eye, or back"],
      ["Drag an arrow", "Move it along one axis, or along your line of sight"],
      ["Ctrl while dragging", "Reverse Snap: lay it on the surface under the pointer, or not"],
      ["Shift while dragging", "Move it a tenth as far"],
      ["Hold P while dragging, or with arrows", "Pass over pins"],
      ["Shift with keys", "Ten steps at once"],
      ["Escape", "Take back what is under way"],
      ["Delete", "Remove the point, at the source the light"],
    ],
  ],
  [
    "Tool",
    [
      ["1 to 6", "Select, shadow, hotspot, highlight, diffuse, pin"],
      ["Drag, or Enter, arrows, Enter", "Take a feature and put it elsewhere"],
      ["Tab, Shift+Tab while dragging", "Go through the other answers"],
      ["B", "Next way to follow: best, whole light, control points"],
      ["Escape", "Take back what is under way, then the tool"],
      ["Delete", "Remove the pin that has the focus"],
    ],
  ],
  [
    "Light",
    [
      ["M", "Switch the selected one off or on"],
      ["S", "See it alone, or all again"],
      ["D", "Duplicate it"],
      ["T", "Aim it at what is clicked next"],
      ["L", "Look through it, and back"],
    ],
  ],
  [
    "Number",
    [
      ["Up, Down", "A step more or less"],
      ["Shift with either", "Ten steps at once"],
      ["1+1, *2, 50%, 6500K", "Sums, factors and shares of it, units"],
      ["Enter, Escape", "Take it, leave it"],
    ],
  ],
  [
    "Everywhere",
    [
      ["Ctrl+Z", "Undo"],
      ["Ctrl+Shift+Z, Ctrl+Y", "Redo"],
      ["?", "This list"],
    ],
  ],
];

/** True if a click is beside the dialog: the darkened rest of the page is a part of it. */
function isOutside({ currentTarget, clientX, clientY }: MouseEvent): boolean {
  const { left, right, top, bottom } = (currentTarget as Element).getBoundingClientRect();
  return clientX < left || clientX > right || clientY < top || clientY > bottom;
}

/** The list, while the page shows it. */
export function KeyList({ shown, keys }: { shown: Signal<boolean>; keys: Keys }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const isShown = shown.value;
  useEffect(() => {
    if (isShown) dialog.current?.showModal();
    else dialog.current?.close();
  }, [isShown]);
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: Escape closes it too
    <dialog
      class="key-list"
      ref={dialog}
      aria-labelledby="key-list"
      // By Escape. The event that it is closed comes late: by then it may be about to open again.
      onCancel={() => (shown.value = false)}
      onClick={(event) => {
        if (isOutside(event)) shown.value = false;
      }}
    >
      {isShown && (
        <>
          <header>
            <h2 id="key-list">Keys</h2>
            <button class="quiet" onClick={() => (shown.value = false)}>
              Close
            </button>
          </header>
          {keys.map(([where, rows]) => (
            <section key={where}>
              <h3>{where}</h3>
              <dl>
                {rows.map(([keys, what]) => (
                  <div key={keys}>
                    <dt>{keys}</dt>
                    <dd>{what}</dd>
                  </div>
                ))}
              </dl>
            </section>
          ))}
        </>
      )}
    </dialog>
  );
}
