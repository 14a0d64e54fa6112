// A light that is bent in place: its handles lie where it shines, no pixel changes, and it is one step.

import { expect, pixels, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  const light = async () => (await (await http("")).json()).document.lights[0].light;
  if ((await light()).type === "bendy") {
    const seq = await seqOf(page);
    await page.getByRole("button", { name: "Straighten this light" }).click();
    await reached(page, seq + 1);
  }
  await settled(page);
  await picture(page, "1-straight");
  const [seq, straight, spot] = [await seqOf(page), await pixels(page), await light()];
  expect(spot.type === "spot", "There must be a spotlight to bend.");
  await page.getByRole("button", { name: "Bend this light" }).click();
  await reached(page, seq + 1);
  await settled(page);
  await picture(page, "2-bent");
  const bent = await light();
  expect(bent.type === "bendy" && bent.points.length === 5, "It must have control points.");
  expect(bent.intensity === spot.intensity && bent.name === spot.name, "It must stay the light that it was.");
  insideOfTheScene(bent);
  expect((await page.locator("[data-handle]").count()) >= 5, "Its control points must have handles.");
  await page.getByRole("button", { name: /^Undo/ }).first().click();
  await reached(page, seq + 2);
  await settled(page);
  expect((await pixels(page)) === straight, "Undone as one step it must be the light before.");
  await omniLight(page, { picture, http });
});

/** A light without a cone gets one towards what is in the middle of the view, where a new light is aimed. */
async function omniLight(page, { picture, http }) {
  const seq = await seqOf(page);
  const latest = async () => (await (await http("")).json()).document.lights.at(-1).light;
  await page.getByRole("button", { name: "Add an omni light" }).click();
  await reached(page, seq + 1);
  const omni = await latest();
  await page.getByRole("button", { name: "Bend this light" }).click();
  await reached(page, seq + 2);
  await settled(page);
  await picture(page, "3-a-bent-omni-light");
  const bent = await latest();
  expect(omni.type === "omni" && bent.type === "bendy", "The omni light must be bent.");
  const [was, is] = [omni, bent].map(({ transform: { rotation } }) => shinesAlong(rotation));
  const turned = Math.hypot(...was.map((x, k) => x - is[k]));
  expect(turned < 1e-3, `It must shine at the middle of the view, not ${turned} beside it.`);
  insideOfTheScene(bent);
}

/** Where the light's own -Z points. */
function shinesAlong([x, y, z, w]) {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), 2 * (x * x + y * y) - 1];
}

/** The last control point lies no farther from the source than the scene is large. */
function insideOfTheScene({ points, transform }) {
  const reach = Math.hypot(...points.at(-1)) * transform.scale;
  expect(
    reach > 0.1 && reach < 20,
    `Its control points must reach to what it shines on, not ${reach} units.`,
  );
}
