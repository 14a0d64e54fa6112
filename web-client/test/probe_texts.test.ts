import { expect, test } from "vitest";

import type { ProbedLight } from "../src/core/protocol";
import { placeText, shareText, stateText } from "../src/ui/probe_texts";

const LIT: ProbedLight = {
  light: 1,
  name: "key",
  state: "lit",
  share: 1,
  path: [],
  disabledBy: null,
  irradiance: [1, 1, 1],
  place: { t: 2.125, v: 0, w: 0, pathLength: 5.348, radius: 1, direction: [0, 1, 0] },
  radiance: [1, 1, 1],
  shadowedBy: null,
};

test("a little is not none, and not quite all is not all", () => {
  const said = [0, 0.004, 0.014, 0.5, 0.994, 1].map((share) => shareText({ ...LIT, share }));
  expect(said).toEqual(["–", "< 1 %", "1 %", "50 %", "> 99 %", "100 %"]);
});

test("where along the light it is, as far as that can be said", () => {
  expect(placeText(LIT)).toBe("5.35 along it, t 2.13");
  const place: ProbedLight["place"] = {
    t: 0,
    v: 0,
    w: 0,
    pathLength: null,
    radius: null,
    direction: [0, 1, 0],
  };
  expect(placeText({ ...LIT, place })).toBe("t 0");
  expect(placeText({ ...LIT, place: null })).toBe("");
});

test("why a light does not arrive", () => {
  const shadowedBy = { node: "room/shelf/vase", position: [0, 0, 0] as [number, number, number] };
  expect(stateText({ ...LIT, state: "shadowed", shadowedBy }, "bendy")).toBe("shadowed by vase");
  expect(stateText({ ...LIT, state: "outside" }, "bendy")).toBe("outside its tube");
  expect(stateText({ ...LIT, state: "outside" }, undefined)).toBe("outside its light");
  expect(stateText({ ...LIT, state: "disabled", disabledBy: "muted" }, "spot")).toBe("left out of this view");
  expect(stateText({ ...LIT, state: "facingAway" }, "spot")).toBe("faces away from it");
});
