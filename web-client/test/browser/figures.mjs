// Figures of the paper, by the mouse alone: the shadow is bent and the vase stays lit as it was (Fig 5, row 2), and one vase
// is lit from elsewhere and the other is not (Fig 5, row 1, and Fig 8).

import { expect, reached, runBrowserTest, seqOf, settled, SHARP } from "./page.mjs";

/** Pixels of a picture of 640 by 360 on the blue vase and on the orange one, all of them lit. */
const ON_BLUE = [
  [140, 150],
  [125, 185],
  [160, 195],
];
const ON_ORANGE = [
  [345, 130],
  [338, 160],
  [372, 160],
];
/** Lit places of the blue vase that are to stay lit, from wherever. */
const STAYS_LIT = [
  [112, 185],
  [140, 205],
  [160, 165],
];

/** By how many of 255 the colours differ at most. */
const furthest = (a, b) => Math.max(...a.flatMap((color, k) => color.map((c, i) => Math.abs(c - b[k][i]))));

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 760 }, SHARP);
  await settled(page);
  // The light's own lines would hide what they do to the picture.
  await page.keyboard.press("h");
  await shadow(page, picture, http);
  for (let k = 0; k < 2; k += 1) {
    const seq = await seqOf(page);
    await page.keyboard.press("Control+z");
    await reached(page, seq + 1);
  }
  await relit(page, picture, http);
});

/** Stage positions of pixels of a picture of 640 by 360, all of which is visible. */
async function onStage(page, x, y) {
  const box = await page.locator("canvas").boundingBox();
  const scale = Math.min(box.width / 640, box.height / 360);
  return { x: box.x + box.width / 2 + scale * (x - 320), y: box.y + box.height / 2 + scale * (y - 180) };
}

/** The picture's colours there, of the canvas as it is. */
async function colors(page, places) {
  const box = await page.locator("canvas").boundingBox();
  const shares = await Promise.all(
    places.map(async ([x, y]) => {
      const at = await onStage(page, x, y);
      return [(at.x - box.x) / box.width, (at.y - box.y) / box.height];
    }),
  );
  return page.evaluate((shares) => {
    const canvas = document.querySelector("canvas");
    const context = canvas.getContext("2d");
    const at = ([x, y]) =>
      context.getImageData(Math.floor(x * canvas.width), Math.floor(y * canvas.height), 1, 1).data;
    return shares.map((share) => [...at(share)]);
  }, shares);
}

async function pin(page, kind, places) {
  await page.keyboard.press("6");
  await page.getByRole("button", { name: `Pin: ${kind}` }).click();
  for (const place of places) {
    const seq = await seqOf(page);
    const at = await onStage(page, ...place);
    await page.mouse.click(at.x, at.y);
    await reached(page, seq + 1);
  }
}

/** Bends the light with all its control points, looks at it on the way, and gives the record. */
async function drag(page, tool, [from, to], look, http) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: `${tool} tool` }).click();
  await page
    .getByRole("group", { name: "How the light follows" })
    .getByRole("button", { name: "Control points" })
    .click();
  const [start, end] = [await onStage(page, ...from), await onStage(page, ...to)];
  await page.mouse.move(start.x, start.y);
  await page.locator(".tool-view .way").first().waitFor();
  await look("before");
  await page.mouse.down();
  await page.mouse.move(end.x, end.y, { steps: 6 });
  await page.locator('.dragged-feature:is([data-status="landed"], [data-status="limited"])').waitFor();
  // The lossless picture comes once the pointer rests. It may be here already: it is for the screenshot alone.
  const settles = (is) =>
    page.waitForFunction((is) => document.getElementById("page").dataset.frameSettle === is, is, {
      timeout: 5000,
    });
  await settles("false").catch(() => {});
  await settles("true").catch(() => {});
  await look("after");
  await page.mouse.up();
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  const text = await (await http(`/log?from=${seq + 1}&limit=1`)).text();
  return JSON.parse(text.trim().split("\n").pop());
}

async function shadow(page, picture, http) {
  await pin(page, "Look", ON_BLUE.slice(0, 1));
  await page.getByRole("region", { name: "Pins" }).getByText("Look of blue vase").waitFor();
  await settled(page);
  const [vase, table] = [await colors(page, ON_BLUE), await colors(page, [[430.5, 265.5]])];
  const way = [
    [430.5, 265.5],
    [410.5, 300.5],
  ];
  const record = await drag(page, "Shadow", way, (when) => picture(page, `1-shadow-${when}`), http);
  const { residualPx } = record.action.outcome;
  expect(residualPx <= 2, `The shadow must land within 2 pixels: ${JSON.stringify(record.action.outcome)}`);
  const kept = furthest(vase, await colors(page, ON_BLUE));
  expect(kept <= 8, `Pinned, the vase must look as it did; it differs by ${kept} of 255.`);
  const left = furthest(table, await colors(page, [[430.5, 265.5]]));
  expect(left > 30, `The planted fault: where the shadow was it must be light now, and differs by ${left}.`);
}

async function relit(page, picture, http) {
  await pin(page, "Look", ON_ORANGE.slice(0, 1));
  await page.getByRole("button", { name: "Whole object" }).click();
  await pin(page, "Lit", STAYS_LIT);
  await settled(page);
  const [orange, blue] = [await colors(page, ON_ORANGE), await colors(page, [[125, 185]])];
  const way = [
    [133, 170],
    [160, 165],
  ];
  const record = await drag(page, "Highlight", way, (when) => picture(page, `2-relit-${when}`), http);
  expect(record.changes.length > 0, "The light must move.");
  const kept = furthest(orange, await colors(page, ON_ORANGE));
  expect(kept <= 8, `Pinned, the orange vase must look as it did; it differs by ${kept} of 255.`);
  const lit = furthest(blue, await colors(page, [[125, 185]]));
  expect(lit > 5, `The blue vase must be lit otherwise; it differs by ${lit}.`);
}
