// One person without a mouse: the view, the handles, the fields; and what presses leave in the log.

import { expect, field, handleAt, pixels, reached, runBrowserTest, seqOf, settled, state } from "./page.mjs";

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await theView(page, picture);
  await aHandle(page, picture);
  await otherHandles(page);
  await fields(page);
  await removing(page);
  await anotherLight(page, picture);
  await theFocusStays(page);
});

/** Goes on with Tab until `selector` has the focus. */
async function tabTo(page, selector) {
  for (let presses = 0; presses < 60; presses += 1) {
    if (await page.evaluate((selector) => document.activeElement.matches(selector), selector)) return;
    await page.keyboard.press("Tab");
  }
  throw new Error(`Tab must lead to ${selector}.`);
}

async function press(page, key, times) {
  for (let k = 0; k < times; k += 1) await page.keyboard.press(key);
}

/** Number of records that `task` makes; presses that are not yet a record become one before the next edit. */
async function recordsOf(page, task) {
  const seq = await seqOf(page);
  await task();
  const cameras = page.locator("[data-camera]");
  const count = await cameras.count();
  await page.getByRole("button", { name: "Add a camera from this view" }).click();
  await cameras.nth(count).waitFor();
  await settled(page);
  return (await seqOf(page)) - seq - 1;
}

async function theView(page, picture) {
  const seq = await seqOf(page);
  await tabTo(page, ".stage");
  await picture(page, "1-the-view-has-the-focus");
  let before = await pixels(page);
  for (const [key, what] of [
    ["ArrowRight", "orbit"],
    ["Shift+ArrowUp", "pan"],
    ["+", "zoom"],
  ]) {
    const revision = Number((await state(page)).cameraRevision);
    await page.keyboard.press(key);
    await settled(page);
    const after = await pixels(page);
    const moved = Number((await state(page)).cameraRevision) > revision && after !== before;
    expect(moved, `${key} must ${what}.`);
    before = after;
  }
  expect((await seqOf(page)) === seq, "Moving one's own view must not be logged.");
  await page.keyboard.press("f");
  await settled(page);
}

async function aHandle(page, picture) {
  await tabTo(page, '[data-handle="point-2"]');
  const handle = page.locator('[data-handle="point-2"]');
  const name = await handle.getAttribute("aria-label");
  expect(name === "Control point 2 of key", `The handle must say what it is; it says ${name}.`);
  const ring = await handle.locator(".reach").evaluate((reach) => getComputedStyle(reach).stroke);
  expect(ring !== "none", "What has the focus must show it.");
  await picture(page, "2-a-handle-has-the-focus");

  const seq = await seqOf(page);
  const before = await handleAt(page, "point-2");
  const said = await handle.getAttribute("aria-valuetext");
  await press(page, "ArrowRight", 5);
  await press(page, "Shift+ArrowUp", 1);
  // They are seen once the server has said how far the tube can bend.
  await page.waitForFunction(({ x, y }) => {
    const mark = document.querySelector('[data-handle="point-2"] .mark').getBoundingClientRect();
    return Math.hypot(mark.x + mark.width / 2 - x, mark.y + mark.height / 2 - y) > 15;
  }, before);
  expect((await seqOf(page)) === seq, "Presses must be seen before they are a record.");
  expect((await handle.getAttribute("aria-valuetext")) !== said, "The handle must say where it is by now.");
  await reached(page, seq + 1);
  await settled(page);
  const after = await handleAt(page, "point-2");
  const [x, y] = [after.x - before.x, after.y - before.y];
  // The page's pixels are drawn to a hundredth.
  const moved = Math.abs(x - 10) < 0.1 && Math.abs(y + 20) < 0.1;
  expect(moved, `Five steps right and ten up are 10 and 20 pixels; it went ${x} and ${-y}.`);
  expect((await seqOf(page)) === seq + 1, "Presses within a second must be one record.");

  await press(page, "ArrowUp", 4);
  await page.keyboard.press("Escape");
  await settled(page);
  const back = await handleAt(page, "point-2");
  expect(Math.hypot(back.x - after.x, back.y - after.y) < 0.1, "Escape must take presses back.");
  expect((await seqOf(page)) === seq + 1, "What was taken back must not be in the log.");

  await press(page, "ArrowLeft", 7);
  const undo = page.locator(".step-undo");
  const offered = await undo.getAttribute("aria-label");
  expect(offered === "Undo the last step", `Undo must offer presses under way; it says ${offered}.`);
  await page.keyboard.press("Control+z");
  await settled(page, seq + 3);
  const undone = await handleAt(page, "point-2");
  expect(
    Math.hypot(undone.x - after.x, undone.y - after.y) < 0.1,
    "Undo must take back all presses at once.",
  );
  expect((await seqOf(page)) === seq + 3, "Presses and their undo are two records.");
}

async function otherHandles(page) {
  for (const [handle, label, key] of [
    ["radius-2", "Radius", "ArrowUp"],
    ["turn-z", "Rotation Z", "ArrowRight"],
    ["source", "Position X", "ArrowLeft"],
    ["source", "Position Z", "PageUp"],
  ]) {
    const before = await field(page, label).first().inputValue();
    const records = await recordsOf(page, async () => {
      await page.locator(`[data-handle="${handle}"]`).focus();
      await press(page, key, 5);
    });
    expect(records === 1, `${key} five times at ${handle} must be one record; it made ${records}.`);
    const after = await field(page, label).first().inputValue();
    expect(after !== before, `${key} at ${handle} must change ${label}.`);
  }
}

async function fields(page) {
  const cone = field(page, "Cone angle");
  const before = Number(await cone.inputValue());
  const ofField = await recordsOf(page, async () => {
    await cone.focus();
    await press(page, "ArrowUp", 5);
  });
  expect(ofField === 1, `Five arrows in a field must be one record; they made ${ofField}.`);
  expect(Number(await cone.inputValue()) === before + 2.5, "Each arrow must change the number by a step.");

  const seq = await seqOf(page);
  await cone.focus();
  await press(page, "ArrowUp", 3);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
  expect(Number(await cone.inputValue()) === before + 2.5, "Undo in a field must take back its arrows.");

  const ofSlider = await recordsOf(page, async () => {
    await page.getByRole("slider", { name: "Softness slider" }).focus();
    await press(page, "ArrowRight", 5);
  });
  expect(ofSlider === 1, `Five arrows on a slider must be one record; they made ${ofSlider}.`);
}

async function removing(page) {
  const points = page.locator('[data-handle^="point-"]');
  const count = await points.count();
  const seq = await seqOf(page);
  await page.locator('[data-handle="point-4"]').focus();
  await page.keyboard.press("Delete");
  await reached(page, seq + 1);
  expect((await points.count()) === count - 1, "Delete must remove the control point.");
  const focused = await page.evaluate(() => document.activeElement.className);
  expect(focused === "stage", `What was removed must leave the focus to the view; ${focused} has it.`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
  expect((await points.count()) === count, "Undo must bring the control point back.");
}

async function anotherLight(page, picture) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "Add a spotlight" }).focus();
  await page.keyboard.press("Enter");
  await settled(page, seq + 1);
  await page.locator("[data-light][aria-current=true]", { hasText: "spot 1" }).waitFor();
  await page.getByRole("button", { name: "Select key", exact: true }).focus();
  await page.keyboard.press("Enter");
  await page.locator("[data-light][aria-current=true]", { hasText: "key" }).waitFor();
  await page.waitForFunction(() => document.activeElement.dataset.handle === "source");
  await picture(page, "3-another-light");
}

/** Cases in which the focused button disappears or turns grey. */
async function theFocusStays(page) {
  const focused = () => page.evaluate(() => document.activeElement.getAttribute("aria-label"));
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "Remove spot 1" }).focus();
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
  await page.getByRole("button", { name: "Remove spot 1" }).waitFor({ state: "detached" });
  const beside = await focused();
  expect(beside === "Remove key", `A row that goes must leave the focus to one beside it; ${beside} has it.`);

  const undo = page.locator(".step-undo");
  await undo.focus();
  for (let next = seq + 2; (await undo.getAttribute("aria-disabled")) === "false"; next += 1) {
    await page.keyboard.press("Enter");
    await settled(page, next);
  }
  const grey = await focused();
  expect(grey === "Nothing to undo", `A button that turns grey must keep the focus; ${grey} has it.`);
  const last = await seqOf(page);
  await page.keyboard.press("Enter");
  await settled(page);
  expect((await seqOf(page)) === last, "A grey button must do nothing.");
}
