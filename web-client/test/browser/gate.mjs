// Tests that the page shows the picture that `render` writes: however it opens, at every shape of its stage, from every camera.
//
// Pictures are compared as a person would see them, shrunk to a grid; what counts as the same is half of what a twentieth
// more or less of the picture would make, measured on the same picture.

import { expect, runBrowserTest, settled, SHARP } from "./page.mjs";

const GRID = { width: 64, height: 36 };
const OPENINGS = 12;
const DESKTOP = { width: 1280, height: 800 };
/** Delay of a late event: longer than the other takes. */
const LATE_MS = 400;

await runBrowserTest(async ({ open, picture, http }) => {
  await everyOpeningShowsTheShot(open, http);
  await theGateIsWhatRenderWrites(open, picture, http);
});

/** The stage's size is known before or after the server's welcome: either may be late. */
async function everyOpeningShowsTheShot(open, http) {
  const wide = await still(http, "size=640x360");
  let whole = 0;
  let last;
  for (let k = 0; k < OPENINGS; k += 1) {
    const prepare = [undefined, lateStage, lateSocket][k % 3];
    const page = await open(`Ada ${k}`, DESKTOP, { ...SHARP, prepare, shows: firstPicture });
    whole += (await isSame(page, "middle", wide)) ? 1 : 0;
    await last?.context().close();
    last = page;
  }
  console.log(`${whole} of ${OPENINGS} openings show the whole shot`);
  expect(whole === OPENINGS, `Every opening must show the whole shot; ${whole} of ${OPENINGS} do.`);
  expect(!(await isSame(last, "middle", wide, 0.95)), "A shot that lacks a twentieth must be noticed.");
  await last.context().close();
}

function lateStage(page) {
  return page.addInitScript((lateMs) => {
    const Observer = ResizeObserver;
    window.ResizeObserver = class extends Observer {
      constructor(seen) {
        super((...sizes) => setTimeout(() => seen(...sizes), lateMs));
      }
    };
  }, LATE_MS);
}

function lateSocket(page) {
  return page.addInitScript((lateMs) => {
    const { send } = WebSocket.prototype;
    let held = new Promise((done) => setTimeout(done, lateMs));
    WebSocket.prototype.send = function (...message) {
      held = held.then(() => send.apply(this, message));
    };
  }, LATE_MS);
}

/** A picture of the stage's shape, from the page's camera. */
async function firstPicture(page) {
  await page.waitForFunction(() => {
    const { frame, frameCameraRevision, cameraRevision } = document.getElementById("page").dataset;
    const stage = document.querySelector(".stage")?.getBoundingClientRect();
    const { width, height } = document.querySelector(".stage canvas") ?? { width: 0, height: 0 };
    const fits = stage !== undefined && Math.abs(width / height - stage.width / stage.height) < 0.02;
    return Number(frame) > 0 && Number(frameCameraRevision) >= Number(cameraRevision) && fits;
  });
}

async function theGateIsWhatRenderWrites(open, picture, http) {
  const page = await open("Ada", { width: 1180, height: 520 }, SHARP);
  const shot = await still(http, "size=512x288&samples=4");
  // Resizing fits the same shot again.
  for (const stage of [
    { width: 640, height: 288 },
    { width: 480, height: 400 },
    { width: 400, height: 402 },
  ]) {
    await stageOf(page, stage);
    await theGateHolds(page, shot, `a stage of ${stage.width} by ${stage.height}`);
  }
  await picture(page, "1-a-high-stage");

  // A view of one's own, as a camera of the document.
  await stageOf(page, { width: 480, height: 400 });
  const box = await page.locator(".stage").boundingBox();
  await page.mouse.move(box.x + 100, box.y + 380);
  await page.mouse.down();
  await page.mouse.move(box.x + 180, box.y + 360, { steps: 4 });
  await page.mouse.up();
  await settled(page);
  await theGateHolds(page, shot, "a view that was turned", false);
  await page.getByRole("button", { name: "Add a camera from this view" }).click();
  await page.locator("[data-camera][aria-current=true]", { hasText: "camera 1" }).waitFor();
  await theGateHolds(
    page,
    await still(http, "camera=camera 1&size=512x288&samples=4"),
    "a camera from a view",
  );

  // A camera with a shape of its own: a still without a size has it too.
  const { document } = await (await http("")).json();
  const { name: _, ...first } = document.cameras[0].camera;
  const { perspective } = first.projection;
  const scope = {
    ...first,
    name: "scope",
    projection: { perspective: { ...perspective, aspectRatio: 2.4 } },
  };
  await http("/edits", { edits: [{ command: { type: "addCamera", camera: scope } }] });
  await page.getByRole("button", { name: "scope", exact: true }).click();
  await settled(page);
  await theGateHolds(page, await still(http, "camera=scope&samples=4"), "a camera that is 2.4 wide");
  await picture(page, "2-scope");

  // Another's view, on a stage of another shape.
  const bob = await open("Bob", { width: 1180, height: 420 }, SHARP);
  await bob.getByRole("button", { name: "Follow Ada's view" }).click();
  await settled(bob);
  await theGateHolds(bob, await still(http, "camera=scope&samples=4"), "another's view");
  await picture(bob, "3-following");

  await bob.keyboard.press("g");
  expect((await bob.locator(".gate").count()) === 0, "The key G must take the gate away.");
}

/** Resizes the window until the stage has this size. */
async function stageOf(page, { width, height }) {
  // Other sizes have other layouts, so this takes a few steps.
  for (let k = 0; k < 6; k += 1) {
    const stage = await page.locator(".stage").boundingBox();
    const window = page.viewportSize();
    await page.setViewportSize({
      width: Math.round(window.width + width - stage.width),
      height: Math.round(window.height + height - stage.height),
    });
  }
  await page.waitForFunction(
    ([width, height]) => {
      const canvas = document.querySelector(".stage canvas");
      return canvas.width === width && canvas.height === height;
    },
    [width, height],
  );
  await settled(page);
}

/** The part within the gate equals the still; within a gate a tenth too wide it does not. */
async function theGateHolds(page, shot, where, holds = true) {
  expect((await isSame(page, "gate", shot)) === holds, `The gate must hold what render writes: ${where}.`);
  if (holds) expect(!(await isSame(page, "gate", shot, 1.1)), `A gate too wide must be noticed: ${where}.`);
}

/** A picture as `render` writes it, in base64. */
async function still(http, query) {
  const answer = await http(`/render?${query}`);
  return Buffer.from(await answer.arrayBuffer()).toString("base64");
}

/**
 * True if the page's picture, within its gate or within the 16:9 of its middle (`part`), is the still. `wider` makes the
 * part as many times as wide.
 */
async function isSame(page, part, shot, wider = 1) {
  const { difference, ofATwentieth } = await page.evaluate(compare, { part, shot, wider, grid: GRID });
  return difference < ofATwentieth / 2;
}

/** Runs in the page. Differences are means over the grid, in levels of 256. */
async function compare({ part, shot, wider, grid }) {
  const canvas = document.querySelector(".stage canvas");
  const png = Uint8Array.from(atob(shot), (byte) => byte.charCodeAt(0));
  const still = await createImageBitmap(new Blob([png]));

  function gate() {
    const [line, around] = [document.querySelector(".gate"), canvas].map((e) => e.getBoundingClientRect());
    const scale = canvas.width / around.width;
    const at = { x: (line.x - around.x) * scale, y: (line.y - around.y) * scale };
    return { ...at, width: line.width * scale, height: line.height * scale };
  }

  function middle() {
    const width = Math.min(canvas.width, (canvas.height * 16) / 9);
    const height = (width * 9) / 16;
    return { x: (canvas.width - width) / 2, y: (canvas.height - height) / 2, width, height };
  }

  function shrunk(source, { x, y, width, height }) {
    const small = new OffscreenCanvas(grid.width, grid.height).getContext("2d");
    small.imageSmoothingQuality = "high";
    small.drawImage(source, x, y, width, height, 0, 0, grid.width, grid.height);
    return small.getImageData(0, 0, grid.width, grid.height).data;
  }

  const scaled = ({ x, y, width, height }, factor) => ({
    x: x - ((factor - 1) * width) / 2,
    y,
    width: width * factor,
    height,
  });
  const apart = (a, b) => a.reduce((sum, level, k) => sum + Math.abs(level - b[k]), 0) / a.length;

  const whole = { x: 0, y: 0, width: still.width, height: still.height };
  const [wanted, lacking] = [shrunk(still, whole), shrunk(still, scaled(whole, 0.95))];
  const seen = part === "gate" ? gate() : middle();
  return {
    difference: apart(shrunk(canvas, scaled(seen, wider)), wanted),
    ofATwentieth: apart(lacking, wanted),
  };
}
