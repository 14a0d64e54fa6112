import { expect, test } from "vitest";

import {
  type AlternativeAnswer,
  changesText,
  type FeatureCommand,
  isSameWay,
  requestOf,
  stepped,
} from "../src/core/alternatives";
import type { DragAlternative, DragStatus } from "../src/core/protocol";
import { BENDY, CAMERA, DOCUMENT, SPOT } from "./examples";

const COMMAND: FeatureCommand = {
  type: "dragFeature",
  light: 4,
  kind: "shadow",
  alternative: "best",
  radii: "keep",
  camera: CAMERA,
  size: [64, 36],
  from: [1, 2],
  to: [3, 4],
  sourceOutside: true,
};

const answer = (alternative: DragAlternative, status: DragStatus): AlternativeAnswer => ({
  alternative,
  status,
  residualPx: 0,
  light: BENDY,
});

test("a request has what a drag file knows, and its light's place among all", () => {
  const lights = [
    { id: 1, layout: 1, light: BENDY },
    { id: 4, layout: 1, light: SPOT },
  ];
  const request = requestOf(COMMAND, { ...DOCUMENT, lights });
  expect(request).toEqual({
    light: 1,
    kind: "shadow",
    radii: "keep",
    camera: CAMERA,
    size: [64, 36],
    from: [1, 2],
    to: [3, 4],
    sourceOutside: true,
    alternatives: true,
  });
  expect(requestOf(COMMAND, DOCUMENT), "the light is gone").toBeNull();
});

test("steps lead to what can be had, around the end", () => {
  const all = [
    answer("controlPoints", "landed"),
    answer("wholeLight", "limited"),
    answer("linkedCopy", "landed"),
    answer("pastCaster", "refused"),
  ];
  expect(stepped(all, "controlPoints", 1)).toBe("wholeLight");
  expect(stepped(all, "controlPoints", 2)).toBe("linkedCopy");
  expect(stepped(all, "linkedCopy", 1), "not to what is refused").toBe("controlPoints");
  expect(stepped(all, "controlPoints", -1)).toBe("linkedCopy");
  expect(stepped(all, null, 1), "the best").toBe("controlPoints");
  expect(stepped(all, null, -1)).toBe("linkedCopy");
  expect(stepped(all, "pastCaster", 1), "what is refused is no place to go on from").toBe("controlPoints");
  expect(stepped(all, "controlPoints", 3), "nothing but itself").toBeNull();
  expect(stepped([answer("pastCaster", "refused")], null, 1)).toBeNull();
});

test("the share that changes is said in full per cents, and a little is not nothing", () => {
  expect(changesText(0.0612)).toBe("changes 6\u00a0%");
  expect(changesText(0)).toBe("changes 0\u00a0%");
  expect(changesText(0.001)).toBe("changes < 1\u00a0%");
  expect(changesText(undefined)).toBeNull();
});

test("another place is another way, another alternative is not", () => {
  expect(isSameWay(COMMAND, { ...COMMAND, alternative: "narrower" })).toBe(true);
  expect(isSameWay(COMMAND, { ...COMMAND, to: [3, 5] })).toBe(false);
  expect(isSameWay(COMMAND, { ...COMMAND, light: 5 })).toBe(false);
});
