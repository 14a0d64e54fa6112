// A control point that is dragged farther than its tube can bend goes as far as it can, calmly, and comes back with the
// cursor; with radii that follow nothing is in its way.

import {
  expect,
  handleAt,
  pixels,
  reached,
  runBrowserTest,
  seqOf,
  settled,
  startDragging,
  unfold,
} from "./page.mjs";

const POINT = 2;
const HANDLE = `point-${POINT}`;
/** Towards the light's own source, where the bend is tighter the farther it goes. */
const PAST_THE_WALL = { x: -330, y: -140 };
/** Pixels of the page that a handle is drawn off by at most, of its hundredths. */
const DRAWN_TO = 0.1;

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  const key = async () => (await (await http("")).json()).document.lights[0].light;
  const [seq, before, start, shown] = [
    await seqOf(page),
    await key(),
    await handleAt(page, HANDLE),
    await pixels(page),
  ];

  await startDragging(page, HANDLE, PAST_THE_WALL);
  await page.getByText("As far as the tube can bend").waitFor();
  await settled(page);
  await picture(page, "1-as-far-as-the-tube-can-bend");
  expect((await page.locator(".refused-drag").count()) === 0, "Gliding must be no refusal.");
  expect((await page.getByText("folds").count()) === 0, "Nobody must read of folds.");
  const wall = await handleAt(page, HANDLE);
  const [gone, short] = [
    distance(wall, start),
    distance(wall, { x: start.x + PAST_THE_WALL.x, y: start.y + PAST_THE_WALL.y }),
  ];
  console.log(`At the wall the point has gone ${gone} pixels and lies ${short} from the cursor.`);
  expect(gone > 10, `The point must go as far as it can, not ${gone} pixels.`);
  expect(short > 10, `The handle must be where the point is; it is ${short} pixels from the cursor.`);

  // Back with the cursor: nothing limits it, and it is under the cursor.
  await page.mouse.move(start.x + 12, start.y + 4, { steps: 5 });
  await page.locator(".limited-drag").waitFor({ state: "detached" });
  await settled(page);
  const back = await handleAt(page, HANDLE);
  const off = distance(back, { x: start.x + 12, y: start.y + 4 });
  expect(off < DRAWN_TO, `It must come back with the cursor; it is ${off} pixels off.`);

  await page.mouse.move(start.x + PAST_THE_WALL.x, start.y + PAST_THE_WALL.y, { steps: 5 });
  await page.locator(".limited-drag").waitFor();
  await page.mouse.up();
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  const committed = await handleAt(page, HANDLE);
  expect(distance(committed, wall) < DRAWN_TO, "What was shown at the wall must be what is committed.");
  expect((await page.locator(".toast").count()) === 0, "Nothing is to be said of it.");
  const bent = await key();
  expect(!isSame(bent.points[POINT], before.points[POINT]), "The record must have moved the point.");
  expect(isSame(bent.radii, before.radii), "Radii that do not follow must stay.");
  await isTakenBack(page, seq + 2, key, before, shown);

  await unfold(page, "Control points");
  await page.getByRole("checkbox", { name: "Radii follow" }).check();
  await startDragging(page, HANDLE, PAST_THE_WALL);
  await page.mouse.up();
  await reached(page, seq + 3);
  await settled(page, seq + 3);
  await picture(page, "2-radii-follow");
  const under = await handleAt(page, HANDLE);
  const left = distance(under, { x: start.x + PAST_THE_WALL.x, y: start.y + PAST_THE_WALL.y });
  expect(left < DRAWN_TO, `With radii that follow it must be under the cursor; it is ${left} pixels off.`);
  const thin = await key();
  expect(
    thin.radii.every((radius, k) => radius <= before.radii[k]) && !isSame(thin.radii, before.radii),
    "Radii must shrink, and none grow.",
  );
  await isTakenBack(page, seq + 4, key, before, shown);

  // The planted fault: an edit that sets the position past the wall is what the page must not send.
  const position = [...thin.points[POINT]];
  const command = { type: "setPoint", light: 1, point: POINT, parameter: { position } };
  const refused = await http("/edits", { edits: [{ command }] }).then(
    async (answer) => JSON.stringify(await answer.json()),
    (error) => error.message,
  );
  expect(refused.includes("folds"), `Where it was dragged the tube as it is must fold: ${refused}`);
});

/** Undo gives back the light and its pixels, as one step. */
async function isTakenBack(page, seq, key, before, shown) {
  await page.getByRole("button", { name: /^Undo/ }).first().click();
  await reached(page, seq);
  await settled(page, seq);
  expect(isSame(await key(), before), "One step must take all of it back.");
  expect((await pixels(page)) === shown, "And no pixel must differ from those before.");
}

function distance(a, b) {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

function isSame(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
