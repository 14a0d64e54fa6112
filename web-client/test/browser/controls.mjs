// One person through every panel: lights, parameters, control points, cameras, views; another is followed.

import {
  dragHandle,
  expect,
  field,
  handleAt,
  pixels,
  reached,
  runBrowserTest,
  seqOf,
  settled,
  startDragging,
} from "./page.mjs";

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await wholeLight(page);
  await picture(page, "1-moved-and-turned");
  await escapeCancels(page);
  await parameters(page);
  await controlPoints(page);
  await picture(page, "2-control-points");
  await lights(page, picture);
  await views(page);
  await people(page, await open("Bob", { width: 1024, height: 640 }), picture);
});

/** Does `task` and waits for the record that it makes. */
async function makesARecord(page, what, task) {
  const seq = await seqOf(page);
  await task();
  await reached(page, seq + 1);
  const made = (await seqOf(page)) - seq;
  expect(made === 1, `${what} must make one record; it made ${made}.`);
}

async function wholeLight(page) {
  await page.getByRole("button", { name: "Frame the selected light" }).click();
  await settled(page);
  const x = await field(page, "Position X").inputValue();
  await makesARecord(page, "Moving the light", () => dragHandle(page, "source", { x: 40, y: 10 }));
  expect((await field(page, "Position X").inputValue()) !== x, "Dragging the source must move the light.");

  const source = await handleAt(page, "source");
  await makesARecord(page, "Turning the light", async () => {
    const ring = await page.locator('[data-handle="turn-z"] .turn-front').boundingBox();
    await page.mouse.move(source.x, ring.y + 1);
    await page.mouse.down();
    await page.mouse.move(source.x + 30, ring.y + 6, { steps: 5 });
    await page.mouse.up();
  });
  expect((await field(page, "Rotation Z").inputValue()) !== "0", "Dragging a ring must turn the light.");
  await settled(page);
}

async function escapeCancels(page) {
  const seq = await seqOf(page);
  const before = await handleAt(page, "point-2");
  await startDragging(page, "point-2", { x: 30, y: 30 });
  await page.keyboard.press("Escape");
  await page.mouse.up();
  await settled(page, seq);
  const after = await handleAt(page, "point-2");
  const back = Math.hypot(after.x - before.x, after.y - before.y) < 0.5;
  expect(back && (await seqOf(page)) === seq, "Escape must put the control point back and log nothing.");
}

async function parameters(page) {
  await makesARecord(page, "A slider's drag", async () => {
    const softness = page.getByRole("slider", { name: "Softness slider" });
    await softness.scrollIntoViewIfNeeded();
    const slider = await softness.boundingBox();
    await page.mouse.move(slider.x + slider.width * 0.3, slider.y + slider.height / 2);
    await page.mouse.down();
    await page.mouse.move(slider.x + slider.width * 0.8, slider.y + slider.height / 2, { steps: 6 });
    await page.mouse.up();
  });
  const softness = Number(await field(page, "Softness").inputValue());
  expect(softness > 0.6 && softness < 1, `The slider must set the softness; it is ${softness}.`);
  await makesARecord(page, "A typed number", async () => {
    await field(page, "Cone angle").fill("31.5");
    await page.keyboard.press("Enter");
  });
  await makesARecord(page, "A choice", () =>
    page.getByRole("combobox", { name: "Decay" }).selectOption("linear"),
  );
  await makesARecord(page, "A new name", async () => {
    await field(page, "Name").fill("key of the table");
    await page.keyboard.press("Enter");
  });
  await page.locator("[data-light]", { hasText: "key of the table" }).waitFor();
}

/** On a new light: its cone is straight and cannot fold. */
async function controlPoints(page) {
  await makesARecord(page, "Adding a light", () =>
    page.getByRole("button", { name: "Add a BendyLight" }).click(),
  );
  await page.locator("[data-light][aria-current=true]", { hasText: "bendy 1" }).waitFor();
  const points = () =>
    page.getByRole("group", { name: "Control point", exact: true }).getByRole("button").count();
  await page.getByRole("button", { name: "2", exact: true }).click();
  const count = await points();
  const insert = page.getByRole("button", { name: "Insert control point" });
  await makesARecord(page, "Inserting a control point", () => insert.click());
  expect((await points()) === count + 1, "Inserting must add a control point.");
  await makesARecord(page, "A control point's colour", async () => {
    await field(page.getByRole("region", { name: "Control points" }), "Color RGB G").fill("0.25");
    await page.keyboard.press("Enter");
  });
  await settled(page);
  const remove = page.getByRole("button", { name: "Remove control point" });
  await makesARecord(page, "Removing a control point", () => remove.click());
  expect((await points()) === count, "Removing must take a control point away.");
}

async function lights(page, picture) {
  await makesARecord(page, "Adding a light", () =>
    page.getByRole("button", { name: "Add a spotlight" }).click(),
  );
  await page.locator("[data-light][aria-current=true]", { hasText: "spot 1" }).waitFor();
  await settled(page);
  const angle = await field(page, "Cone angle").inputValue();
  await page.getByRole("button", { name: "Frame the selected light" }).click();
  await settled(page);
  await makesARecord(page, "Opening the cone", () => dragHandle(page, "cone", { x: 25, y: 0 }));
  expect(
    (await field(page, "Cone angle").inputValue()) !== angle,
    "Dragging the cone's edge must change its angle.",
  );
  await settled(page);
  await picture(page, "3-a-spotlight");
  await makesARecord(page, "Removing a light", async () => {
    await page.locator("[data-light]", { hasText: "spot 1" }).hover();
    await page.getByRole("button", { name: "Remove spot 1" }).click();
  });
  await page.locator("[data-light][aria-current=true]", { hasText: "key of the table" }).waitFor();
}

async function views(page) {
  const seq = await seqOf(page);
  await page.locator("[data-camera] .item-name").first().click();
  await settled(page);
  const start = await pixels(page);
  const stage = await page.locator(".stage").boundingBox();
  const middle = { x: stage.x + stage.width / 2, y: stage.y + 20 };
  await page.mouse.move(middle.x, middle.y);
  await page.mouse.down();
  await page.mouse.move(middle.x + 90, middle.y + 20, { steps: 6 });
  await page.mouse.up();
  await page.mouse.wheel(0, -200);
  await settled(page);
  expect((await pixels(page)) !== start, "Orbiting must change the picture.");
  expect((await seqOf(page)) === seq, "Moving one's own view must not be logged.");
  const add = page.getByRole("button", { name: "Add a camera from this view" });
  await makesARecord(page, "Adding a camera", () => add.click());
  await page.locator("[data-camera] .item-name").first().click();
  await settled(page);
}

async function people(page, bob, picture) {
  await page.getByRole("button", { name: "Follow Bob's view" }).click();
  await page.getByText("Bob's view").waitFor();
  await settled(page);
  await picture(page, "4-following");
  await page.locator(".banner").getByRole("button", { name: "Stop following" }).click();
  await page.getByText("Bob's view").waitFor({ state: "hidden" });
  await bob.getByRole("button", { name: "Change your name" }).click();
  await bob.getByRole("textbox", { name: "Your name" }).fill("Robert");
  await bob.keyboard.press("Enter");
  await page.getByRole("button", { name: "Follow Robert's view" }).waitFor();
  await settled(page);
  await picture(page, "5-a-new-name");
}
