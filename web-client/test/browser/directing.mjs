// Lights are directed in the picture: asked why a pixel is lit, pulled along one way, laid on surfaces, aimed, and looked
// through.

import { expect, reached, runBrowserTest, seqOf } from "./page.mjs";

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await theProbe(page, picture);
});

/** A place on the stage by shares of the picture. */
async function onPicture(page, x, y) {
  const box = await page.locator("canvas").boundingBox();
  return { x: box.x + x * box.width, y: box.y + y * box.height };
}

async function isInside(page, selector) {
  const [inner, stage] = [
    await page.locator(selector).boundingBox(),
    await page.locator(".stage").boundingBox(),
  ];
  return (
    inner.x >= stage.x &&
    inner.y >= stage.y &&
    inner.x + inner.width <= stage.x + stage.width &&
    inner.y + inner.height <= stage.y + stage.height
  );
}

/** What the panel says of the pixel under the pointer, once it says what is wanted. */
async function probed(page, at, wanted) {
  await page.mouse.move(at.x, at.y);
  const panel = page.locator(".probe-panel");
  await panel.getByText(wanted).waitFor();
  expect(await isInside(page, ".probe-panel"), "The panel must stay inside the stage.");
  return panel.innerText();
}

async function theProbe(page, picture) {
  const panel = page.locator(".probe-panel");
  const seq = await seqOf(page);
  const [lit, shadowed] = [await onPicture(page, 0.62, 0.72), await onPicture(page, 0.45, 0.67)];
  await page.mouse.move(shadowed.x, shadowed.y);
  expect((await panel.count()) === 0, "Nothing is to be asked while the key is up.");
  await page.keyboard.down("i");
  const kept = await probed(page, shadowed, "shadowed by blue vase");
  expect(kept.startsWith("table\nkey\n–\n"), `A shadow gets nothing of the light: ${kept}`);
  expect((await page.locator(".obstacle").textContent()) === "blue vase", "The obstacle must be marked.");
  expect((await page.locator(".kept-off").count()) === 1, "Behind it the way must be drawn otherwise.");
  await picture(page, "1-shadowed");
  const said = await probed(page, lit, "lit,");
  expect(/key\n100 %\nlit, \d+\.\d+ along it, t \d\.\d+$/.test(said), `It must say all of it: ${said}`);
  expect((await page.locator(".obstacle").count()) === 0, "Nothing is in the way of a lit pixel.");
  await picture(page, "2-lit");
  await probed(page, await onPicture(page, 0.02, 0.98), "outside its tube");
  await picture(page, "3-in-the-corner");

  // Who has no pointer asks about the middle, and who cannot hold a key presses the button.
  await page.mouse.move(5, 5);
  await panel.getByText("lit,").waitFor();
  await page.keyboard.up("i");
  await panel.waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Probe", exact: true }).click();
  await probed(page, shadowed, "shadowed by blue vase");
  await page.getByRole("button", { name: "Mute key" }).click();
  await probed(page, shadowed, "switched off");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
  await probed(page, shadowed, "shadowed by blue vase");
  await page.getByRole("button", { name: "Probe", exact: true }).click();
  await panel.waitFor({ state: "detached" });
}
