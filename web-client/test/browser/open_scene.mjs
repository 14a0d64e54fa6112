// A scene of one's own: dropped as a folder, picked by keys, made one file, sent, cancelled, refused and cut off.

import { mkdtempSync, mkdirSync, openSync, rmSync, truncateSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { expect, pixels, runBrowserTest, seqOf, settled } from "./page.mjs";

const MEGABYTE = 1e6;
/** One grey pixel. */
const PNG = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
/** A square that faces the camera, with a picture on it. Its addresses are encoded, and of another case than the files. */
const SCENE = {
  asset: { version: "2.0" },
  scene: 0,
  scenes: [{ nodes: [0] }],
  nodes: [{ mesh: 0, name: "wall" }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }],
  materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }],
  textures: [{ source: 0 }],
  images: [{ uri: "textures/wall.png" }],
  accessors: [
    { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [-1, -1, 0], max: [1, 1, 0] },
    { bufferView: 1, componentType: 5123, count: 6, type: "SCALAR" },
  ],
  bufferViews: [
    { buffer: 0, byteLength: 48 },
    { buffer: 1, byteLength: 12 },
  ],
  buffers: [
    { byteLength: 48, uri: "geo%20metry.bin" },
    { byteLength: 12, uri: `data:;base64,${bytes(new Uint16Array([0, 1, 2, 0, 2, 3])).toString("base64")}` },
  ],
};

function bytes(numbers) {
  return Buffer.from(numbers.buffer);
}

const folder = mkdtempSync(join(tmpdir(), "scenes-"));
const at = (...names) => join(folder, ...names);
mkdirSync(at("kitchen", "Textures"), { recursive: true });
writeFileSync(at("kitchen", "kitchen.gltf"), JSON.stringify(SCENE));
writeFileSync(
  at("kitchen", "Geo metry.bin"),
  bytes(new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0])),
);
writeFileSync(at("kitchen", "Textures", "Wall.png"), Buffer.from(PNG, "base64"));
writeFileSync(at("broken.glb"), "glTF is what this is not");
const sparse = (name, size) => {
  openSync(at(name), "w");
  truncateSync(at(name), size);
  return at(name);
};
const SLOW = sparse("slow.glb", 40 * MEGABYTE);
const TOO_LARGE = sparse("large.glb", 769 * 2 ** 20);

process.on("exit", () => rmSync(folder, { recursive: true }));

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1280, height: 800 }, { prepare: collectGarbageAtClicks });
  const demo = { pixels: await pixels(page), address: page.url() };
  const stays = await watchCanvas(page);
  await aFolderIsDropped(page, picture, demo);
  await stays("a folder was dropped");
  await filesArePickedByKeys(page, demo);
  await stays("files were picked");
  await whatCannotBeOpenedIsSaid(page, picture);
  await stays("scenes were refused");
  await aScenesWayIsSeenAndEnded(page, picture);
  await stays("a scene was cancelled");
  await aBrokenConnectionIsSaid(page, picture);
  await stays("a connection broke");
  for (const [width, height] of [
    [820, 1180],
    [390, 844],
  ]) {
    await onASmallScreen(open, picture, { width, height });
  }
});

/** Collects what nothing refers to after each click. A file dialog's input must survive that, else no files arrive. */
function collectGarbageAtClicks(page) {
  return page.addInitScript(() => addEventListener("click", () => setTimeout(() => globalThis.gc())));
}

/** Says that the canvas has moved, if it has. */
async function watchCanvas(page) {
  const rectangle = async () => JSON.stringify(await page.locator("canvas").boundingBox());
  const before = await rectangle();
  return async (after) => {
    const now = await rectangle();
    expect(now === before, `The picture must stay at ${before}; after ${after} it is at ${now}.`);
  };
}

/** Lets go of files over the picture, as a person does; `hover` looks at the page before that. */
async function drop(page, files, hover = async () => {}) {
  const device = await page.context().newCDPSession(page);
  const data = { items: [], files, dragOperationsMask: 1 };
  const send = (type) => device.send("Input.dispatchDragEvent", { type, x: 600, y: 400, data });
  await send("dragEnter");
  await send("dragOver");
  await hover();
  await send("drop");
  await device.detach();
}

function panel(page) {
  return page.getByRole("region", { name: "A scene on its way" });
}
function menu(page) {
  return page.getByRole("button", { name: "Open a scene", exact: true });
}
function sceneIs(page, name) {
  return page.locator(".scene-name", { hasText: name }).waitFor();
}

/** Picks files, or a folder, with the menu. */
async function pick(page, files, what = "Pick files") {
  await menu(page).click();
  const [chooser] = await Promise.all([
    page.waitForEvent("filechooser"),
    page.getByRole("button", { name: what }).click(),
  ]);
  await chooser.setFiles(files);
}

async function aFolderIsDropped(page, picture, demo) {
  const seq = await seqOf(page);
  await drop(page, [at("kitchen")], async () => {
    await page.getByText("Let go to open a scene").waitFor();
    await picture(page, "1-over-the-page");
  });
  await sceneIs(page, "kitchen");
  await page.getByText("Let go to open a scene").waitFor({ state: "hidden" });
  await settled(page, seq + 1);
  await picture(page, "2-dropped");
  expect((await seqOf(page)) === seq + 1, "Opening a scene must be one record.");
  expect((await pixels(page)) !== demo.pixels, "The picture must show the other scene.");
  expect(page.url() === demo.address, "What is dropped must not lead the page away.");
  const nodes = await page.evaluate(() => document.querySelectorAll("[data-light]").length);
  expect(nodes === 1, "A scene without lights comes with one.");
  await page.keyboard.press("Control+z");
  await sceneIs(page, "demo:vases");
}

async function filesArePickedByKeys(page, demo) {
  const seq = await seqOf(page);
  // Before the keys: the browser cancels a dialog that opens before it knows that somebody waits for one.
  const chosen = page.waitForEvent("filechooser");
  await menu(page).focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  const chooser = await chosen;
  expect(chooser.isMultiple(), "A .gltf comes with other files.");
  // All in one folder, as a file dialog gives them.
  writeFileSync(
    at("flat.gltf"),
    JSON.stringify({ ...SCENE, images: [{ uri: "wall.png" }], scenes: [{ nodes: [0], name: "Its own" }] }),
  );
  await chooser.setFiles([
    at("flat.gltf"),
    at("kitchen", "Geo metry.bin"),
    at("kitchen", "Textures", "Wall.png"),
  ]);
  await sceneIs(page, "flat");
  await settled(page, seq + 1);
  await pick(page, at("kitchen"), "Pick a folder");
  await sceneIs(page, "kitchen");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  await sceneIs(page, "demo:vases");
  await settled(page);
  expect(page.url() === demo.address, "What is picked must not lead the page away.");
}

async function whatCannotBeOpenedIsSaid(page, picture) {
  const seq = await seqOf(page);
  await pick(page, [at("kitchen", "kitchen.gltf")]);
  await panel(page)
    .getByText("needs files that did not come with it: geo metry.bin, textures/wall.png")
    .waitFor();
  await picture(page, "3-files-are-missing");
  await panel(page).getByRole("button", { name: "Close" }).focus();
  await page.keyboard.press("Enter");
  await panel(page).waitFor({ state: "hidden" });
  const focused = await menu(page).evaluate((button) => button === document.activeElement);
  expect(focused, "Closing must give the focus back to what opens scenes.");

  await drop(page, [at("kitchen", "Textures", "Wall.png")]);
  await panel(page).getByText("No scene is among these files").waitFor();
  // The next one takes its place.
  await pick(page, [at("broken.glb")]);
  await panel(page).getByText("GLB container has version").waitFor();
  await panel(page).getByRole("button", { name: "Close" }).click();
  await pick(page, [TOO_LARGE]);
  await panel(page)
    .getByText(`at most ${768 * 2 ** 20} bytes`)
    .waitFor();
  await picture(page, "4-too-large");
  await panel(page).getByRole("button", { name: "Close" }).click();

  // A link that is dropped leads nowhere either.
  const kept = page.url();
  const device = await page.context().newCDPSession(page);
  const items = [{ mimeType: "text/uri-list", data: "http://127.0.0.1:1/elsewhere" }];
  for (const type of ["dragEnter", "dragOver", "drop"])
    await device.send("Input.dispatchDragEvent", {
      type,
      x: 600,
      y: 400,
      data: { items, files: [], dragOperationsMask: 1 },
    });
  await page.waitForTimeout(200);
  expect(page.url() === kept, "A link that is dropped must not lead the page away.");
  expect((await seqOf(page)) === seq, "What is refused must change nothing.");
}

/** Lets so many bytes a second go to the server; none says all. */
async function sendSlowly(page, uploadThroughput) {
  const device = await page.context().newCDPSession(page);
  await device.send("Network.enable");
  const conditions = { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput };
  await device.send("Network.emulateNetworkConditions", conditions);
}

async function aScenesWayIsSeenAndEnded(page, picture) {
  const seq = await seqOf(page);
  await sendSlowly(page, 2 * MEGABYTE);
  await pick(page, [SLOW]);
  const progress = panel(page).getByRole("progressbar");
  await page.waitForFunction(() => document.querySelector(".opening progress")?.value > 0);
  const first = await progress.evaluate((bar) => bar.value);
  await page.waitForFunction((first) => document.querySelector(".opening progress")?.value > first, first);
  const { value, max } = await progress.evaluate(({ value, max }) => ({ value, max }));
  expect(max === 40 * MEGABYTE && value < max, `The bar must say how far it is; it says ${value} of ${max}.`);
  await panel(page).getByText("of 40 MB").waitFor();
  await picture(page, "5-on-its-way");
  await pick(page, [at("broken.glb")]);
  await page.getByText("A scene is on its way already").waitFor();
  await panel(page).getByRole("button", { name: "Cancel" }).focus();
  await page.keyboard.press("Enter");
  await panel(page).waitFor({ state: "hidden" });
  const focused = await menu(page).evaluate((button) => button === document.activeElement);
  expect(focused, "Cancelling must give the focus back to what opens scenes.");
  await sendSlowly(page, -1);
  await sceneIs(page, "demo:vases");
  expect((await seqOf(page)) === seq, "A scene that is cancelled must change nothing.");
}

async function aBrokenConnectionIsSaid(page, picture) {
  const seq = await seqOf(page);
  await page.route("**/assets?*", (route) => route.abort("connectionreset"));
  await pick(page, at("kitchen"), "Pick a folder");
  await panel(page).getByText("The connection broke").waitFor();
  await picture(page, "6-the-connection-broke");
  await page.unroute("**/assets?*");
  // The server's answer waits.
  const device = await page.context().newCDPSession(page);
  await device.send("Fetch.enable", { patterns: [{ urlPattern: "*/assets?*", requestStage: "Response" }] });
  const answered = new Promise((resolve) => device.once("Fetch.requestPaused", resolve));
  await panel(page).getByRole("button", { name: "Try again" }).click();
  const { requestId } = await answered;
  await panel(page).getByText("The server reads it").waitFor();
  await picture(page, "7-the-server-reads-it");
  await device.send("Fetch.continueRequest", { requestId });
  await sceneIs(page, "kitchen");
  await panel(page).waitFor({ state: "hidden" });
  await device.send("Fetch.disable");
  await settled(page, seq + 1);
  await page.keyboard.press("Control+z");
  await sceneIs(page, "demo:vases");
}

async function onASmallScreen(open, picture, size) {
  const name = `${size.width}x${size.height}`;
  const page = await open(`Bob ${name}`, size);
  const stays = await watchCanvas(page);
  await menu(page).click();
  await page.getByRole("button", { name: "Pick a folder" }).waitFor();
  await picture(page, `8-menu-${name}`);
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "Pick a folder" }).waitFor({ state: "hidden" });
  await pick(page, [at("kitchen", "kitchen.gltf")]);
  await panel(page).getByText("needs files").waitFor();
  await picture(page, `9-missing-${name}`);
  const box = await panel(page).boundingBox();
  expect(
    box.x >= 0 && box.x + box.width <= size.width,
    `At ${name} the panel must be whole: ${JSON.stringify(box)}`,
  );
  await stays("a scene was refused");
  const seq = await seqOf(page);
  await pick(page, at("kitchen"), "Pick a folder");
  await page.getByRole("button", { name: "1 note on the scene" }).waitFor();
  await settled(page, seq + 1);
  await picture(page, `10-with-notes-${name}`);
  await stays("a scene came with notes");
  await page.keyboard.press("Control+z");
  await sceneIs(page, "demo:vases");
  await page.close();
}
