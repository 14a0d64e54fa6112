// Distance of a light's edge around its axis: knots are added, turned, dimmed and removed.

import { expect, field, pixels, reached, runBrowserTest, seqOf, settled, unfold } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await unfold(page, "Section");
  const section = page.getByRole("region", { name: "Section" });
  const knots = async () => (await (await http("")).json()).document.lights[0].light.radialFalloff;
  /** Waits for the record that `step` makes, and gives the picture after it. */
  const after = async (step) => {
    const seq = await seqOf(page);
    await step();
    await reached(page, seq + 1);
    await settled(page);
    return pixels(page);
  };
  const type = (name, text) =>
    after(async () => {
      await field(section, name).fill(text);
      await page.keyboard.press("Enter");
    });
  const add = section.getByRole("button", { name: "Add a knot to Radial falloff" });
  await settled(page);
  const before = await pixels(page);

  expect(
    (await after(() => add.click())) === before,
    "A light that is as wide all around is the one before.",
  );
  await after(() => add.click());
  const dimmed = await type("Radial falloff 2: value", "0.3");
  expect(dimmed !== before, "A light that is narrower to one side must look otherwise.");
  await type("Radial falloff 2: degrees", "200");
  expect(
    JSON.stringify(await knots()) === "[[0,1],[200,0.3]]",
    `The knots are ${JSON.stringify(await knots())}.`,
  );
  await add.scrollIntoViewIfNeeded();
  await picture(page, "1-knots");

  // A knot stops at the knot beside it, and at the end of its range.
  await type("Radial falloff 1: degrees", "300");
  await type("Radial falloff 2: value", "7");
  expect(
    JSON.stringify(await knots()) === "[[199.9,1],[200,1]]",
    `The knots are ${JSON.stringify(await knots())}.`,
  );

  await after(() => section.getByRole("button", { name: "Take Radial falloff 1 out" }).click());
  const none = await after(() => page.getByRole("button", { name: "Reset Radial falloff to" }).click());
  expect((await knots()) === undefined && none === before, "Without knots it must be the light before.");
  await after(() => page.getByRole("button", { name: /^Undo/ }).click());
  expect((await knots()).length === 1, "Undo must bring the knot back.");
});
