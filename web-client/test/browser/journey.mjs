// A scene is lit by the mouse alone, from an empty server to a reload. What the command line says is the file's path.

import { basename, resolve } from "node:path";

import { dragHandle, expect, pixels, reached, runBrowserTest, seqOf, settled, state } from "./page.mjs";

await runBrowserTest(async ({ visit, picture, send, facts }) => {
  // The browser opens no path with `..` in it.
  const file = resolve(facts);
  const page = await visit(new URL(process.argv[2]).hash);
  await page.getByRole("heading", { name: "Sessions" }).waitFor();
  const title = basename(file, ".glb");
  await aFileIsDropped(page, picture, file, title);
  const session = new URLSearchParams(new URL(page.url()).hash.slice(1)).get("session");
  const ask = (path, body) => send(`/sessions/${session}${path}`, body);
  const light = async () => (await ask("")).document.lights[0].light;

  const straight = await light();
  await bend(page, picture);
  expect((await light()).type === "bendy", `The key is a ${straight.type} and must be bent.`);
  const seq = await seqOf(page);
  await aShadowIsDragged(page, ask);
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  await picture(page, "4-dragged");

  const kept = { pixels: await pixels(page), ...(await state(page)) };
  await page.reload();
  await settled(page, seq + 1);
  const { hash, camera } = await state(page);
  expect(hash === kept.hash, "A reload must find the document as it was.");
  expect(camera === kept.camera, "A reload must find the view as it was.");
  expect((await pixels(page)) === kept.pixels, "A reload must find the picture as it was.");
  await goOn(page, picture, light);
  await theSessionIsListed(page, picture, title);
});

async function aFileIsDropped(page, picture, file, title) {
  await picture(page, "1-front-page");
  const device = await page.context().newCDPSession(page);
  for (const type of ["dragEnter", "dragOver", "drop"]) {
    const data = { items: [], files: [file], dragOperationsMask: 1 };
    await device.send("Input.dispatchDragEvent", { type, x: 600, y: 400, data });
  }
  await settled(page);
  await page.locator(".session-name", { hasText: title }).waitFor();
  await picture(page, "2-dropped");
}

async function bend(page, picture) {
  const seq = await seqOf(page);
  await page.getByRole("button", { name: "Bend this light" }).click();
  await reached(page, seq + 1);
  await settled(page, seq + 1);
  await picture(page, "3-bent");
}

/** Bends the light so that the desk lamp's shadow on the wall goes some pixels to the side. */
async function aShadowIsDragged(page, ask) {
  await page.getByRole("button", { name: "Shadow tool" }).click();
  await page
    .getByRole("group", { name: "How the light follows" })
    .getByRole("button", { name: "Control points" })
    .click();
  const box = await page.locator("canvas").boundingBox();
  const size = [Math.round(box.width), Math.round(box.height)];
  const camera = { own: JSON.parse((await state(page)).camera) };
  const probe = (pixel) => ask("/probe", { camera, size, pixel });
  const from = await lampsShadow(probe, size);
  await page.mouse.move(box.x + from[0], box.y + from[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + from[0] + 14, box.y + from[1] + 6, { steps: 6 });
  await page.locator('.dragged-feature:is([data-status="landed"], [data-status="limited"])').waitFor();
  await page.mouse.up();
}

async function lampsShadow(probe, [width, height]) {
  for (let y = 0.3; y < 0.6; y += 0.02) {
    for (let x = 0.2; x < 0.6; x += 0.02) {
      const { seen, lights } = await probe([x * width, y * height]);
      const isLamps = lights[0]?.shadowedBy?.node.startsWith("Light_Desk");
      if (isLamps && (seen.node === "back" || seen.node === "left")) return [x * width, y * height];
    }
  }
  throw new Error("The lamp must have a shadow on the wall.");
}

/** After a reload control points have their handles, and steps from before are taken back. */
async function goOn(page, picture, light) {
  await page.getByRole("button", { name: "Select tool" }).click();
  const [seq, before] = [await seqOf(page), await light()];
  await dragHandle(page, "point-2", { x: 25, y: 10 });
  await settled(page, seq + 1);
  await picture(page, "5-going-on");
  expect(JSON.stringify((await light()).points) !== JSON.stringify(before.points), "A point must move.");
  const undo = page.getByRole("button", { name: /^Undo/ }).first();
  await undo.click();
  await reached(page, seq + 2);
  expect(JSON.stringify(await light()) === JSON.stringify(before), "Undo must take the point back.");
  await undo.click();
  await reached(page, seq + 3);
  expect(JSON.stringify(await light()) !== JSON.stringify(before), "Undo must take the shadow's drag back.");
}

async function theSessionIsListed(page, picture, title) {
  await page.getByRole("link", { name: "All sessions" }).click();
  const card = page.locator(".card", { has: page.locator(`.card-link[aria-label^="${title},"]`) });
  await card.locator("[data-picture=shown]").waitFor();
  await picture(page, "6-listed");
}
