// What the "add" buttons add: lights that shine down on what the page looks at.

import { freeName } from "../core/document";
import { pivotOf } from "../core/navigation";
import type { Transform } from "../core/outline";
import type { Bendy, Light, Spot } from "../core/protocol";
import { add } from "../core/vector";
import type { Page } from "./page";

/** Height above the pivot, as a share of the pivot's distance. */
const HEIGHT = 0.35;
const CONE_ANGLE = 25;
/** Local -Z, along which lights shine, turned to straight down. */
const DOWNWARD: Transform["rotation"] = [-Math.SQRT1_2, 0, 0, Math.SQRT1_2];
/** Parameters of the curve at which linear control points make a linear tube: a cone, before it is bent. */
const ABSCISSAE = [0, 0.5, 1.5, 2];

function above(page: Page): { transform: Transform; height: number } | null {
  const orbit = page.session.viewer.own.value;
  if (orbit === null) return null;
  const height = HEIGHT * orbit.distance;
  const translation = add(pivotOf(orbit), [0, height, 0]);
  return { transform: { translation, rotation: DOWNWARD, scale: 1 }, height };
}

/** A light as it is asked for: the server fills in the defaults of what is left out. */
type NewLight<L extends Light> = Partial<L> & { type: L["type"] };

function newBendy(name: string, transform: Transform, height: number): NewLight<Bendy> {
  const along = ABSCISSAE.map((t) => (t / 2) * height * 1.3);
  const source = 0.05 * height;
  return {
    type: "bendy",
    name,
    transform,
    points: along.map((z) => [0, 0, -z]),
    radii: along.map((z) => source + z * Math.tan((CONE_ANGLE * Math.PI) / 180)),
    intensities: along.map(() => 2),
    coneAngle: CONE_ANGLE,
  };
}

function newSpot(name: string, transform: Transform, height: number): NewLight<Spot> {
  // Candela, so that about 2 arrives at the pivot.
  const intensity = Number((2 * height * height).toPrecision(3));
  return { type: "spot", name, transform, intensity, decay: "inverseSquare" };
}

/** Adds a light and selects it once it is there. */
export function addLight(page: Page, type: Light["type"]): void {
  const origin = above(page);
  if (origin === null) return;
  const names = page.session.document.value.lights.map(({ light }) => light.name);
  const name = freeName(type, names);
  const make = type === "bendy" ? newBendy : newSpot;
  const light = make(name, origin.transform, origin.height) as Light;
  page.session.edit({ type: "addLight", light }, ({ changes }) => {
    const added = changes.find((change) => change.type === "light");
    if (added === undefined) return;
    page.selectedLight.value = added.light;
    page.selectedPoint.value = null;
  });
}
