import { expect, test } from "vitest";

import { featureText, nothingTaken, takenLight } from "../src/core/tools";
import { found, probed } from "./probes";

test("the light that makes what is under the pointer is taken", () => {
  const all = found(
    probed(1, "lit", 2),
    probed(2, "shadowed", 5),
    probed(3, "shadowed", 7),
    probed(4, "outside", 0),
  );
  expect(takenLight("shadow", all, null)?.light).toBe(3);
  expect(takenLight("shadow", all, 2)?.light, "the selected one counts enough").toBe(2);
  expect(takenLight("shadow", all, 1)?.light, "the selected one throws no shadow here").toBe(3);
  expect(takenLight("hotspot", all, 3)?.light).toBe(1);
  const faint = found(probed(1, "lit", 1), probed(2, "lit", 9));
  expect(takenLight("highlight", faint, 1)?.light, "nobody means what can hardly be seen").toBe(2);
  expect(takenLight("diffuse", found(probed(2, "shadowed", 5)), 2)).toBeNull();
  expect(nothingTaken("shadow", faint)).toContain("No shadow");
});

test("a feature is named by what throws it", () => {
  const shadowed = {
    shadowedBy: { node: "room/blue vase", position: [0, 0, 0] as [number, number, number] },
  };
  expect(featureText("shadow", shadowed)).toBe("shadow of blue vase");
  expect(featureText("hotspot", shadowed)).toBe("hotspot");
});
