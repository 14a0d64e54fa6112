// Lights are directed in the picture: asked why a pixel is lit, pulled along one way, laid on surfaces, aimed, and looked
// through.

import { expect, fingers, handleAt, pixels, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await theProbe(page, picture);
  await arrows(page, picture, http);
  await fine(page);
  await snapping(page, picture, http);
  await aiming(page, picture, http);
  await lookingThrough(page, picture, http);
  await byFinger(open, picture, http);
});

/** The demo's light as the server has it. */
async function keyOf(http) {
  return (await (await http("")).json()).document.lights[0].light;
}

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

/** Text of the panel for the pixel under the pointer, once it matches `wanted`. */
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

  // Without a pointer the middle is probed, and the button replaces a held key.
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

/** Drags the middle of an arrow's head by so many pixels of its own way, and waits for the record. */
async function pull(page, name, px) {
  const seq = await seqOf(page);
  const mark = page.locator(`[data-handle="${name}"] .mark`);
  const [tail, tip] = await mark.evaluate((path) => {
    const { a, b, e, f } = path.getScreenCTM();
    const at = (along) => ({ x: e + along * a, y: f + along * b });
    return [at(0), at(30)];
  });
  const way = { x: (tip.x - tail.x) / 30, y: (tip.y - tail.y) / 30 };
  await page.mouse.move(tip.x, tip.y);
  await page.mouse.down();
  await page.mouse.move(tip.x + way.x * px, tip.y + way.y * px, { steps: 6 });
  await page.mouse.up();
  await reached(page, seq + 1);
  return { x: way.x * px, y: way.y * px };
}

/** An arrow pulls what is selected along its axis, and the depth arrow leaves it under its pixel. */
async function arrows(page, picture, http) {
  await page.keyboard.press("f");
  await settled(page);
  await picture(page, "4-arrows-of-the-source");
  const before = await keyOf(http);
  await pull(page, "pull-y", 30);
  const raised = (await keyOf(http)).transform.translation;
  const [x, y, z] = sub(raised, before.transform.translation);
  expect(x === 0 && z === 0 && y > 0.05, `The light must go up and nowhere else; it went by ${[x, y, z]}.`);

  await page.getByRole("button", { name: "2", exact: true }).click();
  // So that the tube's bend is in no arrow's way.
  const follow = page.getByRole("checkbox", { name: "Radii follow" });
  await follow.check();
  await picture(page, "5-arrows-of-a-point");
  const start = await handleAt(page, "point-2");
  const along = await pull(page, "pull-z", 25);
  const pulled = await handleAt(page, "point-2");
  const [gone, aside] = [
    ((pulled.x - start.x) * along.x + (pulled.y - start.y) * along.y) / 25,
    ((pulled.x - start.x) * along.y - (pulled.y - start.y) * along.x) / 25,
  ];
  expect(Math.abs(gone - 25) < 0.2, `It must go as far as the pointer: 25 pixels, not ${gone}.`);
  expect(Math.abs(aside) < 0.2, `It must stay on its axis; it is ${aside} pixels off.`);
  const moved = sub((await keyOf(http)).points[2], before.points[2]);
  const off = Math.max(Math.abs(moved[0]), Math.abs(moved[1]));
  expect(off < 1e-9 && Math.abs(moved[2]) > 0.05, `Along z it must go; it went by ${moved}.`);

  await pull(page, "pull-depth", 25);
  const nearer = await handleAt(page, "point-2");
  expect(distance(nearer, pulled) < 0.2, "Towards the eye it must stay where it is seen.");
  const there = (await keyOf(http)).points[2];
  expect(Math.hypot(...sub(there, before.points[2])) > 0.1, "And come nearer.");
  for (const _ of [1, 2, 3]) await page.keyboard.press("Control+z");
  await settled(page);
  expect(isSame(await keyOf(http), before), "Each pull must be one step.");
  await follow.uncheck();
}

/** With Shift a handle goes a tenth of the pointer's way, and goes on from there without. */
async function fine(page) {
  const seq = await seqOf(page);
  const start = await handleAt(page, "point-2");
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  await page.keyboard.down("Shift");
  await page.mouse.move(start.x + 40, start.y - 20, { steps: 4 });
  await page.keyboard.up("Shift");
  await page.mouse.move(start.x + 45, start.y - 20, { steps: 2 });
  await page.mouse.up();
  await reached(page, seq + 1);
  const end = await handleAt(page, "point-2");
  const off = distance(end, { x: start.x + 4 + 5, y: start.y - 2 });
  expect(off < 0.2, `Forty pixels with Shift are four: it is ${off} pixels off.`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);
}

/** World position of a control point of the demo's light, which is not rotated. */
function worldOf({ transform: { translation }, points }, point) {
  return points[point].map((x, k) => x + translation[k]);
}

/** A drag with Ctrl, or with the toggle on, lays things on the surface under the pointer. */
async function snapping(page, picture, http) {
  await page.getByRole("checkbox", { name: "Radii follow" }).check();
  const seq = await seqOf(page);
  const before = await keyOf(http);
  const onTable = await onPicture(page, 0.6, 0.62);
  const start = await handleAt(page, "point-3");
  await page.mouse.move(start.x, start.y);
  await page.mouse.down();
  await page.keyboard.down("Control");
  await page.mouse.move(onTable.x, onTable.y, { steps: 5 });
  await page.mouse.up();
  await page.keyboard.up("Control");
  await reached(page, seq + 1);
  await settled(page);
  expect(distance(await handleAt(page, "point-3"), onTable) < 0.2, "The point must be under the pointer.");
  const table = worldOf(await keyOf(http), 3);
  expect(Math.abs(table[1]) < 1e-9, `The table's top has height 0; the point has ${table[1]}.`);
  expect(Math.abs(worldOf(before, 3)[1]) > 0.1, "It must not have been there before.");
  await picture(page, "6-snapped");
  await page.keyboard.press("Control+z");
  await reached(page, seq + 2);

  await page.getByRole("button", { name: "Snap to surfaces" }).click();
  const source = await handleAt(page, "source");
  await page.mouse.move(source.x, source.y);
  await page.mouse.down();
  await page.mouse.move(onTable.x, onTable.y, { steps: 5 });
  await page.mouse.up();
  await reached(page, seq + 3);
  const [, height] = (await keyOf(http)).transform.translation;
  expect(height > 0 && height < 0.02, `The source must lie just above the table, not ${height} over it.`);
  await page.keyboard.press("Control+z");
  await reached(page, seq + 4);
  await page.getByRole("button", { name: "Snap to surfaces" }).click();
  expect(isSame(await keyOf(http), before), "Each must be one step.");
  await page.getByRole("checkbox", { name: "Radii follow" }).uncheck();
}

/** The next click turns the light there; one beside everything does not, and Enter takes the middle. */
async function aiming(page, picture, http) {
  const seq = await seqOf(page);
  const before = await keyOf(http);
  const banner = page.locator(".banner.mode");
  await page.getByRole("button", { name: "Aim this light" }).click();
  await banner.getByText("Pick what “key” is to shine at").waitFor();
  await picture(page, "7-aiming");
  const sky = await onPicture(page, 0.5, 0.01);
  await page.mouse.click(sky.x, sky.y);
  await banner.getByText("Nothing is seen there").waitFor();
  // On a handle, too, it is what is behind.
  const target = await handleAt(page, "point-4");
  await page.mouse.click(target.x, target.y);
  await banner.waitFor({ state: "detached" });
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  const aimed = await keyOf(http);
  expect(isSame(aimed.transform.translation, before.transform.translation), "It must stay where it is.");
  const source = await handleAt(page, "source");
  const first = await handleAt(page, "point-1");
  const [way, wanted] = [
    Math.atan2(first.y - source.y, first.x - source.x),
    Math.atan2(target.y - source.y, target.x - source.x),
  ];
  // On the screen a straight way is straight.
  expect(Math.abs(way - wanted) < 0.005, `It must leave its source towards the target: ${way}, ${wanted}.`);
  await picture(page, "8-aimed");
  await page.keyboard.press("t");
  await banner.waitFor();
  await page.locator(".stage").focus();
  await page.keyboard.press("Enter");
  await reached(page, seq + 2);
  await page.keyboard.press("t");
  await banner.waitFor();
  await page.keyboard.press("Escape");
  await banner.waitFor({ state: "detached" });
  for (const _ of [1, 2]) await page.keyboard.press("Control+z");
  await reached(page, seq + 4);
  expect(isSame(await keyOf(http), before), "Undo must turn it back.");
}

/** One's own view from the light, and back to the very same view. */
async function lookingThrough(page, picture, http) {
  const seq = await seqOf(page);
  await page.keyboard.press("a");
  await settled(page);
  const shown = await pixels(page);
  await page.getByRole("button", { name: "Look through this light" }).click();
  const banner = page.locator(".banner.mode");
  await banner.getByText("Looking through “key”").waitFor();
  await settled(page);
  await picture(page, "9-looking-through");
  expect((await pixels(page)) !== shown, "From the light the picture must be another.");
  await page.locator(".stage").focus();
  await page.keyboard.press("ArrowLeft");
  await banner.getByText("Away from your view").waitFor();
  await banner.getByRole("button", { name: "Back" }).click();
  await settled(page);
  expect((await pixels(page)) === shown, "Back must be where one was.");
  for (const _ of [1, 2]) await page.keyboard.press("l");
  await settled(page);
  expect((await pixels(page)) === shown, "By its key, too.");
  expect((await seqOf(page)) === seq, "None of it may be logged.");

  // A wide spotlight's cone is what the gate frames.
  const light = { type: "spot", name: "rim", coneAngle: 40, transform: { translation: [0, 3, 2] } };
  await http("/edits", { edits: [{ command: { type: "addLight", light } }] });
  await page.getByRole("button", { name: "rim", exact: true }).click();
  await page.keyboard.press("l");
  await banner.getByText("Looking through “rim”").waitFor();
  await settled(page);
  const gate = await page.locator(".gate").boundingBox();
  expect(Math.abs(gate.width - gate.height) < 0.1, "A cone is as high as it is wide.");
  await picture(page, "10-looking-through-a-spotlight");
  await page.keyboard.press("l");
}

/** A finger asks, pulls, lays on surfaces and aims. */
async function byFinger(open, picture, http) {
  const context = { hasTouch: true, isMobile: true };
  const page = await open("Ada's fingers", { width: 390, height: 844 }, { context });
  const touch = await fingers(page);
  const tap = ({ x, y }) => page.touchscreen.tap(x, y);
  const before = await keyOf(http);
  const probe = page.getByRole("button", { name: "Probe", exact: true });
  await page.getByRole("button", { name: "key", exact: true }).tap();
  await probe.tap();
  const [lit, shadowed] = [await onPicture(page, 0.62, 0.72), await onPicture(page, 0.45, 0.67)];
  await touch([[lit, shadowed]]);
  await page.locator(".probe-panel").getByText("shadowed by blue vase").waitFor();
  expect(await isInside(page, ".probe-panel"), "The panel must stay inside the stage.");
  await settled(page);
  await picture(page, "11-probed-by-a-finger");
  await probe.tap();
  await page.getByRole("button", { name: "Frame the selected light" }).tap();
  await settled(page);

  let seq = await seqOf(page);
  await page.getByRole("button", { name: "4", exact: true }).tap();
  const arrow = await page.locator('[data-handle="pull-y"] .mark').boundingBox();
  const tip = { x: arrow.x + arrow.width / 2, y: arrow.y + 4 };
  await touch([[tip, { x: tip.x, y: tip.y - 20 }]]);
  await reached(page, seq + 1);
  const moved = sub((await keyOf(http)).points[4], before.points[4]);
  expect(moved[1] > 0.05, `A finger must pull the point up; it went by ${moved}.`);
  await page.getByRole("button", { name: "Snap to surfaces" }).tap();
  const table = await onPicture(page, 0.6, 0.6);
  await touch([[await handleAt(page, "source"), table]]);
  await reached(page, seq + 2);
  const [, height] = (await keyOf(http)).transform.translation;
  expect(height > 0 && height < 0.02, `A finger must lay the source on the table, not ${height} over it.`);
  await page.getByRole("button", { name: "Snap to surfaces" }).tap();
  await settled(page);
  await picture(page, "12-snapped-by-a-finger");

  seq = await seqOf(page);
  await page.getByRole("button", { name: "Aim this light" }).tap();
  await picture(page, "13-aiming-by-a-finger");
  await tap(await onPicture(page, 0.5, 0.6));
  await reached(page, seq + 1);
  await page.getByRole("button", { name: "Look through this light" }).tap();
  await page.getByText("Looking through “key”").waitFor();
  await settled(page);
  await picture(page, "14-through-by-a-finger");
  await page.locator(".banner.mode").getByRole("button", { name: "Back" }).tap();
}

function sub(a, b) {
  return a.map((x, k) => x - b[k]);
}

function distance(a, b) {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

function isSame(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
