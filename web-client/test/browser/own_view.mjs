// Settings of each viewer alone: exposure and solo lights; and actions on a light as a whole, for all.

import { comesToShow, expect, field, pixels, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const ada = await open("Ada", { width: 1440, height: 860 });
  const bob = await open("Bob", { width: 1024, height: 640 });
  const start = { ada: await pixels(ada), bob: await pixels(bob) };
  await exposure(ada, start, picture);
  await duplicate(ada, http);
  await solo(ada, bob, picture);
  await mute(ada, bob, picture);
  for (const kind of ["spotlight", "BendyLight"]) await newLight(ada, kind, picture);
  await formats(ada, http, picture);
  await folds(ada);
});

/** The slider and its number brighten Ada's picture alone; nothing is logged. */
async function exposure(page, start, picture) {
  const seq = await seqOf(page);
  const dark = await brightness(page);
  await field(page, "View exposure").fill("2");
  await page.keyboard.press("Enter");
  await settled(page);
  const bright = await brightness(page);
  expect(bright > 1.3 * dark, `Two stops must brighten the picture; it went from ${dark} to ${bright}.`);
  await picture(page, "1-two-stops");
  const slider = page.getByRole("slider", { name: "View exposure slider" });
  await slider.focus();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("Shift+ArrowLeft");
  await settled(page);
  expect((await brightness(page)) < bright, "The arrow keys must darken the picture.");
  await page.keyboard.press("Escape");
  await field(page, "View exposure").fill("99");
  await page.keyboard.press("Enter");
  expect((await field(page, "View exposure").inputValue()) === "32", "Beyond 32 stops there is nothing.");
  await page.getByRole("button", { name: "Reset View exposure to 0 stops" }).click();
  await settled(page);
  expect((await pixels(page)) === start.ada, "Without exposure the picture must be what it was.");
  expect((await seqOf(page)) === seq, "One's own exposure must not be logged.");
}

/** A copy is one step, has another name, and is selected. */
async function duplicate(page, http) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "Duplicate this light" }).click();
  await page.locator("[data-light][aria-current=true]", { hasText: "key 2" }).waitFor();
  expect((await seqOf(page)) === seq + 1, "Duplicating must be one step.");
  const { document } = await (await http("")).json();
  const [first, copy] = document.lights.map(({ light: { name: _, ...light } }) => JSON.stringify(light));
  expect(first === copy, "A copy must be what it is a copy of.");
  await settled(page);
  // Another colour, so that it is seen which of the two shines.
  await page.getByRole("button", { name: "1", exact: true }).click();
  for (const channel of ["G", "B"]) {
    await field(page.getByRole("region", { name: "Control points" }), `Color RGB ${channel}`).fill("0");
    await page.keyboard.press("Enter");
  }
  await reached(page, seq + 3);
  await page.locator("[data-light] .item-name", { hasText: "key 2" }).click();
  await page.keyboard.press("d");
  await page.locator("[data-light][aria-current=true]", { hasText: "key 3" }).waitFor();
  await page.keyboard.press("Control+z");
  await reached(page, seq + 5);
  expect((await page.locator("[data-light]").count()) === 2, "One undo must take the copy away.");
  await page.locator("[data-light] .item-name", { hasText: "key 2" }).click();
}

/** One sees a light alone, and nobody else does; who follows sees what is followed. */
async function solo(ada, bob, picture) {
  const seq = await seqOf(ada);
  for (const page of [ada, bob]) await settled(page, seq);
  const both = { ada: await pixels(ada), bob: await pixels(bob) };
  await ada.getByRole("button", { name: "Solo key 2" }).click();
  await settled(ada);
  const alone = await pixels(ada);
  expect(alone !== both.ada, "A light that is seen alone must look different.");
  await ada.getByText("Solo: key 2").waitFor();
  await picture(ada, "2-solo");
  expect((await seqOf(ada)) === seq, "Solo must not be logged.");
  expect((await pixels(bob)) === both.bob, "Nobody else may see it.");
  expect((await bob.getByText("Solo:").count()) === 0, "Nobody else may be told so.");

  await bob.getByRole("button", { name: "Follow Ada's view" }).click();
  await bob.getByText("Solo: key 2").waitFor();
  await comesToShow(bob, alone, "Who follows must see what is followed.");
  await picture(bob, "3-following-solo");
  await bob.locator(".banner").getByRole("button", { name: "Stop following" }).click();
  await bob.getByText("Solo:").waitFor({ state: "hidden" });

  // The light goes and comes back, and is alone no more.
  await ada.getByRole("button", { name: "Remove this light" }).click();
  await ada.getByText("Solo:").waitFor({ state: "hidden" });
  await ada.keyboard.press("Control+z");
  await reached(ada, seq + 2);
  await settled(ada);
  expect((await pixels(ada)) === both.ada, "All lights must shine again.");
  await ada.locator("[data-light] .item-name", { hasText: "key 2" }).click();
  await ada.keyboard.press("s");
  await ada.getByText("Solo: key 2").waitFor();
  await ada.getByRole("button", { name: "End solo" }).click();
  await settled(ada);
  expect((await pixels(ada)) === both.ada, "The end of solo must bring all lights back.");
}

/** Mute is an edit: everybody sees it, and undo takes it back. */
async function mute(ada, bob, picture) {
  const seq = await seqOf(ada);
  const lit = await pixels(ada);
  const button = ada.getByRole("button", { name: "Mute key 2" });
  await button.click();
  await reached(ada, seq + 1);
  for (const page of [ada, bob]) {
    await settled(page, seq + 1);
    await page.locator('[data-light][data-dark="true"]', { hasText: "key 2" }).waitFor();
  }
  expect((await button.getAttribute("aria-pressed")) === "true", "The button must show that it is on.");
  expect(!(await ada.getByRole("checkbox", { name: "Enabled" }).isChecked()), "The panel must say so too.");
  expect((await pixels(ada)) !== lit, "A muted light must not shine.");
  await picture(ada, "4-muted");
  await ada.keyboard.press("Control+z");
  await reached(ada, seq + 2);
  await settled(ada, seq + 2);
  expect((await pixels(ada)) === lit, "Undo must switch it on again.");
  await ada.keyboard.press("m");
  await reached(ada, seq + 3);
  await ada.getByRole("button", { name: "Reset Enabled to on" }).click();
  await reached(ada, seq + 4);
}

/** A new light, seen alone, lights what is in the middle of the view, and washes nothing out. */
async function newLight(page, kind, picture) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: `Add a ${kind}` }).click();
  await reached(page, seq + 1);
  expect((await seqOf(page)) === seq + 1, `A new ${kind} must be one step.`);
  await page.keyboard.press("s");
  await page.getByText("Solo:").waitFor();
  await settled(page, seq + 1);
  const [lit, white] = [await inTheMiddle(page), await washedOut(page)];
  await picture(page, `5-new-${kind}`);
  await field(page, "Exposure").fill("-100");
  await page.keyboard.press("Enter");
  await settled(page, seq + 2);
  const unlit = await inTheMiddle(page);
  expect(lit > unlit + 30, `A new ${kind} must light the middle; that goes from ${unlit} to ${lit}.`);
  expect(white < 0.02, `A new ${kind} must not wash the picture out; ${white} of it is white.`);
  await page.getByRole("button", { name: "Remove this light" }).click();
  await page.getByText("Solo:").waitFor({ state: "hidden" });
  await settled(page, seq + 3);
}

/** The gate has the camera's format: one step for a camera of the document, none for a view of one's own. */
async function formats(page, http, picture) {
  await page.locator("[data-camera] .item-name").first().click();
  const seq = await seqOf(page);
  const choice = page.getByRole("combobox", { name: "Format" });
  expect((await choice.inputValue()) === "16:9", "Without a format of its own a camera has 16:9.");
  await choice.selectOption("2.39");
  await reached(page, seq + 1);
  await gateIs(page, 2.39);
  const { document } = await (await http("")).json();
  const { aspectRatio } = document.cameras[0].camera.projection.perspective;
  expect(aspectRatio === 2.39, `The camera must have the format; it has ${aspectRatio}.`);
  await choice.selectOption("Own");
  await field(page, "Ratio").fill("0.8");
  await page.keyboard.press("Enter");
  await reached(page, seq + 2);
  await gateIs(page, 0.8);
  await settled(page);
  await picture(page, "6-a-format-of-its-own");
  await page.locator(".stage").focus();
  await page.keyboard.press("ArrowLeft");
  await choice.selectOption("1:1");
  await gateIs(page, 1);
  expect((await seqOf(page)) === seq + 2, "The format of one's own view must not be logged.");
}

async function gateIs(page, ratio) {
  await page.waitForFunction((ratio) => {
    const { width, height } = document.querySelector(".gate").getBoundingClientRect();
    return Math.abs(width / height / ratio - 1) < 0.01;
  }, ratio);
}

/** A section that was folded stays so. */
async function folds(page) {
  const shape = page.getByRole("button", { name: "Shape", exact: true });
  await shape.click();
  expect((await field(page, "Cone angle").count()) === 0, "A folded section must show no fields.");
  await page.reload();
  await settled(page);
  expect((await shape.getAttribute("aria-expanded")) === "false", "It must stay folded.");
  await shape.click();
  await field(page, "Cone angle").waitFor();
}

/** The largest mean level of a channel around the picture's middle. */
function inTheMiddle(page) {
  return page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const [x, y] = [canvas.width >> 1, canvas.height >> 1];
    const { data } = canvas.getContext("2d").getImageData(x - 4, y - 4, 9, 9);
    const sums = [0, 0, 0];
    for (let k = 0; k < data.length; k += 1) if (k % 4 < 3) sums[k % 4] += data[k];
    return Math.max(...sums) / 81;
  });
}

/** The share of pixels that are white. */
function washedOut(page) {
  return page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let white = 0;
    for (let k = 0; k < data.length; k += 4) white += Math.min(data[k], data[k + 1], data[k + 2]) > 245;
    return (4 * white) / data.length;
  });
}

/** Mean level of the picture's bytes. */
function brightness(page) {
  return page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((sum, level, k) => (k % 4 === 3 ? sum : sum + level), 0) / data.length;
  });
}
