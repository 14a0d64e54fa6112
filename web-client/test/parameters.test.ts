import { expect, test } from "vitest";

import type { NumberKind, Owner } from "../src/core/parameters";
import type { Parameter, ParameterTable } from "../src/core/protocol";
import {
  clampTo,
  firstValue,
  hasEffect,
  isSameValue,
  rowsOf,
  sectionsOf,
  setParameter,
  sliderEnds,
  stepTo,
  touchPicture,
  valueIn,
  withValues,
} from "../src/core/parameters";
import { BENDY, CAMERA, SPOT } from "./examples";
import { TABLE, UNHEARD } from "./parameters_fixture";

const WITH_UNHEARD = { parameters: [...TABLE.parameters, UNHEARD] };

function row(owner: Owner, name: string): Parameter {
  const found = rowsOf(TABLE, owner).find((row) => row.name === name);
  if (found === undefined) throw new Error(`no row ${name} of ${owner}`);
  return found;
}

test("what does nothing for a light as it is has no effect", () => {
  const effect = (owner: Owner, name: string, json: object) =>
    hasEffect(TABLE, owner, row(owner, name), json);
  const cases: [owner: Owner, name: string, json: object, shown: boolean][] = [
    ["spot", "colorTemperature", {}, false],
    ["spot", "colorTemperature", { enableColorTemperature: true }, true],
    ["spot", "coneSoftness", {}, true],
    ["spot", "coneSoftness", { profile: "cosine" }, false],
    ["spot", "nearEdge", { cutOn: 2 }, true],
    ["spot", "nearEdge", {}, false],
    // The default of another shape's counts there.
    ["spot", "decayStart", {}, true],
    ["bendy", "decayStart", {}, false],
    ["bendy", "scale", {}, true],
    ["spot", "scale", {}, false],
    ["spot", "name", {}, true],
    ["camera", "name", {}, true],
  ];
  for (const [owner, name, json, shown] of cases) expect(effect(owner, name, json), name).toBe(shown);
  // One that hangs on what the table lacks is shown.
  const lost = { ...UNHEARD, needs: { parameter: "nobody", value: { oneOf: [1] } } };
  expect(hasEffect(TABLE, "spot", lost, {})).toBe(true);
});

const kindOf = (owner: Owner, name: string): NumberKind => row(owner, name).kind as NumberKind;

test("each owner has its own rows, in the table's order and under their headings", () => {
  for (const owner of ["spot", "bendy", "point"] as const) {
    const sections = sectionsOf(TABLE, owner);
    const shown = sections.flatMap(({ rows }) => rows);
    expect(new Set(shown)).toEqual(new Set(TABLE.parameters.filter(({ of }) => of.includes(owner))));
    const places = sections.map(({ rows }) => rows.map((row) => TABLE.parameters.indexOf(row)));
    expect(places).toEqual(places.map((indices) => indices.toSorted((a, b) => a - b)));
    expect(sections.every(({ group, rows }) => rows.every((row) => row.group === group))).toBe(true);
  }
  expect(sectionsOf(TABLE, "bendy").map(({ group }) => group)).toContain("Shape");
  expect(sectionsOf(TABLE, "point").map(({ group }) => group)).toEqual(["Control point"]);
});

test("a group whose rows stand apart is one section", () => {
  const [first, ...others] = TABLE.parameters;
  const late = { parameters: [...others, first].filter((row) => row !== undefined) };
  const groups = (table: ParameterTable) => sectionsOf(table, "spot").map(({ group }) => group);
  expect(groups(late)).toEqual(groups(TABLE));
});

test("a parameter that nobody has heard of has its section, its value and its command", () => {
  const sections = sectionsOf(WITH_UNHEARD, "spot");
  expect(sections.at(-1)).toEqual({ group: "Filter", rows: [UNHEARD] });
  expect(sectionsOf(WITH_UNHEARD, "bendy")).toEqual(sectionsOf(TABLE, "bendy"));
  expect(valueIn(UNHEARD, "spot", SPOT)).toBe(10);
  const changed = withValues(WITH_UNHEARD, "spot", SPOT, { gain: 3 });
  expect(changed).toEqual({ ...SPOT, filter: { gain: 3 } });
  expect(valueIn(UNHEARD, "spot", changed)).toBe(3);
  expect(setParameter(4, UNHEARD, 3)).toEqual({ type: "setLight", light: 4, parameter: { gain: 3 } });
  expect(touchPicture(WITH_UNHEARD, "spot", { gain: 3 })).toBe(true);
});

test("values stand where their paths say", () => {
  expect(valueIn(row("bendy", "translation"), "bendy", BENDY)).toEqual([0, 2, -3]);
  expect(valueIn(row("bendy", "coneAngle"), "bendy", BENDY)).toBe(25);
  expect(valueIn(row("point", "radius"), "point", BENDY, 2)).toBe(0.35);
  expect(valueIn(row("camera", "projection"), "camera", CAMERA)).toEqual(CAMERA.projection);
});

test("what is left out is the default, or none where there may be none", () => {
  expect(valueIn(row("spot", "exposure"), "spot", SPOT)).toBe(0);
  expect(valueIn(row("spot", "range"), "spot", SPOT)).toBeNull();
  const { decay: _, ...plain } = SPOT;
  expect(valueIn(row("spot", "decay"), "spot", plain)).toBe("inverseSquare");
});

test("every row's value comes back as it was set, and nothing else changes", () => {
  const owners = { spot: SPOT, bendy: BENDY, camera: CAMERA, point: BENDY };
  let count = 0;
  for (const [owner, json] of Object.entries(owners) as [Owner, object][]) {
    const point = owner === "point" ? 1 : undefined;
    for (const row of rowsOf(TABLE, owner)) {
      const changed = withValues(TABLE, owner, json, { [row.name]: "planted" }, point);
      expect(valueIn(row, owner, changed, point)).toBe("planted");
      const old = valueIn(row, owner, json, point);
      const back = withValues(TABLE, owner, changed, { [row.name]: old }, point);
      for (const other of rowsOf(TABLE, owner)) {
        expect(valueIn(other, owner, back, point)).toEqual(valueIn(other, owner, json, point));
      }
      count += 1;
    }
  }
  expect(count).toBeGreaterThan(25);
});

test("nothing is set at control points that are not there", () => {
  expect(withValues(TABLE, "point", BENDY, { radius: 1 }, 50)).toEqual(BENDY);
  expect(withValues(TABLE, "point", SPOT, { radius: 1 }, 0)).toEqual(SPOT);
});

test("endless is written by leaving the range out", () => {
  const limited = withValues(TABLE, "spot", SPOT, { range: 5 });
  expect(limited).toEqual({ ...SPOT, range: 5 });
  expect(Object.keys(withValues(TABLE, "spot", limited, { range: null }))).not.toContain("range");
});

test("a row that the table lacks is kept under its own name", () => {
  expect(withValues(TABLE, "spot", SPOT, { later: 1 })).toEqual({ ...SPOT, later: 1 });
  expect(touchPicture(TABLE, "spot", { later: 1 })).toBe(true);
});

test("a picture shows what touches more than nothing", () => {
  expect(touchPicture(TABLE, "spot", { name: "a" })).toBe(false);
  expect(touchPicture(TABLE, "spot", { name: "a", coneAngle: 3 })).toBe(true);
  expect(touchPicture(TABLE, "point", { radius: 3 })).toBe(true);
});

test("a number stops at its limits, and near to those that it may not reach", () => {
  const angle = kindOf("spot", "coneAngle");
  for (const [wanted, set] of [
    [25, 25],
    [0.001, 0.001],
    [0, 0.05],
    [-7, 0.05],
    [90, 89.95],
    [400, 89.95],
  ] as const) {
    expect(clampTo(angle, wanted)).toBeCloseTo(set, 12);
  }
  const softness = kindOf("spot", "coneSoftness");
  expect([-1, 0, 0.5, 1, 2].map((value) => clampTo(softness, value))).toEqual([0, 0, 0.5, 1, 1]);
});

test("steps end where the slider does, and go on beyond it", () => {
  const scale = kindOf("spot", "scale");
  expect(stepTo(scale, 2.99, 3.09)).toBe(3);
  expect(stepTo(scale, 3, 3.1)).toBe(3);
  expect(stepTo(scale, 0.15, -0.05)).toBe(0.1);
  expect(stepTo(scale, 5, 5.1)).toBe(5.1);
  expect(stepTo(scale, 0.05, -0.05)).toBeCloseTo(0.001, 12);
  expect(stepTo(kindOf("point", "radius"), 4, 9)).toBe(9);
});

test("a slider goes as far as its row says, or twice as far as the largest value", () => {
  expect(sliderEnds(kindOf("spot", "exposure"), [40])).toEqual([-10, 10]);
  const radius = kindOf("point", "radius");
  expect(sliderEnds(radius, [0.1, 3, 2])).toEqual([0, 6]);
  expect(sliderEnds(radius, [0, 0])).toEqual([0, 1]);
  expect(sliderEnds({ ...radius, max: 4 }, [3])).toEqual([0, 4]);
  const { min: _, ...free } = radius;
  expect(sliderEnds(free, [-2, 1])).toEqual([-4, 4]);
});

test("a number that was none begins with a round one that may be set", () => {
  expect(firstValue(kindOf("spot", "range"))).toBe(5);
  expect(firstValue({ ...kindOf("spot", "range"), max: 2 })).toBe(2);
});

test("values are the same by what they say", () => {
  expect(isSameValue([0, 0, 1], [-0, 0, 1])).toBe(true);
  expect(isSameValue([0, 0, 1], [0, 0, 1.001])).toBe(false);
  expect(isSameValue(null, 5)).toBe(false);
});
