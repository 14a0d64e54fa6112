// The view: what it turns about and goes to, what of it a reload keeps, fields that reckon, and a list of keys that goes as it came.

import { expect, field, pixels, runBrowserTest, seqOf, settled, SHARP, unfold } from "./page.mjs";

/** Visible points of the demo: on the table, and on a vase. */
const PLACES = [
  { x: 0.35, y: 0.72 },
  { x: 0.62, y: 0.5 },
];
const PIN = { light: 1, kind: "lit", at: [0, 0, 0], hard: true };
/** World units; the demo is some 4 across. The turn is rounded in single steps of the pointer. */
const NEAR = 1e-6;

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", undefined, SHARP);
  const canvas = await page.locator("canvas").boundingBox();
  // Wheels count whole pixels of the page.
  for (const place of PLACES) {
    place.x = (Math.round(canvas.x + place.x * canvas.width) - canvas.x) / canvas.width;
    place.y = (Math.round(canvas.y + place.y * canvas.height) - canvas.y) / canvas.height;
  }
  for (const place of PLACES) await turnsAboutWhatIsPressed(page, http, canvas, place);
  await zoomGoesToThePointer(page, http, canvas, PLACES[1]);
  await reloadKeeps(page, picture);
  await fieldsReckon(page, picture);
  await keysCloseAsTheyOpened(page);
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    await thePictureStays(open, picture, http, { width, height });
  }
});

/** Whatever is done, the picture is where it was. */
async function thePictureStays(open, picture, http, size) {
  const name = `${size.width}x${size.height}`;
  const page = await open(`Cleo ${name}`, size, SHARP);
  const rectangle = () =>
    page
      .locator("canvas")
      .boundingBox()
      .then((box) => JSON.stringify(box));
  const before = await rectangle();
  const stage = page.locator(".stage");
  const press = (key) => stage.press(key);
  const button = (label) => page.getByRole("button", { name: label, exact: true });
  const other = [];
  const actions = [
    ...["2", "b", "3", "b", "4", "5", "6"].map((key) => [`the key ${key}`, () => press(key)]),
    ["a soft pin", () => button("Hard").click()],
    ["no tool", () => press("Escape")],
    ["no handles", () => press("h")],
    ["handles", () => press("h")],
    ["no gate", () => press("g")],
    ["a gate", () => press("g")],
    ["stats", () => button("Stats").click()],
    ["a turn", () => press("ArrowLeft")],
    ["no stats", () => button("Stats").click()],
    ["the probe", () => button("Probe").click()],
    ["its answer", () => stage.hover()],
    ["no probe", () => button("Probe").click()],
    ["aiming", () => press("t")],
    ["no aiming", () => press("Escape")],
    ["through the light", () => press("l")],
    ["back", () => press("l")],
    ["the light alone", () => press("s")],
    ["all lights", () => press("s")],
    ["a light that is off", () => press("m")],
    ["an undo", () => page.keyboard.press("Control+z")],
    ["a redo", () => page.keyboard.press("Control+Shift+z")],
    ["an undo", () => page.keyboard.press("Control+z")],
    ["a copy", () => press("d")],
    ["no copy", () => page.keyboard.press("Control+z")],
    ["nothing to undo", () => page.keyboard.press("Control+z")],
    [
      "exposure",
      () =>
        button("Reset View exposure to 0 stops")
          .click()
          .catch(() => {}),
      true,
    ],
    ["somebody comes", async () => other.push(await open(`Dora of a name that is rather long ${name}`))],
    ["one's own view again", () => press("ArrowRight")],
    ["a menu of scenes", () => button("Open a scene").click()],
    ["no menu", () => page.keyboard.press("Escape")],
    ["files over the page", () => dragFiles(page, "dragEnter")],
    ["no files", () => dragFiles(page, "dragCancel")],
    ["what is no scene", () => page.evaluate(dropNothing)],
    ["nothing of it", () => button("Close").click()],
    ["links", () => unfold(page, "Links")],
    ["nodes", () => button("Lights: choose nodes").click()],
    ["picking in the picture", () => button("Lights: pick in the picture").click()],
    ["no picking", () => press("Escape")],
    ["a pin", () => http("/edits", { edits: [{ command: { type: "addPin", pin: PIN } }] })],
    ["a question", () => button("Remove key").click()],
    ["no answer", () => button("Keep").click()],
    ["no pin", () => http("/edits", { edits: [{ undo: "session" }] })],
    ["the keys", () => page.keyboard.press("?")],
    ["no keys", () => page.keyboard.press("?")],
    ["nearer", () => press("+")],
    ["all of it", () => press("a")],
    ["the light", () => press("f")],
  ].filter(([, , skip]) => skip !== true);
  for (const [what, act] of actions) {
    await act();
    await page.waitForTimeout(50);
    const now = await rectangle();
    expect(now === before, `At ${name} the picture must stay at ${before}; after ${what} it is at ${now}.`);
  }
  await press("2");
  await press("b");
  await settled(page);
  await picture(page, `3-tool-${name}`);
  for (const page of other) await page.close();
  await page.close();
}

/** Files that a pointer has with it, over the page. */
async function dragFiles(page, type) {
  const device = await page.context().newCDPSession(page);
  const data = { items: [], files: [import.meta.filename], dragOperationsMask: 1 };
  await device.send("Input.dispatchDragEvent", { type, x: 100, y: 300, data });
}

/** Runs in the page: lets go of a file that is no scene. */
function dropNothing() {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File(["x"], "notes.txt"));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
}

/** The camera that the page looks through. */
function cameraOf(page) {
  return page.evaluate(() => JSON.parse(document.getElementById("page").dataset.camera));
}

/** Surface at a point of the picture, a share of its sides. */
async function seenAt(page, http, canvas, { x, y }) {
  const size = [Math.round(canvas.width), Math.round(canvas.height)];
  const camera = { own: await cameraOf(page) };
  const asked = { camera, size, pixel: [x * canvas.width, y * canvas.height] };
  const { seen } = await (await http("/probe", asked)).json();
  expect(seen !== null, "Something has to be seen there.");
  return seen.position;
}

function apart(a, b) {
  return Math.hypot(...a.map((x, k) => x - b[k]));
}

async function turnsAboutWhatIsPressed(page, http, canvas, place) {
  const at = { x: canvas.x + place.x * canvas.width, y: canvas.y + place.y * canvas.height };
  const before = await seenAt(page, http, canvas, place);
  const from = await cameraOf(page);
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  // The first step asks what is there; the answer comes before the rest.
  await page.mouse.move(at.x + 1, at.y);
  await page.waitForTimeout(500);
  await page.mouse.move(at.x + 60, at.y + 15, { steps: 12 });
  await page.mouse.up();
  await settled(page);
  const turned = await cameraOf(page);
  expect(apart(from.rotation, turned.rotation) > 0.1, "The view must turn.");
  const after = await seenAt(page, http, canvas, place);
  expect(
    apart(before, after) < NEAR,
    `What is pressed must stay under its pixel: ${before} became ${after}.`,
  );
}

async function zoomGoesToThePointer(page, http, canvas, place) {
  const before = await seenAt(page, http, canvas, place);
  const from = await cameraOf(page);
  await page.mouse.move(canvas.x + place.x * canvas.width, canvas.y + place.y * canvas.height);
  await page.mouse.wheel(0, -240);
  await settled(page);
  const nearer = await cameraOf(page);
  expect(
    apart(nearer.translation, before) < 0.9 * apart(from.translation, before),
    "The view must go nearer.",
  );
  const after = await seenAt(page, http, canvas, place);
  expect(
    apart(before, after) < NEAR,
    `What is under the pointer must stay there: ${before} became ${after}.`,
  );
  // The planted fault: a view that goes to the middle of the picture, as plus does, which has no pointer.
  await page.locator(".stage").press("+");
  await settled(page);
  const moved = await seenAt(page, http, canvas, place);
  expect(apart(before, moved) > NEAR, "By a key the view goes to the middle.");
}

async function reloadKeeps(page, picture) {
  await page.getByRole("button", { name: "Show handles" }).click();
  await page.keyboard.press("2");
  await settled(page);
  const [before, camera] = [await pixels(page), await cameraOf(page)];
  await page.reload();
  await settled(page);
  expect(apart((await cameraOf(page)).translation, camera.translation) === 0, "A reload must keep the view.");
  expect((await pixels(page)) === before, "A reload must show the same picture.");
  const tool = await page.locator(".stage").getAttribute("data-tool");
  expect(tool === "feature", `A reload must keep the tool; it is ${tool}.`);
  expect((await page.locator("[data-handle]").count()) === 0, "A reload must keep handles hidden.");
  await picture(page, "1-reloaded");
  await page.getByRole("button", { name: "Show handles" }).click();
  await page.keyboard.press("Escape");
}

async function fieldsReckon(page, picture) {
  const exposure = field(page, "View exposure");
  for (const [typed, shown] of [
    ["1+1", "2"],
    ["*2", "4"],
    ["50%", "2"],
    ["-1 stop", "-1"],
    ["(2-1)/4", "0.25"],
  ]) {
    await exposure.fill(typed);
    await page.keyboard.press("Enter");
    expect(
      (await exposure.inputValue()) === shown,
      `${typed} must be ${shown}, not ${await exposure.inputValue()}.`,
    );
  }
  await exposure.fill("99");
  await page.keyboard.press("Enter");
  expect((await exposure.inputValue()) === "32", "Beyond 32 stops there is nothing.");
  await page.getByText("32 stops is the most").waitFor();
  const seq = await seqOf(page);
  await exposure.fill("2 apples");
  await page.keyboard.press("Enter");
  await page.getByText("does not count in “apples”").waitFor();
  expect((await exposure.inputValue()) === "2 apples", "What is not understood stays, to be mended.");
  expect((await exposure.getAttribute("aria-invalid")) === "true", "It is marked.");
  await picture(page, "2-not-understood");
  await exposure.focus();
  await page.keyboard.press("Escape");
  expect((await exposure.inputValue()) === "32", "Escape brings back what it was.");
  await exposure.fill("0");
  await page.keyboard.press("Enter");
  expect((await seqOf(page)) === seq, "One's own exposure must not be logged.");
}

async function keysCloseAsTheyOpened(page) {
  const list = page.getByRole("dialog", { name: "Keys" });
  await page.locator(".stage").focus();
  await page.keyboard.press("?");
  await list.waitFor();
  await page.keyboard.press("?");
  await list.waitFor({ state: "hidden" });
  await page.keyboard.press("?");
  await list.waitFor();
  await page.mouse.click(5, 400);
  await list.waitFor({ state: "hidden" });
}
