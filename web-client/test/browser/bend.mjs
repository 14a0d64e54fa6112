// A light that is bent in place: its handles lie where it shines, no pixel changes, and it is one step. What the command
// line says of the scene are its bounds in the world, which then must hold all control points.

import {
  difference,
  dragHandle,
  expect,
  keepPicture,
  pixels,
  reached,
  runBrowserTest,
  seqOf,
  settled,
} from "./page.mjs";

await runBrowserTest(async ({ open, picture, http, facts: bounds }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  const light = async () => (await (await http("")).json()).document.lights[0].light;
  if ((await light()).type === "bendy") {
    const seq = await seqOf(page);
    await page.getByRole("button", { name: "Straighten this light" }).click();
    await reached(page, seq + 1);
  }
  await settled(page);
  await picture(page, "1-straight");
  await keepPicture(page);
  const [seq, straight, spot] = [await seqOf(page), await pixels(page), await light()];
  expect(spot.type === "spot", "There must be a spotlight to bend.");
  await page.getByRole("button", { name: "Bend this light" }).click();
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  await picture(page, "2-bent");
  const bent = await light();
  expect(bent.type === "bendy" && bent.points.length === 5, "It must have control points.");
  expect(bent.intensity === spot.intensity && bent.name === spot.name, "It must stay the light that it was.");
  insideOfTheScene(bent, bounds);
  expect((await page.locator("[data-handle]").count()) >= 5, "Its control points must have handles.");
  await isAsBefore(page, "Bent it");

  // The planted fault: a control point that has moved is seen.
  await dragHandle(page, "point-2", { x: 40, y: 10 });
  await settled(page, seq + 2);
  await picture(page, "3-moved");
  const moved = await difference(page);
  expect(moved.pixels > 1000 && moved.most > 16, `A control point that moves must be seen: ${told(moved)}.`);

  await undo(page, seq + 3);
  await isAsBefore(page, "With its control point back it");
  await undo(page, seq + 4);
  expect((await light()).type === "spot", "Undone as one step it must be a spotlight again.");
  expect((await pixels(page)) === straight, "Undone as one step it must be the light before.");
  await omniLight(page, { picture, http });
});

/** A light without a cone gets one towards what is in the middle of the view, where a new light is aimed. */
async function omniLight(page, { picture, http }) {
  const seq = await seqOf(page);
  const latest = async () => (await (await http("")).json()).document.lights.at(-1).light;
  await page.getByRole("button", { name: "Add an omni light" }).click();
  await reached(page, seq + 1);
  const omni = await latest();
  await page.getByRole("button", { name: "Bend this light" }).click();
  await reached(page, seq + 2);
  await settled(page);
  await picture(page, "4-a-bent-omni-light");
  const bent = await latest();
  expect(omni.type === "omni" && bent.type === "bendy", "The omni light must be bent.");
  const [was, is] = [omni, bent].map(({ transform: { rotation } }) => shinesAlong(rotation));
  const turned = Math.hypot(...was.map((x, k) => x - is[k]));
  expect(turned < 1e-3, `It must shine at the middle of the view, not ${turned} beside it.`);
  insideOfTheScene(bent);
}

/** Direction of the light's own -Z. */
function shinesAlong([x, y, z, w]) {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), 2 * (x * x + y * y) - 1];
}

async function undo(page, seq) {
  await page.getByRole("button", { name: /^Undo/ }).first().click();
  await reached(page, seq);
  await settled(page, seq);
}

/** No channel of any pixel of the lossless picture differs by more than 1 of 255 from the spotlight's. */
async function isAsBefore(page, what) {
  const found = await difference(page);
  console.log(`${what} differs: ${told(found)}`);
  expect(found.most <= 1, `${what} must look as the spotlight did: ${told(found)}.`);
}

function told({ most, pixels }) {
  return `by ${most} of 255 at most, ${pixels} pixels by more than 1`;
}

/**
 * In the scene's bounds, where they are known, lies each control point, to roundings; and in any scene the last one no
 * farther from the source than it is large.
 */
function insideOfTheScene({ points, transform }, bounds) {
  const reach = Math.hypot(...points.at(-1)) * transform.scale;
  expect(
    reach > 0.1 && reach < 20,
    `Its control points must reach to what it shines on, not ${reach} units.`,
  );
  if (bounds === undefined) return;
  const [low, high] = bounds;
  for (const point of points.map((local) => inWorld(local, transform))) {
    const isInside = point.every((x, k) => low[k] - 1e-6 <= x && x <= high[k] + 1e-6);
    expect(isInside, `Its control point at ${point} must lie in the scene, from ${low} to ${high}.`);
  }
}

/** `translation + rotation * (scale * local)`. */
function inWorld(local, { translation, rotation: [x, y, z, w], scale }) {
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const twice = cross([x, y, z], local).map((c) => 2 * c);
  const turned = cross([x, y, z], twice);
  return local.map((c, k) => translation[k] + scale * (c + w * twice[k] + turned[k]));
}
