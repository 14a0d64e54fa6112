// Shadows, hotspots and highlights are taken in the picture and put elsewhere, and what is pinned stays.

import { expect, fingers, reached, runBrowserTest, seqOf, settled, state } from "./page.mjs";

/** In the shadow of the blue vase's neck. */
const SHADOW = [430.5, 265.5];

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await settled(page);
  await aShadow(page, picture, http);
  await somePoints(page, picture, http);
  await pins(page, picture, http);
  await aHighlight(page, picture, http);
  await keys(page, picture);
  await byFinger(open, http);
});

/** Stage position of a pixel of a picture of 640 by 360, all of which is visible. */
async function onStage(page, x, y) {
  const box = await page.locator("canvas").boundingBox();
  const scale = Math.min(box.width / 640, box.height / 360);
  return { x: box.x + box.width / 2 + scale * (x - 320), y: box.y + box.height / 2 + scale * (y - 180) };
}

async function latest(http, seq) {
  const text = await (await http(`/log?from=${seq}&limit=1`)).text();
  return JSON.parse(text.trim().split("\n").pop());
}

/** Drags with the mouse, looks once it has landed, and lets go. */
async function drag(page, from, to, look = async () => {}) {
  const [start, end] = [await onStage(page, ...from), await onStage(page, ...to)];
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  await page.mouse.move((start.x + end.x) / 2, (start.y + end.y) / 2, { steps: 4 });
  await page.mouse.move(end.x, end.y, { steps: 4 });
  await page.locator('.dragged-feature:is([data-status="landed"], [data-status="limited"])').waitFor();
  await look();
  await page.mouse.up();
}

/** The way and what stands in it are shown first; then the shadow goes, live, as one record. */
async function aShadow(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("2");
  const at = await onStage(page, ...SHADOW);
  await page.mouse.move(at.x, at.y);
  await page.locator(".tool-view .obstacle", { hasText: "blue vase" }).waitFor();
  await picture(page, "1-before-anything-moves");
  await drag(page, SHADOW, [410.5, 300.5], async () => {
    await page.locator('.dragged-feature[data-status="landed"]').waitFor();
    await settledDrag(page);
    await picture(page, "2-on-its-way");
  });
  await reached(page, seq + 1);
  const { action, changes } = await latest(http, seq + 1);
  expect(
    action.type === "gesture" && action.outcome.status === "landed",
    `It must land: ${JSON.stringify(action)}`,
  );
  expect(action.outcome.residualPx <= 0.5 && action.command.kind === "shadow", "Under the pointer.");
  expect(
    changes.every(({ type }) => type === "lightParameter"),
    "As a whole a light is placed.",
  );
  await settled(page, seq + 1);
  await picture(page, "3-landed");

  // Without a shadow nothing is grabbed, and the reason is shown.
  const lit = await onStage(page, 330, 330);
  await page.mouse.move(lit.x, lit.y);
  await page.mouse.down();
  await page.getByText("No shadow falls here").waitFor();
  await page.mouse.up();
  expect((await seqOf(page)) === seq + 1, "Nothing may come of it.");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}

/** The picture as it is while something is dragged. */
async function settledDrag(page) {
  const { liveRevision } = await state(page);
  await page.waitForFunction(
    (before) => Number(document.getElementById("page").dataset.liveRevision) >= before,
    Number(liveRevision),
  );
  await page.waitForTimeout(600);
}

/** Bending, only those control points move that take part. */
async function somePoints(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("b");
  await page.getByRole("button", { name: "Control point 1 takes part" }).click();
  await page.getByLabel("Radii while dragging").selectOption("keep");
  await drag(page, SHADOW, [420.5, 290.5], () => picture(page, "4-bent"));
  await reached(page, seq + 1);
  const { action, changes } = await latest(http, seq + 1);
  expect(action.command.points.join() === "2,3,4", `Three take part: ${action.command.points}`);
  expect(
    changes.length > 0 &&
      changes.every(({ type, point, new: value }) => type === "point" && point > 1 && "position" in value),
    `Nothing else may change: ${JSON.stringify(changes)}`,
  );
  // Escape takes back what is under way.
  const [start, end] = [await onStage(page, 420.5, 290.5), await onStage(page, 400, 300)];
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  await page.mouse.move(end.x, end.y, { steps: 5 });
  await page.locator(".dragged-feature").waitFor();
  await page.keyboard.press("Escape");
  await page.locator(".dragged-feature").waitFor({ state: "detached" });
  await page.mouse.up();
  expect((await seqOf(page)) === seq + 1, "Escape must leave nothing behind.");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}

/** A pin keeps what it marks, and is named where it is in the way. */
async function pins(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("6");
  await page.getByRole("button", { name: "Whole object" }).click();
  await page.getByRole("button", { name: "Pin: In shadow" }).click();
  const lit = await onStage(page, 330, 330);
  await page.mouse.click(lit.x, lit.y);
  await page.getByText("No shadow of the light falls here").waitFor();
  await page.getByRole("button", { name: "Pin: Direction" }).click();
  const shadow = await onStage(page, ...SHADOW);
  await page.mouse.click(shadow.x, shadow.y);
  await reached(page, seq + 1);
  const mark = page.locator(".tool-view .pin");
  await mark.waitFor();
  await page.getByRole("region", { name: "Pins" }).getByText("Direction").waitFor();
  await picture(page, "5-pinned");

  // One control point alone cannot do both, and two can.
  await page.keyboard.press("2");
  for (const point of [2, 4])
    await page.getByRole("button", { name: `Control point ${point} takes part` }).click();
  const end = await onStage(page, 430.5, 285.5);
  await page.mouse.move(shadow.x, shadow.y);
  await page.mouse.down();
  await page.mouse.move(end.x, end.y, { steps: 4 });
  await page.locator(".refused-drag", { hasText: "its pin “Direction” holds the feature back" }).waitFor();
  await picture(page, "6-a-pin-holds");
  await page.mouse.up();
  await page.locator(".dragged-feature").waitFor({ state: "detached" });
  expect((await seqOf(page)) === seq + 1, "A drag that a pin holds back must leave nothing behind.");
  await page.getByRole("button", { name: "Control point 4 takes part" }).click();
  await drag(page, SHADOW, [430.5, 285.5]);
  await reached(page, seq + 2);
  const { action } = await latest(http, seq + 2);
  expect(action.outcome.status === "landed", `It must land: ${JSON.stringify(action.outcome)}`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 3);

  await page.getByRole("button", { name: /^Hard: / }).click();
  await reached(page, seq + 4);
  await page.locator('.pin[data-hard="false"]').waitFor();
  await mark.focus();
  await page.keyboard.press("Delete");
  await reached(page, seq + 5);
  await mark.waitFor({ state: "detached" });
  for (const point of [1, 2])
    await page.getByRole("button", { name: `Control point ${point} takes part` }).click();
}

/** A highlight goes on from where it is: it does not jump under the pointer. */
async function aHighlight(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("4");
  await page.keyboard.press("b");
  const { document } = await (await http("")).json();
  const { camera } = document.cameras[0];
  const size = [640, 360];
  // Wherever on the vases one is found near a pixel.
  let centre = null;
  for (let y = 120; y < 300 && centre === null; y += 10) {
    for (let x = 150; x < 500 && centre === null; x += 10) {
      const found = await (
        await http("/probe", { camera: { own: camera }, size, pixel: [x, y], highlights: true })
      ).json();
      const [light] = found.lights;
      const near = light?.highlight;
      if (
        near !== undefined &&
        Math.hypot(near[0] - x, near[1] - y) < 4 &&
        light.state === "lit" &&
        /vase|bowl/.test(found.seen.node)
      )
        centre = near;
    }
  }
  expect(centre !== null, "The demo must have a highlight.");
  const before = document.lights[0].light.transform;
  await drag(page, [centre[0] + 2, centre[1] + 1], [centre[0] + 3, centre[1] + 1], () =>
    picture(page, "7-highlight"),
  );
  await reached(page, seq + 1);
  const { action } = await latest(http, seq + 1);
  const [width, height] = action.command.size;
  const scale = Math.min(width / 640, height / 360);
  const [x, y] = action.command.from;
  const began = [(x - width / 2) / scale + 320, (y - height / 2) / scale + 180];
  expect(
    Math.hypot(began[0] - centre[0], began[1] - centre[1]) < 1,
    `It must begin at the highlight's centre ${centre}, not at ${began}.`,
  );
  const now = (await (await http("")).json()).document.lights[0].light.transform;
  const moved = Math.hypot(...now.translation.map((x, k) => x - before.translation[k]));
  expect(moved < 0.2, `A pixel is a small way, and the light went ${moved}.`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}

/** Without a pointer the feature in the middle is grabbed. */
async function keys(page, picture) {
  const seq = await seqOf(page);
  await page.keyboard.press("3");
  await page.mouse.move(5, 5);
  await page.locator(".stage").focus();
  await page.keyboard.press("Enter");
  await page.locator(".dragged-feature").waitFor();
  for (let k = 0; k < 3; k += 1) await page.keyboard.press("Shift+ArrowDown");
  await page.locator('.dragged-feature:is([data-status="landed"], [data-status="limited"])').waitFor();
  await picture(page, "8-by-keys");
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
  await page.keyboard.press("Escape");
  expect(
    (await page.getByRole("button", { name: "Select tool" }).getAttribute("aria-pressed")) === "true",
    "Escape must put the tool away.",
  );
}

/** A finger drags as a mouse does; two are for the view, and what the first has asked comes to nothing. */
async function byFinger(open, http) {
  const context = { hasTouch: true, isMobile: true };
  const page = await open("Ada's fingers", { width: 820, height: 760 }, { context });
  const touch = await fingers(page);
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "Shadow tool" }).tap();
  const [shadow, there] = [await onStage(page, ...SHADOW), await onStage(page, 410.5, 300.5)];
  await touch([[shadow, there]]);
  await reached(page, seq + 1);
  const { action } = await latest(http, seq + 1);
  expect(action.outcome.status === "landed", `It must land: ${JSON.stringify(action)}`);
  await settled(page, seq + 1);

  const { cameraRevision } = await state(page);
  const [left, right] = [await onStage(page, 330, 330), await onStage(page, 380, 330)];
  await touch([
    [left, { x: left.x - 20, y: left.y }],
    [right, { x: right.x + 20, y: right.y }],
  ]);
  await settled(page);
  expect((await state(page)).cameraRevision !== cameraRevision, "Two fingers must zoom.");
  expect((await page.getByText("No shadow falls here").count()) === 0, "The tool must not speak of a pinch.");
  expect((await seqOf(page)) === seq + 1, "A pinch must drag nothing.");
}
