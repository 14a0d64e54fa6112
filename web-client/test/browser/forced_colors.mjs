// Colours of the system: what is selected, pressed, on, set and has the focus is seen without the page's own.

import { join } from "node:path";

import { expect, runBrowserTest, settled } from "./page.mjs";

/** Things that must be visible, and tests of them. */
const STATES = [
  [
    "the selected light",
    async (page) => {
      const row = (name) => mostOf(page, page.locator("[data-light]", { hasText: name }));
      return (await row("key")) !== (await row("rim"));
    },
  ],
  [
    "a button that is pressed",
    async (page) => {
      const button = (name) => mostOf(page, page.getByRole("button", { name, exact: true }));
      return (await button("Show handles")) !== (await button("Probe"));
    },
  ],
  [
    "the field that has the focus",
    async (page) => {
      const field = page.getByRole("textbox", { name: "Intensity", exact: true });
      // Beside its text, which a field selects when it gets the focus.
      const edge = () => mostOf(page, field.locator(".."), 2);
      await page.locator("body").evaluate(() => document.activeElement.blur());
      const before = await edge();
      await field.focus();
      return (await edge()) !== before;
    },
  ],
  [
    "how far a slider is",
    async (page) => (await colorsOf(page, page.locator("input[type=range]").first())).size >= 3,
  ],
];

/** It keeps its own colour, over whatever picture. */
const HANDLE = [
  "a handle",
  async (page) => {
    const colors = await colorsOf(page, page.locator('[data-handle="point-2"] .mark'));
    return colors.has("#f2f2f2");
  },
];

await runBrowserTest(async ({ open, http }) => {
  await http("/edits", { edits: [{ command: { type: "addLight", light: { type: "spot", name: "rim" } } }] });
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    const page = await open("Ada", { width, height });
    await page.getByRole("button", { name: "key", exact: true }).click();
    await page.emulateMedia({ forcedColors: "active" });
    await settled(page);
    for (const [what, isSeen] of [...STATES, HANDLE]) {
      expect(await isSeen(page), `At ${width}x${height} with the system's colours ${what} must be seen.`);
    }
    await page.locator("body").evaluate(() => document.activeElement.blur());
    // axe-core reckons with colours that are not shown now.
    await page.screenshot({ path: join(process.argv[3], `${width}x${height}.png`) });
    // The planted fault: the page as it was without a style for them.
    await page.evaluate(() => {
      for (const sheet of document.styleSheets) {
        for (let k = sheet.cssRules.length - 1; k >= 0; k -= 1) {
          if (sheet.cssRules[k].media?.mediaText.includes("forced-colors")) sheet.deleteRule(k);
        }
      }
    });
    for (const [what, isSeen] of STATES) {
      expect(!(await isSeen(page)), `Without a style for it, ${what} must be missed.`);
    }
    await page.close();
  }
});

/** The colours of what is there on the screen, each with how many pixels have it. */
async function colorsOf(page, locator, widest = Infinity) {
  await locator.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await locator.boundingBox();
  const shot = await page.screenshot({ clip: { x, y, width: Math.min(width, widest), height } });
  const counts = await page.evaluate(async (png) => {
    const image = new Image();
    image.src = `data:image/png;base64,${png}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    const counts = {};
    for (let k = 0; k < data.length; k += 4) {
      const hex = [...data.slice(k, k + 3)].map((byte) => byte.toString(16).padStart(2, "0")).join("");
      counts[`#${hex}`] = (counts[`#${hex}`] ?? 0) + 1;
    }
    return counts;
  }, shot.toString("base64"));
  return new Map(Object.entries(counts));
}

/** The colour that most of it has, or of so many pixels from its left edge. */
async function mostOf(page, locator, widest = Infinity) {
  const colors = [...(await colorsOf(page, locator, widest))];
  return colors.sort(([, a], [, b]) => b - a)[0][0];
}
