// The document and what changes and commands do to it. Functions change nothing: they give a new document.

import type { LightId } from "./ids";
import { passesPins, withPins } from "./ignored_pins";
import type { ParameterTable } from "./protocol";
import { touchPicture, withValues } from "./parameters";
import type { Change, Command, Document, DocumentCamera, DocumentLight, Light } from "./protocol";

export const EMPTY: Document = { scene: null, lights: [], cameras: [] };

/** The document after `change`. Old values are not looked at: the server has done that. */
export function applyChange(table: ParameterTable, document: Document, change: Change): Document {
  switch (change.type) {
    case "scene":
      return { ...document, scene: change.new };
    case "light":
      return { ...document, lights: withId(document.lights, change.light, change.new) };
    case "lightParameter":
      return onLight(document, change.light, (light) => withValues(table, light.type, light, change.new));
    case "point":
      return onLight(document, change.light, (light) =>
        withValues(table, "point", light, change.new, change.point),
      );
    case "controlPoints": {
      const { layout, ...points } = change.new;
      return onEntry(document, change.light, (entry) => ({
        ...entry,
        layout,
        light: { ...entry.light, ...points } as Light,
      }));
    }
    case "camera": {
      const content = change.new === null ? null : { camera: change.new };
      return { ...document, cameras: withId(document.cameras, change.camera, content) };
    }
    case "cameraParameter":
      return onCamera(table, document, change.camera, change.new);
    case "pin": {
      const content = change.new === null ? null : { pin: change.new };
      const { pins: before = [], ...rest } = document;
      const pins = withId(before, change.pin, content);
      // Without pins the server's documents have no list of them.
      return pins.length === 0 ? rest : { ...rest, pins };
    }
  }
}

/**
 * The document as `command` will leave it if the server agrees, for commands that a hand at a control sends.
 * A command that makes new ids, fills in values or needs a solve waits for the server: the document is returned unchanged.
 */
export function predict(table: ParameterTable, document: Document, command: Command): Document {
  switch (command.type) {
    case "placeLight": {
      // A hard pin may hold it: the server says how far it goes.
      if (!passesPins(command) && isHeldByPin(document, command.light)) return document;
      const { type: _, light: id, ...placement } = withPins(command);
      return onLight(document, id, (light) => withValues(table, light.type, light, placement));
    }
    case "setLight":
      return onLight(document, command.light, (light) =>
        withValues(table, light.type, light, command.parameter),
      );
    case "setPoint":
      return onLight(document, command.light, (light) =>
        withValues(table, "point", light, command.parameter, command.point),
      );
    case "setCamera":
      return onCamera(table, document, command.camera, command.parameter);
    default:
      return document;
  }
}

/** True if a hard pin holds the light. */
const isHeldByPin = ({ pins = [] }: Document, light: LightId): boolean =>
  pins.some(({ pin }) => pin.hard && pin.light === light);

/** True if the control point that `command` drags has not reached its target, because the tube would fold. */
export function isAtLimit(document: Document, command: Command | null): boolean {
  if (command?.type !== "dragPoint") return false;
  const light = lightOf(document, command.light);
  const at = light?.type === "bendy" ? light.points[command.point] : undefined;
  // Without a limit the point is at its target to the last bit.
  return at?.some((x, k) => x !== command.position[k]) ?? false;
}

/** True if a picture can show the change of `document` (SPEC, FRAME-7). */
export function changesPicture(table: ParameterTable, document: Document, change: Change): boolean {
  switch (change.type) {
    case "camera":
    case "cameraParameter":
    case "pin":
      return false;
    case "lightParameter": {
      const light = lightOf(document, change.light);
      return light === undefined || touchPicture(table, light.type, change.new);
    }
    case "point":
      return touchPicture(table, "point", change.new);
    case "scene":
      return change.old?.asset !== change.new?.asset;
    case "light":
    case "controlPoints":
      return true;
  }
}

/** True if nothing of a name can be read. */
export const isBlank = (name: string): boolean => name.trim() === "";

/** `stem` with the first number from `first` that none of `names` has, such as "spot 2". */
export function freeName(stem: string, names: readonly string[], first = 1): string {
  let number = first;
  while (names.includes(`${stem} ${number}`)) number += 1;
  return `${stem} ${number}`;
}

/** Name of a copy of `light`: the same with another number. */
export function copyName({ name, type }: Light, names: readonly string[]): string {
  const stem = name.trim().replace(/ \d+$/, "");
  return freeName(stem === "" ? type : stem, names, 2);
}

/** Label of the light in lists. */
export const lightLabel = ({ id, light }: { id: LightId; light: Light }): string =>
  isBlank(light.name) ? `${light.type} ${id}` : light.name;

/** The light called `id`, if it is still there. */
export const lightOf = (document: Document, id: LightId | null): Light | undefined =>
  document.lights.find((entry) => entry.id === id)?.light;

/** Name of a light in sentences: its name in quotes, or its number. */
export function lightName(document: Document, id: LightId): string {
  const name = lightOf(document, id)?.name ?? "";
  return isBlank(name) ? `Light ${id}` : `“${name}”`;
}

function onLight(document: Document, id: LightId, change: (light: Light) => Light): Document {
  return onEntry(document, id, (entry) => ({ ...entry, light: change(entry.light) }));
}

function onEntry(document: Document, id: LightId, change: (entry: DocumentLight) => DocumentLight): Document {
  return {
    ...document,
    lights: document.lights.map((entry) => (entry.id === id ? change(entry) : entry)),
  };
}

function onCamera(table: ParameterTable, document: Document, id: number, values: object): Document {
  const change = (entry: DocumentCamera): DocumentCamera => ({
    ...entry,
    camera: withValues(table, "camera", entry.camera, values),
  });
  return {
    ...document,
    cameras: document.cameras.map((entry) => (entry.id === id ? change(entry) : entry)),
  };
}

/** `list` with `content` at `id`, or without it where `content` is null; in the order of ids. */
function withId<T extends { id: number }>(list: T[], id: number, content: Omit<T, "id"> | null): T[] {
  const others = list.filter((item) => item.id !== id);
  if (content === null) return others;
  return [...others, { id, ...content } as T].sort((a, b) => a.id - b.id);
}
