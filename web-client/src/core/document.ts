// The document and what changes and commands do to it. Functions change nothing: they give a new document.

import type { LightId } from "./ids";
import type {
  Camera,
  CameraParameter,
  Change,
  Command,
  Document,
  DocumentCamera,
  DocumentLight,
  Light,
  LightParameter,
  PointParameter,
} from "./protocol";

export const EMPTY: Document = { scene: null, lights: [], cameras: [] };

/** The document after `change`. Old values are not looked at: the server has done that. */
export function applyChange(document: Document, change: Change): Document {
  switch (change.type) {
    case "scene":
      return { ...document, scene: change.new };
    case "light":
      return { ...document, lights: withId(document.lights, change.light, change.new) };
    case "lightParameter":
      return onLight(document, change.light, (placed) => ({
        ...placed,
        light: withLightParameter(placed.light, change.new),
      }));
    case "point":
      return onLight(document, change.light, (placed) => ({
        ...placed,
        light: withPoint(placed.light, change.point, change.new),
      }));
    case "controlPoints": {
      const { layout, ...points } = change.new;
      return onLight(document, change.light, (placed) => ({
        ...placed,
        layout,
        light: { ...placed.light, ...points } as Light,
      }));
    }
    case "camera": {
      const placed = change.new === null ? null : { camera: change.new };
      return { ...document, cameras: withId(document.cameras, change.camera, placed) };
    }
    case "cameraParameter":
      return onCamera(document, change.camera, change.new);
  }
}

/**
 * The document as `command` will leave it if the server agrees, for commands that a hand at a control sends.
 * What makes new ids or fills in values waits for the server: there the document comes back as it is.
 */
export function predict(document: Document, command: Command): Document {
  switch (command.type) {
    case "placeLight": {
      const { type: _, light, ...placement } = command;
      return onLight(document, light, (placed) => ({
        ...placed,
        light: { ...placed.light, transform: { ...placed.light.transform, ...placement } },
      }));
    }
    case "setLight":
      return onLight(document, command.light, (placed) => ({
        ...placed,
        light: withLightParameter(placed.light, command.parameter),
      }));
    case "setPoint":
      return onLight(document, command.light, (placed) => ({
        ...placed,
        light: withPoint(placed.light, command.point, command.parameter),
      }));
    case "setCamera":
      return onCamera(document, command.camera, command.parameter);
    default:
      return document;
  }
}

/** Whether a picture can show the change (SPEC, FRAME-7). */
export function changesPicture(change: Change): boolean {
  switch (change.type) {
    case "camera":
    case "cameraParameter":
      return false;
    case "lightParameter":
      return !("name" in change.new);
    case "scene":
      return change.old?.asset !== change.new?.asset;
    default:
      return true;
  }
}

/** Whether a name is none: nothing of it can be read. */
export const isBlank = (name: string): boolean => name.trim() === "";

/** `stem` with the first number from 1 that none of `names` has, such as "spot 2". */
export function freeName(stem: string, names: readonly string[]): string {
  let number = 1;
  while (names.includes(`${stem} ${number}`)) number += 1;
  return `${stem} ${number}`;
}

/** What stands for the light in lists. */
export const lightLabel = ({ id, light }: { id: LightId; light: Light }): string =>
  isBlank(light.name) ? `${light.type} ${id}` : light.name;

/** The light called `id`, if it is still there. */
export const lightOf = (document: Document, id: LightId | null): Light | undefined =>
  document.lights.find((placed) => placed.id === id)?.light;

/** What sentences call a light: its name in quotes, or its number. */
export function lightName(document: Document, id: LightId): string {
  const name = lightOf(document, id)?.name ?? "";
  return isBlank(name) ? `Light ${id}` : `“${name}”`;
}

function onLight(
  document: Document,
  id: LightId,
  change: (placed: DocumentLight) => DocumentLight,
): Document {
  return {
    ...document,
    lights: document.lights.map((placed) => (placed.id === id ? change(placed) : placed)),
  };
}

function onCamera(document: Document, id: number, parameter: CameraParameter): Document {
  const change = (placed: DocumentCamera): DocumentCamera => ({
    ...placed,
    camera: { ...placed.camera, ...parameter } as Camera,
  });
  return {
    ...document,
    cameras: document.cameras.map((placed) => (placed.id === id ? change(placed) : placed)),
  };
}

/** `list` with `content` at `id`, or without it where `content` is null; in the order of ids. */
function withId<T extends { id: number }>(list: T[], id: number, content: Omit<T, "id"> | null): T[] {
  const others = list.filter((item) => item.id !== id);
  if (content === null) return others;
  return [...others, { id, ...content } as T].sort((a, b) => a.id - b.id);
}

function withLightParameter(light: Light, parameter: LightParameter): Light {
  if (light.type === "spot" && "range" in parameter && parameter.range === null) {
    // Endless is written by leaving the range out.
    const { range: _, ...endless } = light;
    return endless;
  }
  const ofTransform = "translation" in parameter || "rotation" in parameter || "scale" in parameter;
  const changed = ofTransform
    ? { ...light, transform: { ...light.transform, ...parameter } }
    : { ...light, ...parameter };
  return changed as Light;
}

function withPoint(light: Light, index: number, parameter: PointParameter): Light {
  if (light.type !== "bendy" || index >= light.points.length) return light;
  if ("position" in parameter) return { ...light, points: light.points.with(index, parameter.position) };
  if ("radius" in parameter) return { ...light, radii: light.radii.with(index, parameter.radius) };
  if ("color" in parameter) return { ...light, colors: light.colors.with(index, parameter.color) };
  return { ...light, intensities: light.intensities.with(index, parameter.intensity) };
}
