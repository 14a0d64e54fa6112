// The page on screens of every size, with a pointer and with fingers: nothing is cut off, covered, too small to hit or
// there unseen, and fingers do on the picture what they do everywhere.

import { expect, field, fingers, handleAt, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

const FINGERS = { hasTouch: true, isMobile: true };
const SCREENS = {
  desktop: { width: 1280, height: 800 },
  large: { width: 1920, height: 1080 },
  tablet: { width: 820, height: 1180, context: FINGERS },
  phone: { width: 390, height: 844, context: FINGERS },
  "phone on its side": { width: 844, height: 390, context: FINGERS },
  "200 %": { width: 640, height: 400, context: { deviceScaleFactor: 2 } },
  "desktop, with text of 200 %": { width: 1280, height: 800, text: "200%" },
  "tablet, with text of 200 %": { width: 820, height: 1180, text: "200%" },
  "phone, with text of 200 %": { width: 390, height: 844, text: "200%" },
};
/** WCAG 2.2, 2.5.8. */
const LEAST_TARGET_PX = 24;

const sub = (a, b) => a.map((x, k) => x - b[k]);
const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
const isWithin = (box, around) =>
  box.x >= around.x &&
  box.y >= around.y &&
  box.x + box.width <= around.x + around.width &&
  box.y + box.height <= around.y + around.height;
const length = (a) => Math.hypot(...a);
const same = (a, b) => length(sub(a, b)) < 1e-9;

await runBrowserTest(async ({ open, picture, http }) => {
  const light = { type: "spot", name: "rim", range: 5, transform: { translation: [1, 3, 1] } };
  await http("/edits", { edits: [{ command: { type: "addLight", light } }] });
  for (const [name, { width, height, context, text = "" }] of Object.entries(SCREENS)) {
    const page = await open(`Ada on ${name}`, { width, height }, { context, shows: anyPicture });
    await page.evaluate((text) => (document.documentElement.style.fontSize = text), text);
    await picture(page, name);
    await everythingIsInReach(page, name);
    await picture(page, name);
    await page.context().close();
  }
  await fingersOnThePicture(open, picture);
});

async function anyPicture(page) {
  await page.waitForFunction(() => Number(document.getElementById("page")?.dataset.frame) > 0);
}

async function everythingIsInReach(page, screen) {
  const stage = await page.locator(".stage").boundingBox();
  // A control point's fields too, and a message: a radius at which the light would fold.
  await page.getByRole("button", { name: "2", exact: true }).click();
  await page.getByRole("textbox", { name: "Radius", exact: true }).fill("1000");
  await page.keyboard.press("Enter");
  await page.locator(".toast").waitFor();
  await noFaults(page, screen);

  const planted = [
    [".tab { min-width: 0; min-height: 0; height: 20px }", "is too small"],
    [".app { width: 120vw }", "is cut off"],
    [".item-action { opacity: 0 }", "is not to be seen"],
    [
      ".toasts { position: fixed; inset: 0; max-width: none } .toast { height: 100vh; width: 100vw }",
      "is covered",
    ],
    [".light-tools button { width: 40px; overflow: hidden }", "has text that is cut off"],
    [".gate { top: 90vh !important }", "the picture is not in sight"],
    [".number input { font-size: 60px }", "has digits that are cut off"],
  ];
  for (const [style, fault] of planted) {
    await page.evaluate(dress, style);
    const found = await page.evaluate(walk, LEAST_TARGET_PX);
    expect(
      found.some((said) => said.includes(fault)),
      `"${fault}" must be noticed on the screen "${screen}".`,
    );
  }
  await page.evaluate(dress, "");

  await page.getByRole("button", { name: "rim", exact: true }).click();
  await page.getByRole("slider", { name: "Range slider" }).waitFor();
  await noFaults(page, screen);
  await page.getByRole("button", { name: "Add a spotlight" }).click();
  const added = page.locator("[data-light][aria-current=true]", { hasText: "spot" });
  await added.waitFor();
  expect(
    isWithin(await added.boundingBox(), await page.locator(".left").boundingBox()),
    `A light that is selected must be in sight in the list on the screen "${screen}".`,
  );
  const after = await page.locator(".stage").boundingBox();
  const stays = after.width === stage.width && after.height === stage.height;
  expect(stays, `What is edited must not change the picture's size on the screen "${screen}".`);
}

async function noFaults(page, screen) {
  const faults = await page.evaluate(walk, LEAST_TARGET_PX);
  expect(faults.length === 0, `On the screen "${screen}":\n${faults.join("\n")}`);
}

/** Runs in the page: gives it rules of style beside its own. */
function dress(rules) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(rules);
  document.adoptedStyleSheets = [sheet];
}

/** Runs in the page: what is wrong with its controls, a sentence each. */
function walk(leastPx) {
  const faults = [];
  const nameOf = (e) => e.getAttribute("aria-label") ?? e.title ?? e.textContent;
  const say = (e, what) => faults.push(`${e.tagName.toLowerCase()} "${nameOf(e) || e.textContent}" ${what}`);
  const inWindow = ({ left, top, right, bottom }) =>
    left >= -0.5 && top >= -0.5 && right <= innerWidth + 0.5 && bottom <= innerHeight + 0.5;
  /** True if it became visible only by scrolling what people cannot scroll. */
  const isBehindAnEdge = (e) => {
    for (let around = e.parentElement; around !== null; around = around.parentElement) {
      const { overflowX, overflowY } = getComputedStyle(around);
      if (overflowX === "hidden" && around.scrollLeft !== 0) return true;
      if (overflowY === "hidden" && around.scrollTop !== 0) return true;
    }
    return false;
  };
  const isSmall = ({ width, height }) => Math.min(width, height) < leastPx - 0.01;

  for (const control of document.querySelectorAll("button, input, select, .number-tag")) {
    if (control.closest(".toasts") !== null) continue;
    if (!control.checkVisibility({ opacityProperty: true, visibilityProperty: true })) {
      say(control, "is not to be seen");
      continue;
    }
    control.scrollIntoView({ block: "nearest", inline: "nearest" });
    const box = control.getBoundingClientRect();
    if (isSmall(box)) say(control, `is too small: ${box.width} by ${box.height}`);
    if (!inWindow(box) || isBehindAnEdge(control)) say(control, "is cut off");
    const hit = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
    if (hit === null || !control.contains(hit)) say(control, `is covered by ${hit?.className}`);
    const text = control.scrollWidth > control.clientWidth + 1 && control.querySelector(".clipped") === null;
    if (text && control.matches("button:not(.clipped)")) say(control, "has text that is cut off");
    if (control.matches(".number input") && control.scrollWidth > control.clientWidth + 1)
      say(control, "has digits that are cut off");
    const gate = document.querySelector(".gate").getBoundingClientRect();
    if (!inWindow(gate)) say(control, "can be used while the picture is not in sight");
  }
  for (const reach of document.querySelectorAll(".handle .reach")) {
    if (isSmall(reach.getBoundingClientRect())) say(reach.parentElement, "is too small");
  }
  for (const ring of document.querySelectorAll(".turn .reach-line")) {
    if (Number.parseFloat(getComputedStyle(ring).strokeWidth) < leastPx) say(ring, "is too small");
  }
  for (const said of document.querySelectorAll(
    ".top-bar > :not(.spring), .status-bar > :not(.spring, .keys)",
  )) {
    said.scrollIntoView({ block: "nearest", inline: "nearest" });
    const [box, bar] = [said, said.parentElement].map((e) => e.getBoundingClientRect());
    if (!inWindow(box) || box.bottom > bar.bottom + 0.5 || box.right > bar.right) say(said, "is cut off");
  }
  const { scrollWidth, clientWidth } = document.scrollingElement;
  if (scrollWidth > clientWidth) faults.push("The page is wider than the window: something is cut off");
  return faults;
}

async function fingersOnThePicture(open, picture) {
  const cameras = [];
  const { width, height, context } = SCREENS.phone;
  const page = await open(
    "Ada's fingers",
    { width, height },
    { context, prepare: (page) => watch(page, cameras) },
  );
  const touch = await fingers(page);
  const box = await page.locator(".stage").boundingBox();
  const at = (x, y) => ({ x: box.x + x, y: box.y + y });

  const seq = await seqOf(page);
  const [start, turned] = await wayOf(cameras, page, () => touch([[at(30, 20), at(90, 30)]]));
  expect(!same(start.rotation, turned.rotation), "One finger must turn the view.");

  const panned = (
    await wayOf(cameras, page, () =>
      touch([
        [at(100, 40), at(140, 70)],
        [at(200, 40), at(240, 70)],
      ]),
    )
  )[1];
  const way = sub(panned.translation, turned.translation);
  expect(same(panned.rotation, turned.rotation), "Two fingers that stay apart must not turn the view.");
  expect(length(way) > 0.05, "Two fingers must move the view.");
  expect(
    Math.abs(dot(way, forward(turned))) < 0.02 * length(way),
    "Two fingers that stay apart must not zoom.",
  );

  const near = (
    await wayOf(cameras, page, () =>
      touch([
        [at(150, 150), at(90, 150)],
        [at(230, 150), at(290, 150)],
      ]),
    )
  )[1];
  const inwards = sub(near.translation, panned.translation);
  expect(same(near.rotation, panned.rotation), "A pinch must not turn the view.");
  expect(
    dot(inwards, forward(panned)) > 0.95 * length(inwards),
    "Fingers that part must bring the view nearer.",
  );
  expect(
    (await page.evaluate(() => visualViewport.scale)) === 1,
    "A pinch on the picture must not zoom the page.",
  );
  expect((await seqOf(page)) === seq, "Fingers beside the light must leave it as it is.");
  await picture(page, "fingers-1-pinched");

  await handlesByFinger(page, touch);
  await picture(page, "fingers-2-dragged");
  await rowsByFinger(page);
  await fieldsByFinger(page, touch);
  await keyListFits(page);
  await picture(page, "fingers-3-key-list");
}

/** A handle goes with the finger, from as far beside it as a target may be small; a second finger lets go of it. */
async function handlesByFinger(page, touch) {
  await page.getByRole("button", { name: "Frame the selected light" }).tap();
  await settled(page);
  const stage = await page.locator(".stage").boundingBox();
  for (const handle of await page.locator(".handle .mark").all()) {
    const framed = isWithin(await handle.boundingBox(), stage);
    expect(framed, "Framing the light must bring all of its handles in sight.");
  }
  const seq = await seqOf(page);
  // The last point, outwards: that folds no light.
  const point = await handleAt(page, "point-4");
  const [beside, way] = [
    { x: point.x + 8, y: point.y + 8 },
    { x: 14, y: 10 },
  ];
  await touch([[beside, { x: beside.x + way.x, y: beside.y + way.y }]]);
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  const moved = await handleAt(page, "point-4");
  const off = Math.hypot(moved.x - point.x - way.x, moved.y - point.y - way.y);
  expect(off < 1, `A control point must go with the finger; it is ${off} pixels off.`);

  const second = { x: moved.x - 60, y: moved.y + 30 };
  await touch([
    [moved, { x: moved.x + 20, y: moved.y }],
    [second, second, 3],
  ]);
  await settled(page);
  expect(
    (await seqOf(page)) === seq + 1,
    "A second finger must let go of the control point without a trace.",
  );
}

/** Wherever a row is tapped, what happens is what was to be seen there. */
async function rowsByFinger(page) {
  const seq = await seqOf(page);
  const row = page.locator("[data-light]").first();
  const { x, y, width, height } = await row.boundingBox();
  for (const share of [0.05, 0.3, 0.6, 0.8, 0.9, 0.95, 0.99]) {
    const seen = await page.evaluate(
      ([x, y]) => {
        const hit = document.elementFromPoint(x, y).closest("button");
        return hit === null || hit.checkVisibility({ opacityProperty: true });
      },
      [x + share * width, y + height / 2],
    );
    expect(seen, "What removes a light must be seen before it is tapped.");
  }
  await page.touchscreen.tap(x + 0.3 * width, y + height / 2);
  await page.touchscreen.tap(x + 0.3 * width, y + height / 2);
  expect((await seqOf(page)) === seq, "A tap on a light's name must only select it.");
  expect((await page.evaluate(() => visualViewport.scale)) === 1, "Two taps must not zoom the page.");
}

/** A finger that starts on a slider or a number's tag scrolls the panel when it goes up or down, and changes the number
 * when it goes sideways. */
async function fieldsByFinger(page, touch) {
  await page.locator("[data-light]").first().locator(".item-name").tap();
  const scrolled = () => page.evaluate(() => document.querySelector(".right").scrollTop);
  const ofLight = page.getByRole("region", { name: "Light", exact: true });
  const tag = ofLight.locator(".number-tag", { hasText: "X" }).first();
  for (const [what, control, number] of [
    ["a slider", page.getByRole("slider", { name: "Softness slider" }), field(page, "Softness")],
    ["a number's tag", tag, field(ofLight, "Position X")],
  ]) {
    await control.evaluate((control) => {
      const panel = control.closest(".right");
      panel.scrollTop = 0;
      const [box, around] = [control, panel].map((e) => e.getBoundingClientRect());
      // Low enough to go up from, and with more below to scroll to.
      panel.scrollTop = box.top - around.top - 0.75 * around.height;
    });
    const { x, y, width, height } = await control.boundingBox();
    const start = { x: x + 0.6 * width, y: y + height / 2 };
    const [seq, value, top] = [await seqOf(page), await number.inputValue(), await scrolled()];
    const isSame = async () => (await seqOf(page)) === seq && (await number.inputValue()) === value;
    await touch([[start, { x: start.x, y: start.y - 80 }]]);
    await settled(page);
    const way = (await scrolled()) - top;
    expect(way > 30, `A swipe up from ${what} must scroll the panel; it went ${way} pixels.`);
    expect(await isSame(), `A swipe up from ${what} must leave ${value}, not ${await number.inputValue()}.`);
    if (what === "a slider") {
      const shown = await control.inputValue();
      expect(Number(shown) === Number(value), `The slider must go back to ${value}; it shows ${shown}.`);
    }
    await control.scrollIntoViewIfNeeded();
    const again = await control.boundingBox();
    const from = { x: again.x + 0.6 * again.width, y: again.y + again.height / 2 };
    await touch([[from, { x: from.x + 50, y: from.y }]]);
    await reached(page, seq + 1);
    await settled(page, seq + 1);
    const after = await number.inputValue();
    expect(after !== value && (await seqOf(page)) === seq + 1, `A swipe along ${what} must be one record.`);
  }
}

async function keyListFits(page) {
  await page.getByRole("button", { name: "Keys" }).tap();
  const list = page.getByRole("dialog", { name: "Keys" });
  await list.waitFor();
  const cut = () =>
    list.evaluate((list) => {
      // A column that is narrower than a third breaks its text at nearly every word.
      const isCut = (e) => e.scrollWidth > e.clientWidth || e.clientWidth < list.clientWidth / 3;
      return [list, ...list.querySelectorAll("dt, dd")].filter(isCut).map((e) => e.textContent);
    });
  const found = await cut();
  expect(found.length === 0, `The list of keys must fit a phone; cut off are ${found.join("; ")}`);
  await page.evaluate(dress, ".key-list dl > div { grid-template-columns: 300px 1fr }");
  expect((await cut()).length > 0, "A row that is cut off must be noticed.");
  await page.evaluate(dress, "");
  expect(await list.getByText("Two fingers").isVisible(), "The list must say what fingers do.");
}

/** Notes the cameras that the page looks from. */
function watch(page, cameras) {
  page.on("websocket", (socket) =>
    socket.on("framesent", ({ payload }) => {
      const message = JSON.parse(payload);
      const camera = message.type === "openView" ? message.source.own : message.camera;
      if (camera !== undefined) cameras.push(camera);
    }),
  );
}

/** The cameras before and after `task`. */
async function wayOf(cameras, page, task) {
  const before = cameras.at(-1);
  await task();
  await settled(page);
  return [before, cameras.at(-1)];
}

/** Direction of a camera: its local -Z in the world. */
function forward({ rotation: [x, y, z, w] }) {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
}
