// While a control point is dragged pictures may be reduced so that they keep coming; the page says so, shows them as large as
// ever, and its person can forbid it.

import { expect, field, pixels, runBrowserTest, seqOf, settled, startDragging, state } from "./page.mjs";

const SECONDS = Number(process.env.BENDYLIGHTS_DRAG_S ?? 6);

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1280, height: 800 });
  const atRest = await picturesSeen(page, () => page.waitForTimeout(300));
  const [full] = atRest;
  expect(full.said === "Lossless", `At rest the picture is lossless, not “${full.said}”.`);

  const seen = await picturesSeen(page, () => circle(page, "reduced"));
  await settled(page);
  for (const { width, shown, said } of seen) {
    expect(shown === full.shown, "However many pixels a picture has, it is shown as large.");
    const isReduced = said.includes("resolution");
    expect(
      isReduced === width < full.width,
      `A picture ${width} pixels wide of ${full.width} is called “${said}”.`,
    );
  }
  await picture(page, "2-at-rest");
  expect((await picturesSeen(page, () => {}))[0].width === full.width, "At rest the picture is full.");

  const button = page.getByRole("button", { name: "Full detail while something moves" });
  await button.click();
  expect((await button.getAttribute("aria-pressed")) === "true", "Full detail stays pressed.");
  await settled(page);
  const unreduced = await picturesSeen(page, () => circle(page, "forbidden"));
  await settled(page);
  expect(
    unreduced.every(({ width, said }) => width === full.width && (said === "Live" || said === "Lossless")),
    "What is forbidden is not reduced.",
  );
  expect((await pixels(page)).startsWith(`${full.width}x`), "At rest the picture is full.");
  await statsTellWhatRan(page, picture);
  const rate = (frames) => (frames.length / SECONDS).toFixed(1);
  console.log(
    `${rate(seen)} pictures a second, ${rate(unreduced)} in full; ${[...new Set(seen.map(({ said }) => said))]}`,
  );

  /** Drags a control point in circles, in small steps as a hand does. */
  async function circle(page, name) {
    await startDragging(page, "point-2", { x: 20, y: 0 });
    const end = Date.now() + SECONDS * 1000;
    const from = await page.evaluate(() => window.pointerAt);
    for (let k = 0; Date.now() < end; k += 1) {
      const angle = k / 12;
      await page.mouse.move(from.x + 30 * (Math.cos(angle) - 1), from.y + 30 * Math.sin(angle));
      await page.waitForTimeout(12);
    }
    await picture(page, `1-${name}`);
    const { liveRevision } = await state(page);
    await page.keyboard.press("Escape");
    await page.mouse.up();
    // A picture from before may be lossless too, as the hand has rested meanwhile.
    await page.waitForFunction(
      (before) => Number(document.getElementById("page").dataset.liveRevision) > before,
      Number(liveRevision),
    );
  }
});

/** While Stats is open it says what each picture drew and why. */
async function statsTellWhatRan(page, picture) {
  const button = page.getByRole("button", { name: "Stats" });
  const panel = page.getByRole("region", { name: "Stats" });
  expect((await panel.count()) === 0, "Nobody sees stats who has not asked for them.");
  await button.focus();
  await page.keyboard.press("Enter");
  await panel.waitFor();
  expect((await button.getAttribute("aria-expanded")) === "true", "The button says that it is open.");

  await startDragging(page, "point-2", { x: 15, y: 10 });
  await panel.getByText("Shadow map of key: the light changed, 1", { exact: true }).waitFor();
  await panel.getByText("Lossless").waitFor();
  await picture(page, "3-stats-of-a-drag");
  const [box, stage] = [await panel.boundingBox(), await page.locator(".stage").boundingBox()];
  expect(box.y > stage.y + stage.height / 2, "Stats leave the middle of the picture free.");
  const seq = await seqOf(page);
  await page.mouse.up();
  await settled(page, seq + 1);

  const intensity = field(page.getByRole("region", { name: "Emission", exact: true }), "Intensity");
  await intensity.fill("2.5");
  await intensity.press("Enter");
  await settled(page, seq + 2);
  const said = await panel.innerText();
  expect(said.includes("Display: drawn every time, 1"), `Stats say what an intensity had drawn:\n${said}`);
  expect(!said.includes("Shadow map"), `An intensity draws no shadow map:\n${said}`);

  await button.click();
  expect((await panel.count()) === 0, "Stats go when they are no longer asked for.");
}

/** Pictures that were on the screen during `work`: their width, their displayed size, and the status text. */
async function picturesSeen(page, work) {
  await page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const look = () => {
      const [frame, said] = [
        document.getElementById("page").dataset.frame,
        document.querySelector(".quality"),
      ];
      const last = window.seen.at(-1);
      const shown = Math.round(canvas.getBoundingClientRect().width);
      if (last?.frame !== frame)
        window.seen.push({ frame, width: canvas.width, shown, said: said.textContent });
      if (window.isLooking) requestAnimationFrame(look);
    };
    window.onpointermove = ({ clientX: x, clientY: y }) => (window.pointerAt = { x, y });
    [window.seen, window.isLooking] = [[], true];
    look();
  });
  await work();
  return page.evaluate(() => {
    window.isLooking = false;
    return window.seen;
  });
}
