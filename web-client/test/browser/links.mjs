// Which nodes a light lights and which throw shadows in it: picked, typed, taken out and undone.

import { expect, pixels, reached, runBrowserTest, seqOf, settled, unfold } from "./page.mjs";

await runBrowserTest(async ({ open, picture, http }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await unfold(page, "Links");
  const links = page.getByRole("region", { name: "Links" });
  const list = (name) => links.getByRole("combobox", { name, exact: true });
  const shown = async () => {
    await settled(page);
    return pixels(page);
  };
  const light = async () => (await (await http("")).json()).document.lights[0].light;
  /** Waits for the record that `step` makes, and gives the picture after it. */
  const after = async (step) => {
    const seq = await seqOf(page);
    await step();
    await reached(page, seq + 1);
    return shown();
  };
  const before = await shown();

  const offered = await links.locator("datalist option").evaluateAll((all) => all.map(({ value }) => value));
  for (const node of ["table", "blue vase", "orange vase"])
    expect(offered.includes(node), `The nodes of the scene must be offered; these are: ${offered}`);

  const dark = await after(async () => {
    await list("Lights: not").fill("blue vase");
    await page.keyboard.press("Enter");
  });
  expect(dark !== before, "A vase that is not lit must look otherwise.");
  const { exclude } = (await light()).lightLink;
  expect(String(exclude) === "blue vase", `The light must not light the vase; it leaves out ${exclude}.`);
  expect((await list("Lights: not").inputValue()) === "", "What was added must not stay in the field.");

  // What names nothing here is refused where it is typed, and the shot stays as bright as it was.
  const typed = await seqOf(page);
  await list("Lights: only").fill("attic/chair");
  await page.keyboard.press("Enter");
  await links.getByText("“attic/chair” names nothing in this scene").waitFor();
  expect(
    (await seqOf(page)) === typed && (await shown()) === dark,
    "A path that names nothing must change nothing.",
  );
  await page.keyboard.press("Escape");

  // A program, or a scene from before, may have one all the same.
  await after(() => {
    const value = { include: ["attic/chair"] };
    return http("/edits", {
      actor: { id: "test-Ada", name: "Ada" },
      edits: [{ command: { type: "set", target: "/lights/key/shadowLink", value } }],
    });
  });
  const missing = links.locator('[data-missing="true"]');
  expect((await missing.count()) === 1, "A path that names nothing here must be marked, and no other.");
  const said = await missing.getAttribute("title");
  expect(said.includes("no effect"), `It must say so; it says: ${said}`);
  await links.scrollIntoViewIfNeeded();
  await picture(page, "1-links");

  // What was only begun is no path.
  const seq = await seqOf(page);
  await list("Lights: only").fill("blue");
  await list("Lights: not").focus();
  await settled(page);
  expect((await seqOf(page)) === seq, "Half a path must not be taken for one.");

  const lit = await after(() =>
    links.getByRole("button", { name: "Take blue vase out of Lights: not" }).click(),
  );
  expect((await light()).lightLink === undefined, "Without paths all nodes count.");
  await after(() => page.getByRole("button", { name: "Reset Shadows to" }).click());
  const again = await shown();
  expect(again === before, "With all links gone the picture must be what it was.");
  expect(lit !== dark, "The vase must be lit again.");
  await after(() => page.getByRole("button", { name: /^Undo/ }).click());
  const back = await after(() => page.getByRole("button", { name: /^Undo/ }).click());
  expect(back !== before, "Undo must bring the links back.");
  expect((await light()).lightLink.exclude.length === 1, "Undo must bring the vase back into its list.");
});
