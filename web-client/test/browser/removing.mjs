// Removal by trash: at once for one thing, and after a confirmation where pins go too.

import { expect, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const pin = (at) => ({ command: { type: "addPin", pin: { light: 1, kind: "lit", at, hard: true } } });
  const spot = { command: { type: "addLight", light: { type: "spot", name: "rim" } } };
  await http("/edits", { edits: [spot, pin([0, 0, 0]), pin([0.1, 0, 0]), pin([0.2, 0, 0])] });
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    const page = await open("Ada", { width, height });
    const canvas = JSON.stringify(await page.locator("canvas").boundingBox());
    await lightsWithPinsAreAskedFor(page, picture, `${width}x${height}`);
    await theSourceByKeys(page);
    await oneThingGoesAtOnce(page);
    const now = JSON.stringify(await page.locator("canvas").boundingBox());
    expect(now === canvas, `The picture must stay at ${canvas}; it is at ${now}.`);
    await page.close();
  }
});

function question(page) {
  return page.getByRole("dialog");
}
function remove(page, name) {
  return page.locator("[data-light]").getByRole("button", { name: `Remove ${name}` });
}
function pinsOf(page) {
  return page.locator("[data-pin]").count();
}

async function lightsWithPinsAreAskedFor(page, picture, name) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "key", exact: true }).click();
  await remove(page, "key").click();
  await question(page).getByText("“key” and 3 pins go. Undo brings them back.").waitFor();
  await picture(page, `1-asked-${name}`);
  await question(page).getByRole("button", { name: "Keep" }).click();
  await question(page).waitFor({ state: "hidden" });
  await remove(page, "key").focus();
  await page.keyboard.press("Enter");
  await question(page).waitFor();
  await page.keyboard.press("Escape");
  await question(page).waitFor({ state: "hidden" });
  expect((await seqOf(page)) === seq, "What is kept must be there without a record.");
  const focused = await remove(page, "key").evaluate((button) => button === document.activeElement);
  expect(focused, "The focus must go back to where it was.");

  await page.keyboard.press("Enter");
  await question(page).waitFor();
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
  await page.getByText("key", { exact: true }).first().waitFor({ state: "hidden" });
  const beside = await page.evaluate(() => document.activeElement.getAttribute("aria-label"));
  expect(beside === "Remove rim", `The focus must go to the row beside; it is at ${beside}.`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
  await page.getByRole("button", { name: "key", exact: true }).click();
  await settled(page);
  expect((await pinsOf(page)) === 3, "Undo must bring the pins back.");
}

async function theSourceByKeys(page) {
  const seq = await seqOf(page);
  await page.locator('[data-handle="source"]').focus();
  await page.keyboard.press("Delete");
  await question(page).getByRole("button", { name: "Remove" }).click();
  await reached(page, seq + 1);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}

async function oneThingGoesAtOnce(page) {
  const seq = await seqOf(page);
  await remove(page, "rim").click();
  await reached(page, seq + 1);
  expect(!(await question(page).isVisible()), "Where one thing goes nobody is asked.");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}
