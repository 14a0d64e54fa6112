// Long names in lists: they lose their middle, and say all of themselves to a pointer that rests on them and to who hears the page.

import { expect, reached, runBrowserTest, seqOf, settled } from "./page.mjs";

const LONG = "kitchen window key, warm, bounced off the fridge, for the second take of shot";
const [LIGHT, CAMERA, PERSON] = [`${LONG} 0010_a`, `${LONG} 0020_b`, `${LONG} 0030_c`];

await runBrowserTest(async ({ open, picture, http }) => {
  const set = (target, value) => ({ command: { type: "set", target, value } });
  const { document } = await (await http("")).json();
  const camera = document.cameras[0].id;
  await http("/edits", {
    edits: [set("/lights/key/name", LIGHT), set(`/cameras/${camera}/name`, CAMERA)],
  });
  for (const [width, height] of [
    [1280, 800],
    [820, 1180],
    [390, 844],
  ]) {
    const page = await open("Ada", { width, height });
    const other = await open(PERSON, { width: 1024, height: 640 });
    await page.getByRole("button", { name: `Follow ${PERSON}'s view` }).waitFor();
    await settled(page);
    for (const [where, name] of [
      [`[data-light]`, LIGHT],
      [`.item[data-camera]`, CAMERA],
      [`[data-person]`, PERSON],
    ]) {
      await isClippedInTheMiddle(page, where, name);
    }
    const heard = page.getByRole("button", { name: LIGHT, exact: true });
    expect((await heard.count()) === 1, "Who hears the page must hear a name in one piece.");
    await picture(page, `${width}x${height}`);
    await shortNamesAreWhole(page, http);
    await other.close();
    await page.close();
  }
});

async function isClippedInTheMiddle(page, where, name) {
  const shown = page.locator(`${where} .name`).first();
  const { start, end, title } = await shown.evaluate((element) => {
    const [start, end] = [".name-start", ".name-end"].map((part) => {
      const { scrollWidth, clientWidth, textContent } = element.querySelector(part);
      return { isCut: scrollWidth > clientWidth, textContent };
    });
    return { start, end, title: element.title };
  });
  expect(title.includes(name), `${where} must say all of its name to a pointer; it says: ${title}`);
  expect(start.isCut, `The middle of a name must give way in ${where}.`);
  expect(!end.isCut && name.endsWith(end.textContent), `The end of a name must stay in ${where}.`);
  expect(start.textContent + end.textContent === name, `Nothing else of the name may go in ${where}.`);
  // The planted fault: a name that keeps its width.
  await shown.evaluate((element) => {
    const wide = element.querySelector(".name-start");
    wide.style.overflow = "visible";
    wide.style.flex = "none";
  });
  const isCut = await shown
    .locator(".name-start")
    .evaluate(({ scrollWidth, clientWidth }) => scrollWidth > clientWidth);
  expect(!isCut, "A name that does not give way must be noticed.");
  await shown.locator(".name-start").evaluate((element) => element.removeAttribute("style"));
}

/** A name that has room is there as it is. */
async function shortNamesAreWhole(page, http) {
  const seq = await seqOf(page);
  const rename = (value) =>
    http("/edits", { edits: [{ command: { type: "set", target: "/lights/1/name", value } }] });
  await rename("rim");
  await reached(page, seq + 1);
  await page.getByRole("button", { name: "rim", exact: true }).waitFor();
  expect((await page.locator("[data-light] .name").count()) === 0, "A short name has no middle to lose.");
  await rename(LIGHT);
  await reached(page, seq + 2);
}
