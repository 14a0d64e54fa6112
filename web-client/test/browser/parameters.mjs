// The fields that follow from the table of parameters: defaults come back, what the page has never heard of is a field too,
// and where there is no table the page says so.

import { expect, field, reached, runBrowserTest, seqOf, settled, unfold } from "./page.mjs";

/** A parameter that no server has. */
const GAIN = {
  name: "gain",
  of: ["spot"],
  kind: {
    type: "number",
    unit: "dB",
    exclusiveMin: 0,
    slider: [0.01, 100],
    step: 0.1,
    scale: "logarithmic",
  },
  address: { spot: "/lights/ID/gain" },
  default: { spot: 10 },
  path: "filter/gain",
  touches: "radiance",
  animates: true,
  group: "Filter",
  label: "Gain",
  doc: "What only this test knows.",
};

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada", { width: 1440, height: 860 }, { prepare: tellOfGain });
  await resets(page, picture);
  await whatDoesNothingIsHidden(page, picture);
  await somethingUnheard(page, picture);
  await noTable(open, picture);
});

/** Adds a parameter to the table of the server. */
async function tellOfGain(page) {
  await page.route("**/parameters", async (route) => {
    const response = await route.fetch();
    const { parameters, ...more } = await response.json();
    await route.fulfill({ response, json: { ...more, parameters: [...parameters, GAIN] } });
  });
}

async function type(page, name, text) {
  const seq = await seqOf(page);
  await field(page, name).fill(text);
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
}

/** The button that puts a parameter back to its default. */
function resetOf(page, name) {
  return page.getByRole("button", { name: `Reset ${name} to` });
}

/** By the button, which keys reach, and by a double click on the label; each is a record. */
async function resets(page, picture) {
  const angle = field(page, "Cone angle");
  const said = await angle.getAttribute("title");
  expect(said !== null && said.length > 10, "A field must say what it sets.");
  const initial = await angle.inputValue();
  expect((await resetOf(page, "Cone angle").count()) === 0, "What is the default has nothing to go back to.");

  await type(page, "Cone angle", "40");
  await picture(page, "1-not-the-default");
  const seq = await seqOf(page);
  await resetOf(page, "Cone angle").focus();
  await page.keyboard.press("Enter");
  await reached(page, seq + 1);
  expect((await angle.inputValue()) === initial, "The button must bring the default back.");
  await resetOf(page, "Cone angle").waitFor({ state: "detached" });
  const focused = await page.evaluate(() => document.activeElement.getAttribute("aria-label"));
  expect(focused === "Cone angle slider", `The button's focus must go to its row; ${focused} has it.`);

  await type(page, "Cone angle", "50");
  await page.getByText("Cone angle", { exact: true }).dblclick();
  await reached(page, seq + 3);
  expect((await angle.inputValue()) === initial, "A double click on the label must bring the default back.");
  await page.getByText("Cone angle", { exact: true }).dblclick();
  await settled(page);
  expect((await seqOf(page)) === seq + 3, "A double click at the default must do nothing.");
}

/** Fields come with what they need, and go with it; a light of another shape has others. */
async function whatDoesNothingIsHidden(page, picture) {
  const kelvin = field(page, "Kelvin");
  const seq = await seqOf(page);
  const before = JSON.stringify(await page.locator("canvas").boundingBox());
  expect((await kelvin.count()) === 0, "Without a temperature there is none to set.");
  await page.getByRole("checkbox", { name: "Temperature" }).focus();
  await page.keyboard.press("Space");
  await reached(page, seq + 1);
  await kelvin.waitFor();
  const power = field(page, "Profile power");
  expect((await power.count()) === 0, "The smooth profile has no exponent.");
  await page.getByRole("combobox", { name: "Profile" }).selectOption("cosine");
  await reached(page, seq + 2);
  await power.waitFor();
  expect((await field(page, "Softness").count()) === 0, "A cosine begins at the axis: it has no softness.");
  await unfold(page, "Section");
  expect((await field(page, "Roundness").count()) === 0, "A circle has no roundness.");
  await page.getByRole("combobox", { name: "Outline" }).selectOption("superellipse");
  await reached(page, seq + 3);
  await field(page, "Roundness").waitFor();
  await picture(page, "1-what-does-something");
  for (let step = 0; step < 3; step += 1) await page.keyboard.press("Control+z");
  await reached(page, seq + 6);
  await kelvin.waitFor({ state: "detached" });
  await settled(page);
  const now = JSON.stringify(await page.locator("canvas").boundingBox());
  expect(now === before, `Fields that come and go must leave the picture at ${before}; it is at ${now}.`);
}

async function somethingUnheard(page, picture) {
  const seq = await seqOf(page);
  expect((await field(page, "Gain").count()) === 0, "A spotlight's parameter is none of another light.");
  await page.getByRole("button", { name: "Add a spotlight" }).click();
  await reached(page, seq + 1);
  const filter = page.getByRole("region", { name: "Filter" });
  await filter.waitFor();
  await unfold(page, "Filter");
  expect((await field(filter, "Gain").inputValue()) === "10", "What a light leaves out is the default.");
  const slider = filter.getByRole("slider", { name: "Gain slider" });
  const [place, least, most] = await slider.evaluate(({ value, min, max }) => [value, min, max].map(Number));
  // Ten is three quarters of the way from a hundredth to a hundred, but for the slider's step, a thousandth.
  const share = (place - least) / (most - least);
  expect(Math.abs(share - 0.75) < 0.001, `Equal ways must be equal factors; 10 is at ${share}.`);
  await settled(page);
  await picture(page, "2-a-parameter-never-heard-of");

  await field(filter, "Gain").fill("20");
  await page.keyboard.press("Enter");
  await page.locator(".toast").waitFor();
  expect((await seqOf(page)) === seq + 1, "What the server refuses must not be in the log.");
}

/** Without its table the page says why, and opens once there is one. */
async function noTable(open, picture) {
  const answers = {
    "does not answer": (route) => route.abort(),
    "an older one": (route) => route.fulfill({ status: 404, json: { error: { message: "no such route" } } }),
  };
  for (const [k, [sentence, answer]] of Object.entries(answers).entries()) {
    const dialog = (page) => page.getByRole("alertdialog").getByText(sentence).waitFor();
    const prepare = (page) => page.route("**/parameters", answer);
    const page = await open(`Bob ${k}`, { width: 1024, height: 640 }, { prepare, shows: dialog });
    await picture(page, `3-no-table-${k}`);
    // The dialog that goes has the same sentence: the table is asked for once more before there is one.
    const isTable = (request) => request.url().endsWith("/parameters");
    const refused = ["requestfailed", "requestfinished"].map((event) => page.waitForEvent(event, isTable));
    await page.keyboard.press("Enter");
    await Promise.any(refused);
    await dialog(page);
    await page.unroute("**/parameters");
    await page.getByRole("button", { name: "Try again" }).click();
    await settled(page);
  }
}
