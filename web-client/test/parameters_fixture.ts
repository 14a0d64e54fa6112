// The table as the server gives it, and a row that no server has.

import type { Parameter, ParameterTable } from "../src/core/protocol";
import { vectors } from "./vectors";

export const TABLE: ParameterTable = { parameters: vectors<Parameter[]>("parameters.json") };

/** Parameter that the page does not know. */
export const UNHEARD: Parameter = {
  name: "gain",
  of: ["spot"],
  address: { spot: "/lights/ID/gain" },
  kind: {
    type: "number",
    unit: "dB",
    exclusiveMin: 0,
    slider: [0.01, 100],
    step: 0.1,
    scale: "logarithmic",
  },
  default: { spot: 10 },
  path: "filter/gain",
  touches: "radiance",
  animates: true,
  group: "Filter",
  label: "Gain",
  doc: "A row for tests.",
};
