// Hints on the demo: on a first visit, beside what they speak of, and never again once they are closed.

import { expect, runBrowserTest, settled } from "./page.mjs";

const FIRST = { hints: true };
/** Surfaces that each hint points at: the demo may change. */
const PLACES = [
  {
    isThere: ({ seen, lights }) => seen.node === "table" && lights[0].state === "shadowed",
  },
  { isThere: ({ seen }) => seen.node === "blue vase" },
];

await runBrowserTest(async ({ open, picture, http, send }) => {
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    const size = { width, height };
    const page = await open(`Ada ${width}`, size, FIRST);
    await hintsAreBesideWhatTheySpeakOf(page, picture, http, size);
    await page.reload();
    await settled(page);
    expect((await hint(page).count()) === 0, "What has been seen to its end must not come again.");
    await page.close();
  }
  const page = await open("Bob", { width: 1280, height: 800 }, FIRST);
  await theyAreClosedByKeys(page);
  await page.close();

  const scene = { asset: { version: "2.0" }, nodes: [{ name: "n" }] };
  const { asset } = await send("/assets", scene);
  await http("/edits", { edits: [{ command: { type: "loadScene", scene: asset } }] });
  const other = await open("Cleo", { width: 1280, height: 800 }, FIRST);
  expect((await hint(other).count()) === 0, "Hints on the demo must not be in another scene.");
});

function hint(page) {
  return page.getByRole("region", { name: /^Hint/ });
}

/** Surface at the hint's mark, as the server reports it. */
async function seenAtMark(page, http) {
  const asked = await page.evaluate(() => {
    const [mark, canvas] = [".hint-mark", "canvas"].map((name) =>
      document.querySelector(name).getBoundingClientRect(),
    );
    const pixel = [mark.x + mark.width / 2 - canvas.x, mark.y + mark.height / 2 - canvas.y];
    const camera = { own: JSON.parse(document.getElementById("page").dataset.camera) };
    return { camera, pixel, size: [Math.round(canvas.width), Math.round(canvas.height)] };
  });
  return (await http("/probe", asked)).json();
}

async function hintsAreBesideWhatTheySpeakOf(page, picture, http, { width, height }) {
  const rectangle = async () => JSON.stringify(await page.locator("canvas").boundingBox());
  const before = await rectangle();
  const stage = await page.locator(".stage").boundingBox();
  for (const [k, { isThere }] of PLACES.entries()) {
    await page.getByRole("region", { name: `Hint ${k + 1} of ${PLACES.length}` }).waitFor();
    const found = await seenAtMark(page, http);
    expect(
      isThere(found),
      `Hint ${k + 1} must be beside what it speaks of; there is ${JSON.stringify(found.seen)}`,
    );
    // The planted fault: what the other one speaks of is not there.
    expect(!PLACES[1 - k].isThere(found), "A hint that is elsewhere must be noticed.");
    const box = await hint(page).boundingBox();
    const isInside =
      box.x >= stage.x &&
      box.x + box.width <= stage.x + stage.width &&
      box.y >= stage.y &&
      box.y + box.height <= stage.y + stage.height;
    expect(isInside, `Hint ${k + 1} must be in the picture at ${width}x${height}: ${JSON.stringify(box)}`);
    await picture(page, `${k + 1}-${width}x${height}`);
    await hint(page).getByRole("button").first().click();
    const tool = await page.locator(".stage").getAttribute("data-tool");
    expect(tool === ["feature", "pin"][k], `The hint's button must take up its tool; it is ${tool}.`);
    await hint(page)
      .getByRole("button", { name: /Next|Done/ })
      .click();
  }
  await hint(page).waitFor({ state: "hidden" });
  expect((await rectangle()) === before, "Hints must leave the picture where it is.");
  await page.keyboard.press("Escape");
}

async function theyAreClosedByKeys(page) {
  await hint(page).waitFor();
  await page.locator(".stage").focus();
  for (let presses = 0; presses < 40; presses += 1) {
    await page.keyboard.press("Tab");
    if (await page.evaluate(() => document.activeElement.closest(".scene-hint") !== null)) break;
  }
  await page.keyboard.press("Escape");
  await hint(page).waitFor({ state: "hidden" });
  const focused = await page.evaluate(() => document.activeElement.className);
  expect(focused === "stage", `The focus must go to the picture; it is at ${focused}.`);
  await page.reload();
  await settled(page);
  expect((await hint(page).count()) === 0, "What has been closed must not come again.");
}
