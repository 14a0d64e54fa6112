// Commands that hard pins hold, and the same with pins passed over.

import type { Command } from "./protocol";

/** Commands that hard pins hold, but for drags of features, which pins are for. */
const HELD = ["placeLight", "setLight", "setPoint", "dragPoint"] as const;
type Held = Extract<Command, { type: (typeof HELD)[number] }>;

/** True if hard pins hold the command. */
export const isHeld = (command: Command): command is Held =>
  (HELD as readonly string[]).includes(command.type);

/** The command with pins passed over. */
export const passingPins = (command: Command): Command =>
  isHeld(command) ? Object.assign({}, command, { ignorePins: true }) : command;

/** True if a command passes over pins. */
export const passesPins = (command: Command): boolean =>
  "ignorePins" in command && command.ignorePins === true;

/** The command without that. */
export function withPins<C extends Command>(command: C): C {
  const { ignorePins: _, ...rest } = { ignorePins: false, ...command };
  return rest as unknown as C;
}
