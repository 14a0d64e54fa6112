// Shadows, hotspots and highlights are taken in the picture and put elsewhere, by the best answer or another one, and what is
// pinned stays.

import { expect, fingers, reached, runBrowserTest, seqOf, settled, startDragging, state } from "./page.mjs";

/** In the shadow of the blue vase's neck. */
const SHADOW = [430.5, 265.5];

const NAMES = {
  wholeLight: "Whole light",
  controlPoints: "Control points",
  narrower: "Narrower",
  pastCaster: "Past the caster",
  linkedCopy: "Linked copy",
};
const ALTERNATIVES = Object.keys(NAMES);
const ANSWER = new RegExp(Object.values(NAMES).join("|"));

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await settled(page);
  await aShadow(page, picture, http);
  await otherAnswers(page, picture, http);
  await somePoints(page, picture, http);
  await pins(page, picture, http);
  await pinsPassedOver(page, picture, http);
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

/** Presses B until the light follows so. */
async function followBy(page, name) {
  const button = page
    .getByRole("group", { name: "How the light follows" })
    .getByRole("button", { name, exact: true });
  for (let k = 0; k < 3 && (await button.getAttribute("aria-pressed")) !== "true"; k += 1)
    await page.keyboard.press("b");
  expect((await button.getAttribute("aria-pressed")) === "true", `B must lead to ${name}.`);
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
  const label = page.locator(".hand-label");
  await label.getByText("shadow of blue vase").waitFor();
  expect((await label.innerText()).includes("key"), "The label must name the light.");
  await picture(page, "1-before-anything-moves");
  await drag(page, SHADOW, [410.5, 300.5], async () => {
    await page.locator('.dragged-feature[data-status="landed"]').waitFor();
    await settledDrag(page);
    const said = await label.innerText();
    expect(ANSWER.test(said) && /changes (< )?\d+\s%/.test(said), `The label must say what changes: ${said}`);
    expect(
      Number(await opacityOf(page, ".handle.point")) < 0.5,
      "Handles must be quiet while something is dragged.",
    );
    await picture(page, "2-on-its-way");
  });
  await reached(page, seq + 1);
  const { action, changes } = await latest(http, seq + 1);
  expect(
    action.type === "gesture" && action.outcome.status === "landed",
    `It must land: ${JSON.stringify(action)}`,
  );
  expect(action.outcome.residualPx <= 0.5 && action.command.kind === "shadow", "Under the pointer.");
  expect(action.command.alternative === "best", "The best answer is the default.");
  expect(
    !("points" in action.command) && ALTERNATIVES.includes(action.outcome.alternative) && changes.length > 0,
    `The server says which it took: ${JSON.stringify(action)}`,
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

/** Tab goes through other answers, and one that is pressed after the drag takes its place. */
async function otherAnswers(page, picture, http) {
  const seq = await seqOf(page);
  const strip = page.getByRole("region", { name: "Other answers" });
  const taken = () => strip.locator('[aria-pressed="true"] .answer-name').innerText();
  let [first, second] = ["", ""];
  await drag(page, SHADOW, [420.5, 285.5], async () => {
    await page.keyboard.press("Tab");
    await strip.locator(".answer").first().waitFor();
    await settledDrag(page);
    await picture(page, "10-another-answer");
    first = await taken();
    expect(
      (await page.locator(".hand-label").innerText()).includes(first),
      `The label must name what is marked: ${first}.`,
    );
    const free = strip.locator('.answer[aria-disabled="false"]');
    expect((await free.count()) >= 2, "There must be another answer.");
    expect(
      (await free.locator("img").count()) === (await free.count()),
      "Each answer that can be had must have a picture.",
    );
    for (const refused of await strip.locator('.answer[aria-disabled="true"]').allInnerTexts())
      expect(refused.includes("Refused: "), `What is refused must say why: ${refused}`);
    await page.keyboard.press("Tab");
    await settledDrag(page);
    second = await taken();
    expect(second !== first, "Tab must go to another answer.");
    await page.keyboard.press("Shift+Tab");
    await settledDrag(page);
    expect((await taken()) === first, "Shift+Tab must go back.");
    expect(
      await page.locator(".stage").evaluate((stage) => stage === document.activeElement),
      "The focus must stay on the picture.",
    );
  });
  await reached(page, seq + 1);
  const { action } = await latest(http, seq + 1);
  expect(
    NAMES[action.command.alternative] === first,
    `What was shown must be committed: ${action.command.alternative}, not ${first}.`,
  );
  await strip.getByText("press one to take it instead").waitFor();
  await picture(page, "11-answers-after-the-drag");
  await strip.locator(".answer", { hasText: second }).click();
  await reached(page, seq + 3);
  const replaced = (await latest(http, seq + 3)).action;
  expect(
    replaced.type === "edit" && NAMES[replaced.command.alternative] === second,
    `The other answer must take its place: ${JSON.stringify(replaced)}`,
  );
  expect((await latest(http, seq + 2)).action.type === "undo", "The drag itself must be undone.");
  await strip.getByRole("button", { name: "Close the other answers" }).click();
  await strip.waitFor({ state: "detached" });
  const lights = async () => JSON.stringify((await (await http("")).json()).document.lights);
  const after = await lights();
  await page.keyboard.press("Control+z");
  await reached(page, seq + 4);
  await http("/edits", { edits: [{ command: replaced.command }] });
  await reached(page, seq + 5);
  expect((await lights()) === after, "The answer must be the one to the light before the drag.");
  await http("/edits", { edits: [{ undo: "session" }] });
  await reached(page, seq + 6);

  // The planted fault: a server that does not answer is named, and the drag goes on.
  const isDrags = (url) => url.pathname.endsWith("/drags");
  await page.route(isDrags, (route) => route.abort());
  const [start, end] = [await onStage(page, ...SHADOW), await onStage(page, 420.5, 285.5)];
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  await page.mouse.move(end.x, end.y, { steps: 4 });
  await page.locator('.dragged-feature[data-status="landed"]').waitFor();
  await page.keyboard.press("Tab");
  await strip.getByText("The server does not answer").waitFor();
  await picture(page, "12-no-other-answers");
  await page.keyboard.press("Escape");
  await strip.waitFor({ state: "detached" });
  await page.mouse.up();
  await page.unroute(isDrags);
  expect((await seqOf(page)) === seq + 6, "Escape must leave nothing behind.");
}

async function opacityOf(page, selector) {
  return page
    .locator(selector)
    .first()
    .evaluate((element) => getComputedStyle(element).opacity);
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
  await followBy(page, "Control points");
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

/** A hard pin holds a control point that is dragged, but not while P is held; then it is broken until that is undone. */
async function pinsPassedOver(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("6");
  await page.getByRole("button", { name: "Pin: In shadow" }).click();
  const shadow = await onStage(page, ...SHADOW);
  await page.mouse.click(shadow.x, shadow.y);
  await reached(page, seq + 1);
  const list = page.getByRole("region", { name: "Pins" });
  await list.getByRole("button", { name: "In shadow on table key" }).click();
  await page.locator('.pin[data-flash="true"]').waitFor();
  await picture(page, "13-a-pin-is-found");

  await page.keyboard.press("1");
  await startDragging(page, "point-3", { x: -120, y: 40 });
  const label = page.locator(".hand-label");
  await label.getByText(/^moved \d/).waitFor();
  await page.keyboard.down("p");
  await label.getByText("pins passed over").waitFor();
  await picture(page, "14-pins-passed-over");
  await page.mouse.up();
  await page.keyboard.up("p");
  await reached(page, seq + 2);
  const { command } = (await latest(http, seq + 2)).action;
  expect(command.ignorePins === true, `The drag must pass over pins: ${JSON.stringify(command)}`);
  await page.locator('.pin[data-state="broken"]').waitFor();
  await list.getByText("broken").waitFor();
  await settled(page);
  await picture(page, "15-a-broken-pin");
  await page.keyboard.press("Control+z");
  await page.locator('.pin[data-state="atRest"]').waitFor();

  // The same without the key: the pin holds.
  await startDragging(page, "point-3", { x: -120, y: 40 });
  await label.getByText(/^moved \d/).waitFor();
  await page.mouse.up();
  await reached(page, seq + 4);
  await settled(page);
  await page.waitForTimeout(800);
  expect((await page.locator('.pin[data-state="broken"]').count()) === 0, "A hard pin must hold.");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 5);
  await page.getByRole("button", { name: "Remove: In shadow on table" }).click();
  await reached(page, seq + 6);
}

/** A highlight goes on from where it is: it does not jump under the pointer. */
async function aHighlight(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("4");
  await followBy(page, "Whole light");
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
  await page
    .getByRole("group", { name: "How the light follows" })
    .getByRole("button", { name: "Best" })
    .tap();
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
  const isSilent = async () => (await page.getByText("No shadow falls here").count()) === 0;
  expect(await isSilent(), "The tool must not speak of a pinch.");
  // The second finger after the answer to the first.
  await touch([
    [left, left],
    [right, right, 5],
  ]);
  await settled(page);
  expect(await isSilent(), "The second finger must take back what the tool said of the first.");
  expect((await seqOf(page)) === seq + 1, "A pinch must drag nothing.");
}
