// Line icons, 16 by 16.

const PATHS = {
  undo: "M5.5 3 2.5 6l3 3M2.5 6h7a4 4 0 0 1 0 8H6",
  redo: "m10.5 3 3 3-3 3M13.5 6h-7a4 4 0 0 0 0 8H10",
  reset: "M4 5.5A5 5 0 1 1 3 8.8M3.5 2.5v3.5H7",
  note: "M3.5 2.5h6l3 3v8h-9zM9.5 2.5v3h3M6 8.5h4M6 11h4",
  plus: "M8 3v10M3 8h10",
  minus: "M3 8h10",
  close: "m4 4 8 8M12 4l-8 8",
  trash: "M3 4.5h10M6.5 4.5V3h3v1.5M4.5 4.5l.5 9h6l.5-9M6.7 7v4M9.3 7v4",
  bendy: "M2.5 4C8 3.5 12 7 12 13M2.5 4c6-3 11.5 1 11.5 7",
  spot: "M3 3l3 10M3 3l10 3.5M6 13c3 .2 7-3 7-6.5",
  omni: "M8 5.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5zM8 1.5v2M8 12.5v2M1.5 8h2M12.5 8h2M3.5 3.5l1.4 1.4M11.1 11.1l1.4 1.4M3.5 12.5l1.4-1.4M11.1 4.9l1.4-1.4",
  directional: "M3 2.5v9l-1.5-2M3 11.5l1.5-2M8 2.5v9l-1.5-2M8 11.5l1.5-2M13 2.5v9l-1.5-2M13 11.5l1.5-2",
  camera: "M2.5 5h7v6h-7zM9.5 7.5l4-2v5l-4-2",
  view: "M1.5 8S4 4 8 4s6.5 4 6.5 4-2.5 4-6.5 4-6.5-4-6.5-4zM8 6.3a1.7 1.7 0 1 0 0 3.4 1.7 1.7 0 0 0 0-3.4z",
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10M6 8a2 2 0 1 0 4 0 2 2 0 0 0-4 0z",
  handles: "M4 12 12 4M2.5 10.5h3v3h-3zM10.5 2.5h3v3h-3z",
  gate: "M1.5 3.5h13v9h-13zM1.5 6h13M1.5 10h13",
  probe: "M8 1.5v4M8 10.5v4M1.5 8h4M10.5 8h4M8 7.2a.8.8 0 1 0 0 1.6.8.8 0 0 0 0-1.6z",
  snap: "M2 13.5h12M8 2.5v6M5.5 6.5 8 9l2.5-2.5M8 10.7a.8.8 0 1 0 0 1.6.8.8 0 0 0 0-1.6z",
  aim: "M8 3.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9zM8 1.5v4M8 10.5v4M1.5 8h4M10.5 8h4",
  copy: "M5.5 5.5h8v8h-8zM5.5 10.5h-3v-8h8v3",
  fold: "m4.5 6 3.5 4 3.5-4",
  lock: "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 5 0v2.5",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" aria-hidden="true">
      <path d={PATHS[name]} />
    </svg>
  );
}
