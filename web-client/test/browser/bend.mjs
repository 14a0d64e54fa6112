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
});

/** The last control point lies no farther from the source than the scene is large. */
function insideOfTheScene({ points, transform }) {
  const reach = Math.hypot(...points.at(-1)) * transform.scale;
  expect(
    reach > 0.1 && reach < 20,
    `Its control points must reach to what it shines on, not ${reach} units.`,
  );
}
