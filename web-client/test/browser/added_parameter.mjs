// A parameter that only the server of this test has: the page makes a field of its row, and the server keeps what is set.

import { expect, field, reached, runBrowserTest, seqOf, settled, unfold } from "./page.mjs";

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  const section = page.getByRole("region", { name: "Test" });
  await unfold(page, "Test");
  const dimmer = field(section, "Dimmer");
  expect((await dimmer.inputValue()) === "1", "What a light leaves out is the default.");
  const said = await dimmer.getAttribute("title");
  expect(
    said.includes("A row that only a test has."),
    `A field must say what its row says; it says: ${said}`,
  );

  const seq = await seqOf(page);
  await dimmer.fill("0.25");
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
  await settled(page);
  await dimmer.scrollIntoViewIfNeeded();
  await picture(page, "1-a-row-of-a-test");

  // Typed beyond the row's range, it stops at its end.
  await dimmer.fill("9");
  await page.keyboard.press("Enter");
  await reached(page, seq + 2);
  expect(
    (await dimmer.inputValue()) === "8",
    `It is ${await dimmer.inputValue()}, beyond what its row says.`,
  );

  // A page that comes later shows the server's values.
  const later = await open("Ben", { width: 1024, height: 700 });
  await unfold(later, "Test");
  const shown = await field(later.getByRole("region", { name: "Test" }), "Dimmer").inputValue();
  expect(shown === "8", `A page that comes later must see what was set; it sees ${shown}.`);

  await page.getByRole("button", { name: "Reset Dimmer to" }).click();
  await reached(page, seq + 3);
  expect((await dimmer.inputValue()) === "1", "The default must come back.");
});
