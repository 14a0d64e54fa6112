// Links of a light: nodes that it lights and that throw shadows in it, chosen in a tree, typed, picked in the picture, removed, undone.

import { expect, pixels, reached, runBrowserTest, seqOf, settled, unfold } from "./page.mjs";

/** Names of nodes as in a production: 200 of them, four levels deep, with long names. */
const SHELVES = 20;
const THINGS = 10;
const LONG = "env_kitchen_setdress_shelf_upper_left_a_v012_final";

/** Visible points of the demo, as shares of the picture. */
const TABLE = { x: 0.5, y: 0.85 };

await runBrowserTest(async ({ open, picture, http, send }) => {
  const page = await open("Ada", { width: 1440, height: 860 });
  await nodesAreChosen(page, picture, http);
  await objectsArePicked(page, picture, http);
  await keysDoAll(page, http);
  const { asset } = await send("/assets?name=production", production());
  await http("/edits", { edits: [{ command: { type: "loadScene", scene: asset } }] });
  await page.close();
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    await longNamesStayInside(open, picture, { width, height });
  }
});

function linksOf(page) {
  return page.getByRole("region", { name: "Links" });
}
async function lightOf(http) {
  return (await (await http("")).json()).document.lights[0].light;
}
function node(page, name) {
  return linksOf(page).getByRole("treeitem", { name });
}
function button(page, name) {
  return linksOf(page).getByRole("button", { name, exact: true });
}

/** Waits for the record that `step` makes, and gives the picture after it. */
async function after(page, step) {
  const seq = await seqOf(page);
  await step();
  await reached(page, seq + 1);
  await settled(page);
  return pixels(page);
}

async function nodesAreChosen(page, picture, http) {
  await unfold(page, "Links");
  const links = linksOf(page);
  await settled(page);
  const before = await pixels(page);

  await button(page, "Lights: choose nodes").click();
  for (const name of ["table", "blue vase", "orange vase"]) await node(page, name).waitFor();
  await links.getByRole("group", { name: "Lights: what is chosen next" }).getByText("Not").click();
  const dark = await after(page, () => node(page, "blue vase").click());
  expect(dark !== before, "A vase that is not lit must look otherwise.");
  const { exclude } = (await lightOf(http)).lightLink;
  expect(String(exclude) === "blue vase", `The light must not light the vase; it leaves out ${exclude}.`);
  const chosen = await node(page, /blue vase.*Not/).getAttribute("aria-selected");
  expect(chosen === "true", "The tree must say what is chosen.");

  // A path that names nothing is refused in its field, and the shot stays as bright as it was.
  const seq = await seqOf(page);
  const find = links.getByRole("searchbox", { name: "Lights: find nodes" });
  await find.fill("attic/chair");
  await links.getByText("No node is called so.").waitFor();
  await page.keyboard.press("Enter");
  await links.getByText("“attic/chair” names nothing in this scene").waitFor();
  await page.keyboard.press("Escape");
  await find.fill("VASE");
  await node(page, "table").waitFor({ state: "hidden" });
  await find.fill("");
  await settled(page);
  expect((await seqOf(page)) === seq && (await pixels(page)) === dark, "To look for nodes changes nothing.");

  // A program, or a scene from before, may have one all the same.
  await after(page, () => {
    const value = { include: ["attic/chair"] };
    return http("/edits", {
      actor: { id: "test-Ada", name: "Ada" },
      edits: [{ command: { type: "set", target: "/lights/key/shadowLink", value } }],
    });
  });
  const missing = links.locator('[data-missing="true"]');
  expect((await missing.count()) === 1, "A path that names nothing here must be marked, and no other.");
  const said = await missing.locator("[title]").first().getAttribute("title");
  expect(said.includes("no effect"), `It must say so; it says: ${said}`);
  await links.scrollIntoViewIfNeeded();
  await picture(page, "1-links");

  const lit = await after(page, () => button(page, "Take blue vase out of Lights: not").click());
  expect((await lightOf(http)).lightLink === undefined, "Without paths all nodes count.");
  await after(page, () => page.getByRole("button", { name: "Reset Shadows to" }).click());
  await settled(page);
  expect((await pixels(page)) === before, "With all links gone the picture must be what it was.");
  expect(lit !== dark, "The vase must be lit again.");
  await after(page, () => page.getByRole("button", { name: /^Undo/ }).click());
  const back = await after(page, () => page.getByRole("button", { name: /^Undo/ }).click());
  expect(back !== before, "Undo must bring the links back.");
  expect(
    (await lightOf(http)).lightLink.exclude.length === 1,
    "Undo must bring the vase back into its list.",
  );
  await after(page, () => node(page, /blue vase.*Not/).click());
}

async function objectsArePicked(page, picture, http) {
  const box = await page.locator("canvas").boundingBox();
  const click = ({ x, y }) => page.mouse.click(box.x + x * box.width, box.y + y * box.height);
  const pick = button(page, "Lights: pick in the picture");
  await pick.click();
  await page.getByText("“key” does not light what you pick").waitFor();
  const rectangle = await page.locator("canvas").boundingBox();
  expect(JSON.stringify(rectangle) === JSON.stringify(box), "Picking must leave the picture where it is.");
  await after(page, () => click(TABLE));
  const [path] = (await lightOf(http)).lightLink.exclude;
  await page.getByText(`Added: “key” does not light “${path}”`).waitFor();
  await picture(page, "2-picked");
  // The planted fault: what is there is not added again, and says so.
  const seq = await seqOf(page);
  await click(TABLE);
  await page.getByText(`“${path}” is there already`).waitFor();
  await page.keyboard.press("Escape");
  await page.getByText("is there already").waitFor({ state: "hidden" });
  expect((await pick.getAttribute("aria-pressed")) === "false", "Escape must end it.");
  await click(TABLE);
  await settled(page);
  expect((await seqOf(page)) === seq, "After that a click links nothing.");
  await after(page, () => page.keyboard.press("Control+z"));
}

/** Without a pointer: the tree, and the middle of the picture. */
async function keysDoAll(page, http) {
  await linksOf(page).getByRole("searchbox", { name: "Lights: find nodes" }).focus();
  await page.keyboard.press("ArrowDown");
  await page.waitForFunction(() => document.activeElement.getAttribute("role") === "treeitem");
  await page.keyboard.press("End");
  await page.waitForFunction(() => {
    const rows = document.querySelectorAll("[role=treeitem]");
    return document.activeElement === rows[rows.length - 1];
  });
  const name = await page.evaluate(() => document.activeElement.dataset.path);
  await after(page, () => page.keyboard.press("Enter"));
  expect(String((await lightOf(http)).lightLink.exclude) === name, `${name} must be left out.`);
  await after(page, () => page.keyboard.press("Space"));
  expect((await lightOf(http)).lightLink === undefined, "Once more takes it out again.");
  await button(page, "Lights: pick in the picture").focus();
  await page.keyboard.press("Enter");
  await after(page, () => page.keyboard.press("Enter"));
  expect((await lightOf(http)).lightLink.exclude.length === 1, "Enter must take the middle of the picture.");
  await page.keyboard.press("Escape");
  await after(page, () => page.keyboard.press("Control+z"));
}

/** A .gltf of long names, each thing a triangle. */
function production() {
  const nodes = [{ name: `${LONG}_root`, children: [] }];
  for (let shelf = 0; shelf < SHELVES; shelf += 1) {
    const children = [];
    nodes[0].children.push(nodes.push({ name: `${LONG}_${shelf}`, children }) - 1);
    for (let thing = 0; thing < THINGS; thing += 1) {
      children.push(nodes.push({ name: `${LONG}_${shelf}_${thing}`, mesh: 0 }) - 1);
    }
  }
  const triangle = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer).toString("base64");
  return {
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes,
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
    ],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    buffers: [{ byteLength: 36, uri: `data:;base64,${triangle}` }],
  };
}

async function longNamesStayInside(open, picture, size) {
  const name = `${size.width}x${size.height}`;
  const page = await open(`Bob ${name}`, size);
  await unfold(page, "Links");
  const widths = () =>
    page.evaluate(() => {
      const { clientWidth, scrollWidth } = document.querySelector(".right");
      return { clientWidth, scrollWidth };
    });
  const before = await widths();
  await button(page, "Shadows: choose nodes").click();
  // One root: what is under it shows.
  const shelf = linksOf(page).getByRole("treeitem").nth(3);
  await shelf.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await after(page, () => page.keyboard.press("Enter"));
  const path = await page.evaluate(() => document.activeElement.dataset.path);
  expect(path.endsWith("_2_0"), `The key must have gone to the first thing on the shelf, not to ${path}.`);
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => document.activeElement.getAttribute("aria-level") === "2");
  const now = await widths();
  expect(
    JSON.stringify(now) === JSON.stringify(before) && now.scrollWidth <= now.clientWidth,
    `Long names must not make the panel wider: ${JSON.stringify(now)}, before ${JSON.stringify(before)}.`,
  );
  const chip = linksOf(page).locator(".path .name");
  const title = await chip.getAttribute("title");
  expect(title === path, `What is clipped must say all of itself, ${path}; it says ${title}.`);
  const end = await chip.locator(".name-end").evaluate(({ scrollWidth, clientWidth, textContent }) => ({
    isWhole: scrollWidth <= clientWidth,
    textContent,
  }));
  expect(end.isWhole && path.endsWith(end.textContent), "The end of a name must stay.");
  await linksOf(page).scrollIntoViewIfNeeded();
  await linksOf(page).getByRole("tree").scrollIntoViewIfNeeded();
  await picture(page, `3-long-names-${name}`);
  // The planted fault: names that do not give way.
  await page.evaluate(() => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(".links { grid-template-columns: auto } .name { flex: none; overflow: visible }");
    document.adoptedStyleSheets = [sheet];
  });
  const wide = await widths();
  expect(wide.scrollWidth > wide.clientWidth, "A panel that becomes wider must be noticed.");
  await after(page, () => page.keyboard.press("Control+z"));
  await page.close();
}
