// Shared parts of the browser tests: a browser, pages of a session, and queries of them.

import { existsSync, mkdirSync } from "node:fs";
import { join } from "node:path";

import { chromium } from "playwright-core";

import { findings } from "./accessible.mjs";

/** Software renderers are slow beside a browser; this only ends a test that hangs. */
const PATIENCE_MS = 120_000;

/** Within this a picture has to be what it should; many times what it takes on a busy machine, so that it only tells that it never will be. */
const SOON_MS = 30_000;

/** Wide enough for the layout of large screens, and small, so that pictures are drawn soon. */
const WINDOW = { width: 1120, height: 600 };

/** Pixels of the server's picture per pixel of the screen, along a side: most of a test's time goes into drawing them. */
const PIXEL_SHARE = 0.5;

/** Options of `open` for what depends on every pixel. */
export const SHARP = { pixelShare: 1 };

const CHROMIUM = {
  executablePath:
    process.env.CHROMIUM ?? ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].find(existsSync),
  args: [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    // Lets tests collect garbage when it hurts.
    "--js-flags=--expose-gc",
  ],
};

/**
 * Runs `test` in a new session of the scene of the session that the address names; where it names none, without one. `open(name)` opens a page for a person called so (see openPage),
 * `visit(fragment)` another address of the server, `picture(page, name)` takes a screenshot and holds what it shows to the
 * rules of accessibility, `http(path, body)` asks the server about the session, `send(path, body)` posts JSON elsewhere on it and gives the answer, `facts` are what the command line says of
 * the scene. The command line is `ADDRESS FOLDER [FACTS]`, the address as the server printed it, facts in JSON; a failure is one sentence on standard error and exit code 1.
 */
export async function runBrowserTest(test) {
  const [address, folder, facts] = process.argv.slice(2);
  if (address === undefined || folder === undefined) {
    console.error("Say which page to test and where to put pictures: node TEST.mjs ADDRESS FOLDER [FACTS]");
    process.exit(2);
  }
  mkdirSync(folder, { recursive: true });
  const browser = await chromium.launch(CHROMIUM);
  const screenshot = (page, name) => page.screenshot({ path: join(folder, `${name}.png`) });
  const picture = async (page, name) => {
    await screenshot(page, name);
    const found = await findings(page);
    expect(found.length === 0, `In the state of ${name}.png elements break rules:\n${found.join("\n")}`);
  };
  const pages = [];
  try {
    const namesOne = new URLSearchParams(new URL(address).hash.slice(1)).has("session");
    const session = namesOne ? await newSession(address) : null;
    const open = async (name, viewport = WINDOW, options = {}) => {
      const page = await openPage(browser, session, name, viewport, options);
      pages.push(page);
      return page;
    };
    const visit = async (fragment) => {
      const page = await browser.newPage({ viewport: WINDOW });
      pages.push(page);
      await page.goto(`${new URL(address).origin}/${fragment}`);
      return page;
    };
    const http = (path, body) => ask(session, path, body);
    const send = async (path, body) => (await sendTo(address, path, body)).json();
    await test({
      open,
      visit,
      picture,
      http,
      send,
      facts: facts === undefined ? undefined : JSON.parse(facts),
    });
  } catch (error) {
    for (const [k, page] of pages.entries()) await screenshot(page, `failed-${k}`).catch(() => {});
    console.error(error instanceof Error ? error.message : String(error));
    process.exitCode = 1;
  } finally {
    await browser.close();
  }
}

/** Makes a session over HTTP, of the scene of the session at `address`; the address of its page. */
async function newSession(address) {
  const { origin, hash } = new URL(address);
  const token = new URLSearchParams(hash.slice(1)).get("token");
  const name = `browser-${Date.now()}`;
  const { scene } = (await (await ask(address, "")).json()).document;
  const answer = await fetch(`${origin}/sessions`, {
    method: "POST",
    headers: { authorization: `Bearer ${token}`, "content-type": "application/json" },
    body: JSON.stringify({ name, scene: scene.asset }),
  });
  expect(answer.status === 201, `The session could not be made: ${answer.status} ${await answer.text()}`);
  return `${origin}/#token=${token}&session=${name}`;
}

/** The server's answer to a GET of `/sessions/S` and `path`, or with a body to a POST. */
function ask(session, path, body) {
  const name = new URLSearchParams(new URL(session).hash.slice(1)).get("session");
  return sendTo(session, `/sessions/${name}${path}`, body);
}

/** The server's answer to a GET of `path`, or with a body to a POST. */
async function sendTo(address, path, body) {
  const { origin, hash } = new URL(address);
  const token = new URLSearchParams(hash.slice(1)).get("token");
  const headers = { authorization: `Bearer ${token}`, "content-type": "application/json" };
  const request = body === undefined ? {} : { method: "POST", body: JSON.stringify(body) };
  const answer = await fetch(`${origin}${path}`, { headers, ...request });
  expect(answer.ok, `The server refuses ${path}: ${answer.status} ${await answer.clone().text()}`);
  return answer;
}

/**
 * A page of the session for a person of its own, called `name`, once it shows a settled picture. `context` is told to the
 * browser (touch, pixels), `prepare` sees the page before it loads anything, `shows` waits for what is wanted of it, `hints` says whether it is the browser's first visit,
 * and `pixelShare` is `PIXEL_SHARE` or, by `SHARP`, 1.
 */
async function openPage(
  browser,
  address,
  name,
  viewport,
  { context: wanted, prepare, shows = settled, hints = false, pixelShare = PIXEL_SHARE },
) {
  const context = await browser.newContext({ viewport, ...wanted });
  await context.addInitScript((share) => {
    const ratio = window.devicePixelRatio * share;
    Object.defineProperty(window, "devicePixelRatio", { get: () => ratio });
  }, pixelShare);
  await context.addInitScript(
    ([actor, hints]) => {
      // They lie over what tests press.
      if (!hints) localStorage.setItem("bendylights.hints", "seen");
      if (localStorage.getItem("bendylights.actor") === null)
        localStorage.setItem("bendylights.actor", actor);
    },
    [JSON.stringify({ id: `test-${name}`, name }), hints],
  );
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  page.on("pageerror", (error) => console.error(`The page of ${name} failed: ${error.message}`));
  await prepare?.(page);
  await page.goto(address);
  await shows(page);
  return page;
}

/** State on the page's root element. */
export const state = (page) => page.evaluate(() => ({ ...document.getElementById("page").dataset }));

/** The latest record that the page knows. */
export const seqOf = async (page) => Number((await state(page)).seq);

/** Waits until the page knows record `seq`. */
export async function reached(page, seq) {
  await page.waitForFunction((seq) => Number(document.getElementById("page").dataset.seq) >= seq, seq);
}

/** Waits until the page shows the lossless picture of record `seq` or later, and of all that it knows. */
export async function settled(page, seq = 0) {
  await page.waitForFunction((seq) => {
    // It is missing until a page that is loaded again has drawn itself.
    const { connection, ...page } = document.getElementById("page")?.dataset ?? {};
    const isNew = Number(page.seq) >= seq && Number(page.frameLogSeq) >= Number(page.pictureSeq);
    const isHere = page.following !== "" || Number(page.frameCameraRevision) >= Number(page.cameraRevision);
    return connection === "connected" && isNew && isHere && page.frameSettle === "true";
  }, seq);
}

/** The picture's pixels, as width, height and a digest of every byte. */
export async function pixels(page) {
  return page.evaluate(async () => {
    const canvas = document.querySelector("canvas");
    const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", data));
    return `${width}x${height} ${[...digest].map((b) => b.toString(16).padStart(2, "0")).join("")}`;
  });
}

/** Waits until the page shows just `wanted`, as `pixels` gives it; else fails with `sentence`. A followed view's frames do not
 * tell whether they came after one began to follow, so `settled` may see one from before. */
export async function comesToShow(page, wanted, sentence) {
  const end = Date.now() + SOON_MS;
  while ((await pixels(page)) !== wanted) {
    expect(Date.now() < end, sentence);
    await page.waitForTimeout(50);
  }
}

/** Keeps the picture in the page, for `difference` to compare later ones with. */
export async function keepPicture(page) {
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    window.keptPicture = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  });
}

/** Difference of the picture from the kept one: the maximum of 255, and the number of pixels that differ by more than 1. */
export async function difference(page) {
  return page.evaluate(() => {
    const { data: kept, width, height } = window.keptPicture;
    const canvas = document.querySelector("canvas");
    if (canvas.width !== width || canvas.height !== height) return { most: 255, pixels: width * height };
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    let [most, pixels] = [0, 0];
    for (let k = 0; k < data.length; k += 4) {
      let worst = 0;
      for (let c = k; c < k + 4; c += 1) worst = Math.max(worst, Math.abs(data[c] - kept[c]));
      most = Math.max(most, worst);
      pixels += worst > 1 ? 1 : 0;
    }
    return { most, pixels };
  });
}

/** A field for text or a number. */
export function field(page, name) {
  return page.getByRole("textbox", { name, exact: true });
}

/** Opens a section of the panel, if it is folded. */
export async function unfold(page, name) {
  const heading = page.getByRole("region", { name }).getByRole("button", { name, exact: true });
  if ((await heading.getAttribute("aria-expanded")) === "false") await heading.click();
}

/** The middle of a handle, in pixels of the page. */
export async function handleAt(page, name) {
  const handle = page.locator(`[data-handle="${name}"]`);
  await handle.waitFor();
  const box = await handle.locator(".mark").first().boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

/** Presses on a handle and moves it; the button stays down. */
export async function startDragging(page, name, by) {
  const { x, y } = await handleAt(page, name);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + by.x, y + by.y, { steps: 8 });
}

/** Drags a handle and waits for the record. */
export async function dragHandle(page, name, by) {
  const seq = await seqOf(page);
  await startDragging(page, name, by);
  await page.mouse.up();
  await reached(page, seq + 1);
}

/** Fingers that go down one after the other, each along its way `[from, to]` at once, and are lifted. The third number
 * says after which of the steps a finger goes down. */
export async function fingers(page) {
  const device = await page.context().newCDPSession(page);
  const send = (type, touchPoints) => device.send("Input.dispatchTouchEvent", { type, touchPoints });
  const STEPS = 6;
  return async (ways) => {
    for (let step = 0; step <= STEPS; step += 1) {
      const points = ways.flatMap(([from, to, down = 0], id) => {
        const share = Math.max(0, step - 1) / (STEPS - 1);
        const point = { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y), id };
        return step < down ? [] : [point];
      });
      const fresh = ways.filter(([, , down = 0]) => down === step).length;
      if (fresh > 0) {
        for (let k = points.length - fresh; k < points.length; k += 1)
          await send("touchStart", points.slice(0, k + 1));
      } else {
        await send("touchMove", points);
      }
      await page.waitForTimeout(30);
    }
    await send("touchEnd", []);
  };
}

export function expect(holds, sentence) {
  if (!holds) throw new Error(sentence);
}
