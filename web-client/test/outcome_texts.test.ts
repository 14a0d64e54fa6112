import { expect, test } from "vitest";

import { dragLines, shortText } from "../src/core/outcome_texts";
import type { DragOutcome } from "../src/core/protocol";

const OUTCOME: DragOutcome = {
  solver: "flow",
  version: 1,
  iterations: 3,
  fromWorld: null,
  toWorld: null,
  pivotWorld: null,
  status: "landed",
  residualPx: 0,
  shadowedBy: null,
};

test("what keeps a drag short is said, with the rest of the way and the pin", () => {
  const limited = { ...OUTCOME, status: "limited", limit: "fold", residualPx: 2.345 } as const;
  expect(shortText(limited)).toBe("2.3 px short: the tube would fold");
  expect(shortText({ ...limited, residualPx: 24.2 })).toBe("24 px short: the tube would fold");
  expect(shortText({ ...limited, residualPx: null })).toBe("Out of the picture: the tube would fold");
  expect(shortText({ ...limited, limit: "pin" })).toBe("2.3 px short: a pin holds it");
  expect(shortText({ ...limited, limit: "pin" }, "Lit on table")).toBe(
    "2.3 px short: the pin “Lit on table” holds it",
  );
  expect(shortText(OUTCOME)).toBeNull();
});

test("a refusal says why", () => {
  const refused = { ...OUTCOME, status: "refused", residualPx: null } as const;
  expect(shortText({ ...refused, reason: "tooLittleRoom" })).toBe(
    "Refused: too little room behind the caster",
  );
  expect(shortText({ ...refused, reason: "limited", limit: "pin" }, "Look of vase")).toBe(
    "Refused: the pin “Look of vase” holds it",
  );
  expect(shortText({ ...refused, reason: "pinDoesNotHold" }, "Lit")).toBe(
    "Refused: the pin “Lit” does not hold",
  );
});

test("the label of a drag has the residual, what changes, and the alternative", () => {
  const limited = {
    ...OUTCOME,
    status: "limited",
    limit: "pin",
    residualPx: 24.2,
    changedShare: 0.06,
  } as const;
  expect(dragLines(limited, "pastCaster", "Look of vase")).toEqual([
    "24 px short: the pin “Look of vase” holds it",
    "Past the caster, changes 6\u00a0%",
  ]);
  expect(dragLines({ ...OUTCOME, shadowedBy: "lamp" }, "narrower", null)).toEqual([
    "lamp shadows this too",
    "Narrower",
  ]);
  expect(dragLines({ ...OUTCOME, relaxed: ["softPins", "picture"] }, null, null)).toEqual([
    "To get there soft pins do not count, the rest of the picture counts less",
  ]);
  expect(dragLines({ ...OUTCOME, changedShare: 0.2 }, null, null)).toEqual(["changes 20\u00a0%"]);
  expect(dragLines({ ...OUTCOME, pinnedChange: 0.012 }, null, null)).toEqual([
    "pinned objects change by 3 of 255 at most",
  ]);
  expect(dragLines({ ...OUTCOME, pinnedChange: 0.001 }, null, null)).toEqual([
    "pinned objects stay as they are",
  ]);
  expect(dragLines(OUTCOME, null, null)).toEqual([]);
});
