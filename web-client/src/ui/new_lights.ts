// Lights of the "add" buttons, aimed at the surface in the middle of the view.

import { freeName } from "../core/document";
import { pivotOf } from "../core/navigation";
import { rowsOf } from "../core/parameters";
import { besideTheEye, brightnessFor, cameraOf, type Decay, type Placement } from "../core/placing";
import type { Bendy, Light } from "../core/protocol";
import { length, sub, type Vec3 } from "../core/vector";
import { addAndSelect } from "./light_actions";
import type { Page } from "./page";

const CONE_ANGLE = 25;
/** Parameters of the curve at which linear control points make a linear tube: a cone, before it is bent. */
const ABSCISSAE = [0, 0.5, 1.5, 2];
/** A tube goes on behind what it is aimed at, by this share of the way there. */
const BEYOND = 1.6;
/** The source of a tube is so wide, as a share of the way. */
const SOURCE = 0.05;
/** Maximum distance of the visible point from the aim, as a share of the distance to it, for the aim to count as visible. */
const SAME_PLACE = 0.05;

/** A light as it is asked for: the server fills in the defaults of what is left out. */
type NewLight = Partial<Light> & { type: Light["type"] };

/** Adds a light to what the page looks at. */
export async function addLight(page: Page, type: Light["type"]): Promise<void> {
  const placement = await placeInView(page);
  if (placement === null) return;
  const names = page.session.document.value.lights.map(({ light }) => light.name);
  addAndSelect(page, newLight(page, type, freeName(type, names), placement) as Light);
}

/** Aimed at what is in the middle of the view, or, where nothing is, at what the view turns about. */
async function placeInView({ session, pick }: Page): Promise<Placement | null> {
  const orbit = session.viewer.own.value;
  if (orbit === null) return null;
  const { camera } = orbit;
  const aim = (await pick(camera)) ?? pivotOf(orbit);
  const places = besideTheEye(camera, aim);
  for (const place of places) {
    const met = await pick(cameraOf(place));
    if (met === null || length(sub(met, aim)) < SAME_PLACE * place.distance) return place;
  }
  return places[0] ?? null;
}

function newLight(page: Page, type: Light["type"], name: string, placement: Placement): NewLight {
  const { translation, rotation, distance } = placement;
  const decay = rowsOf(page.session.table, type).find((row) => row.name === "decay")?.default[type];
  const brightness = brightnessFor((decay ?? "none") as Decay, distance);
  const light = { name, transform: { translation, rotation, scale: 1 } };
  if (type !== "bendy") return { ...light, type, intensity: brightness };
  return { ...light, ...straightTube(distance, brightness) };
}

/** A cone along local -Z, to be bent. */
function straightTube(distance: number, brightness: number): Partial<Bendy> & { type: "bendy" } {
  const along = ABSCISSAE.map((t) => (t / 2) * distance * BEYOND);
  const spread = Math.tan((CONE_ANGLE * Math.PI) / 180);
  return {
    type: "bendy",
    points: along.map((z): Vec3 => [0, 0, -z]),
    radii: along.map((z) => SOURCE * distance + z * spread),
    intensity: brightness,
    coneAngle: CONE_ANGLE,
  };
}
