// Two people in one session: one bends a light by a control point and undoes it, the other sees it live.

import {
  dragHandle,
  expect,
  handleAt,
  pixels,
  reached,
  runBrowserTest,
  seqOf,
  settled,
  startDragging,
  state,
} from "./page.mjs";

/** Bends the demo's light enough to move its shadows. */
const WAY = { x: 60, y: -50 };

await runBrowserTest(async ({ open, picture, http }) => {
  const ada = await open("Ada");
  const bob = await open("Bob", { width: 1024, height: 640 });
  const before = { ada: await pixels(ada), bob: await pixels(bob), seq: await seqOf(ada) };
  await picture(ada, "1-before");
  await undoIs(ada, "Nothing to undo");

  await aDragIsSeenLive(ada, bob, picture);
  expect((await seqOf(ada)) === before.seq, "A drag that is under way must not be in the log.");
  await ada.mouse.up();
  for (const page of [ada, bob]) await settled(page, before.seq + 1);
  await bob.getByText("Ada holds").waitFor({ state: "hidden" });
  await picture(ada, "3-bent");
  expect((await pixels(ada)) !== before.ada, "The picture must change when a control point is dragged.");
  expect((await pixels(bob)) !== before.bob, "The other page's picture must change with the drag.");
  await theSameDocument(ada, bob);
  await undoIs(ada, "Undo the position of control point 2 of “key”");
  await undoIs(bob, "Nothing to undo");
  await bob.getByRole("button", { name: "All" }).click();
  await undoIs(bob, "Undo the position of control point 2 of “key”, by Ada");
  await bob.getByRole("button", { name: "Mine" }).click();

  await ada.keyboard.press("Control+z");
  for (const page of [ada, bob]) await settled(page, before.seq + 2);
  await picture(ada, "4-undone");
  expect((await pixels(ada)) === before.ada, "Undo must bring back exactly the pixels from before the drag.");
  expect((await pixels(bob)) === before.bob, "Undo must bring back the other page's pixels too.");
  await theSameDocument(ada, bob);

  await ada.keyboard.press("Control+Shift+z");
  await reached(bob, before.seq + 3);
  await dragHandle(bob, "radius-2", { x: -25, y: 12 });
  for (const page of [ada, bob]) await settled(page, before.seq + 4);
  await theSameDocument(ada, bob);
  await picture(bob, "5-both-have-edited");

  // Ada's undo takes back her redo's step, not Bob's radius.
  const radius = await radiusOf(ada, 2);
  await ada.keyboard.press("Control+z");
  for (const page of [ada, bob]) await settled(page, before.seq + 5);
  expect((await radiusOf(ada, 2)) === radius, "Undo of one's own steps must leave the other's edit alone.");
  await theSameDocument(ada, bob);
  await overtakenStepsAreSaid(ada, http);
});

/** Steps that other actors have overtaken stay, and the first press says so; the second undoes the step before. */
async function overtakenStepsAreSaid(ada, http) {
  const edit = (who, target, value) =>
    http("/edits", {
      actor: { id: `test-${who}`, name: who },
      edits: [{ command: { type: "set", target, value } }],
    });
  await edit("Ada", "/lights/key/exposure", 1);
  await edit("Ada", "/lights/key/coneAngle", 31);
  await edit("Bob", "/lights/key/coneAngle", 32);
  const seq = (await (await http("")).json()).seq;
  await settled(ada, seq);
  await undoIs(ada, "Undo the exposure of “key”");
  await ada.keyboard.press("Control+z");
  await ada.getByText("Bob has changed the cone angle of “key” since: it stays.").waitFor();
  expect((await seqOf(ada)) === seq, "The first press must take nothing back.");
  await ada.keyboard.press("Control+z");
  await reached(ada, seq + 1);
  const { document } = await (await http("")).json();
  const { exposure = 0, coneAngle } = document.lights[0].light;
  expect(exposure === 0 && coneAngle === 32, "The second press takes back the step before, and Bob's stays.");
}

/** Ada holds a control point; Bob sees it move and who holds it, and cannot take it. */
async function aDragIsSeenLive(ada, bob, picture) {
  const seenByBob = await handleAt(bob, "point-2");
  const live = Number((await state(bob)).liveRevision);
  await startDragging(ada, "point-2", WAY);
  await bob.locator('.light[data-held="true"]').waitFor();
  await bob.waitForFunction(
    (live) => Number(document.getElementById("page").dataset.liveRevision) > live,
    live,
  );
  await picture(bob, "2-seen-by-the-other");
  const moved = await handleAt(bob, "point-2");
  const way = Math.hypot(moved.x - seenByBob.x, moved.y - seenByBob.y);
  expect(
    way > 10,
    `The other page must show the control point where the drag has it; it moved by ${way} pixels.`,
  );
  const said = await bob.getByText("is held by Ada").count();
  expect(said > 0, "The other page must say who holds the light.");
  await whatIsHeldIsNotTaken(bob, picture);
}

/** Whoever reaches for what another holds is told whose it is, by the pointer and by keys; nothing moves. */
async function whatIsHeldIsNotTaken(bob, picture) {
  const [before, rectangle] = [await seqOf(bob), JSON.stringify(await bob.locator("canvas").boundingBox())];
  const told = bob.getByText("Ada holds “key”: take it once Ada lets go");
  expect((await told.count()) === 0, "Nobody is told before he reaches for it.");
  await startDragging(bob, "point-2", { x: 20, y: 10 });
  await told.waitFor();
  await picture(bob, "2-reached-for");
  const now = JSON.stringify(await bob.locator("canvas").boundingBox());
  expect(now === rectangle, `The picture must stay at ${rectangle}; it is at ${now}.`);
  await bob.mouse.up();
  await bob.reload();
  await bob.locator('.light[data-held="true"]').waitFor();
  await bob.locator('[data-handle="point-2"]').focus();
  await bob.keyboard.press("ArrowRight");
  await told.waitFor();
  expect((await seqOf(bob)) === before, "What another holds must not move.");
}

/** Waits until the undo button says so; it is grey where it would do nothing. */
async function undoIs(page, label) {
  await page.locator(`.step-undo[aria-label="${label}"]`).waitFor();
  const isGrey = await page.locator(".step-undo").isDisabled();
  expect(isGrey === label.startsWith("Nothing"), `"${label}" must be grey only where it does nothing.`);
}

async function theSameDocument(a, b) {
  const [first, second] = [await state(a), await state(b)];
  expect(
    first.seq === second.seq && first.hash === second.hash,
    `Both pages must have the same document: ${first.seq} ${first.hash}, ${second.seq} ${second.hash}.`,
  );
}

/** The radius of a control point as the panel shows it. */
async function radiusOf(page, point) {
  const tab = page.getByRole("button", { name: String(point), exact: true });
  if ((await tab.getAttribute("aria-pressed")) === "false") await tab.click();
  return page.getByRole("textbox", { name: "Radius" }).inputValue();
}
