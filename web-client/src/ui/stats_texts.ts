// Passes in words.

import { lightLabel } from "../core/document";
import type { Cause, Document, Pass, PassRun } from "../core/protocol";

const PASSES: { readonly [pass in Pass]: string } = {
  gbuffer: "G-buffer",
  shadowMap: "Shadow map",
  lighting: "Lighting",
  layer: "Layer",
  sum: "Sum of layers",
  display: "Display",
};

const CAUSES: { readonly [cause in Cause]: string } = {
  first: "there was none yet",
  scene: "the scene changed",
  camera: "the camera or the size changed",
  gbuffer: "what is seen changed",
  light: "the light changed",
  resolution: "it was not fine enough",
  evicted: "it had to make room",
  notKept: "drawn every time",
};

/** Name of a pass, its cause and its count: `Shadow map of key: the light changed, 1`. */
export function passText(document: Document, { pass, light, cause, runs }: PassRun): string {
  const entry = document.lights.find(({ id }) => id === light);
  const label = entry === undefined ? `light ${light}` : lightLabel(entry);
  const what = light === null ? PASSES[pass] : `${PASSES[pass]} of ${label}`;
  const why = cause === "light" && light === null ? "a light changed" : CAUSES[cause];
  return `${what}: ${why}, ${runs}`;
}

/** Microseconds, for people. */
export const ms = (us: number): string => `${(us / 1000).toFixed(us < 10_000 ? 1 : 0)} ms`;
