// The front page: sessions with their pictures, made, named, copied, archived, brought back and deleted, by mouse and by
// keys; a link to one opens it, and a link to none leads here.

import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { expect, runBrowserTest, settled } from "./page.mjs";

const ROOM = JSON.stringify({ asset: { version: "2.0" }, nodes: [{ name: "wall" }] });

const ADDRESS = new URL(process.argv[2]);
const TOKEN = new URLSearchParams(ADDRESS.hash.slice(1)).get("token");
const SCREENS = [
  { width: 1280, height: 800 },
  { width: 820, height: 1180 },
  { width: 390, height: 844 },
];
/** Number of shots of a studio's show, roughly. */
const MANY = 100;

const api = async (method, path, body) => {
  const headers = { authorization: `Bearer ${TOKEN}`, "content-type": "application/json" };
  const request = { method, headers, ...(body === undefined ? {} : { body: JSON.stringify(body) }) };
  const answer = await fetch(`${ADDRESS.origin}${path}`, request);
  expect(answer.ok, `${method} ${path} must be done: ${answer.status} ${await answer.clone().text()}`);
  return answer;
};
const named = async (title) => {
  const { sessions } = await (await api("GET", "/sessions?archived=true")).json();
  return sessions.find((session) => session.title === title);
};
const card = (page, title) =>
  page.locator(".card", { has: page.locator(`.card-link[aria-label^="${title},"]`) });
const link = (page, title) => card(page, title).locator(".card-link");
const focusedTitle = (page) =>
  page.evaluate(() => document.activeElement.getAttribute("aria-label")?.split(",")[0] ?? "");
const hash = (page) => decodeURIComponent(new URL(page.url()).hash);

await runBrowserTest(async ({ open, visit, picture }) => {
  const page = await visit(`#token=${TOKEN}`);
  await page.getByRole("heading", { name: "Sessions" }).waitFor();
  await byMouse(page, picture);
  await byKeys(page, picture);
  await backAndForth(page);
  await aSceneOfOnesOwn(page, picture);
  await nowhere(visit, picture);
  await whoIsThere(open, page, picture);
  await aStrangersLink(visit, page);
  await picturesComeOnce(page);
  await everyScreen(page, picture);
  await many(visit, picture);
});

/** Makes a session of a demo, goes back, renames, duplicates and archives it, brings it back, archives and deletes a copy. */
async function byMouse(page, picture) {
  await page.getByRole("button", { name: "New session" }).click();
  const dialog = page.getByRole("dialog", { name: "New session" });
  await dialog.getByLabel("Name").fill("Night 010");
  await dialog.getByRole("radio", { name: "arbor" }).check();
  await picture(page, "1-a-new-one");
  await dialog.getByRole("button", { name: "Create" }).click();
  await settled(page);
  expect(hash(page).includes("session=night-010"), `The address must name it: ${hash(page)}`);
  expect((await page.locator(".session-name").textContent()) === "Night 010", "The page says its title.");
  await page.getByRole("link", { name: "All sessions" }).click();
  await link(page, "Night 010").waitFor();
  expect(
    (await named("Night 010")).changed.actor.startsWith("Guest"),
    "Who made it is who loaded its scene.",
  );
  await card(page, "Night 010").locator("[data-picture=shown]").waitFor();
  await picture(page, "2-the-list");

  await card(page, "Night 010").hover();
  await page.getByRole("button", { name: "Rename Night 010" }).click();
  await page.getByRole("textbox", { name: "New name of" }).fill("Shot 010");
  await page.keyboard.press("Enter");
  await link(page, "Shot 010").waitFor();
  expect((await named("Shot 010")).name === "night-010", "Its address stays.");

  await card(page, "Shot 010").hover();
  await page.getByRole("button", { name: "Duplicate Shot 010" }).click();
  await link(page, "Shot 010 copy").waitFor();
  expect((await named("Shot 010 copy")).seq === (await named("Shot 010")).seq, "A copy has the whole log.");

  await card(page, "Shot 010 copy").hover();
  await page.getByRole("button", { name: "Archive Shot 010 copy" }).click();
  await link(page, "Shot 010 copy").waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Archived (1)" }).click();
  await card(page, "Shot 010 copy").hover();
  await page.getByRole("button", { name: "Bring back Shot 010 copy" }).click();
  await page.getByRole("button", { name: "Archived (1)" }).waitFor({ state: "detached" });
  expect(!(await named("Shot 010 copy")).archived, "It is back.");

  await card(page, "Shot 010 copy").hover();
  await page.getByRole("button", { name: "Archive Shot 010 copy" }).click();
  await page.getByRole("button", { name: "Archived (1)" }).waitFor();
  await card(page, "Shot 010 copy").hover();
  await page.getByRole("button", { name: "Delete Shot 010 copy" }).click();
  const asked = page.getByRole("dialog", { name: "Delete “Shot 010 copy”?" });
  await picture(page, "3-asked-again");
  await asked.getByRole("button", { name: "Keep it" }).click();
  expect((await named("Shot 010 copy")) !== undefined, "What is kept is there.");
  await card(page, "Shot 010 copy").hover();
  await page.getByRole("button", { name: "Delete Shot 010 copy" }).click();
  await asked.getByRole("button", { name: "Delete", exact: true }).click();
  await page.getByText("“Shot 010 copy” is deleted.").waitFor();
  expect((await named("Shot 010 copy")) === undefined, "What is deleted is gone.");
}

/** Files are picked in the dialog: what is no scene is refused in a sentence, a scene becomes a session of the typed name. */
async function aSceneOfOnesOwn(page, picture) {
  const folder = mkdtempSync(join(tmpdir(), "scenes-"));
  const file = (name, text) => {
    writeFileSync(join(folder, name), text);
    return join(folder, name);
  };
  const pick = async (file) => {
    await page.getByRole("button", { name: "New session" }).click();
    const dialog = page.getByRole("dialog", { name: "New session" });
    await dialog.getByLabel("Name").fill("My room");
    const [chooser] = await Promise.all([
      page.waitForEvent("filechooser"),
      dialog.getByRole("button", { name: "Pick files" }).click(),
    ]);
    await chooser.setFiles([file]);
    await dialog.waitFor({ state: "hidden" });
  };
  try {
    await pick(file("broken.gltf", "{}"));
    const panel = page.getByRole("region", { name: "A scene on its way" });
    await panel.getByRole("alert").waitFor();
    await picture(page, "4-no-scene");
    await panel.getByRole("button", { name: "Close" }).click();
    const isBack = await page.evaluate(() => document.activeElement.textContent.includes("New session"));
    expect(isBack, "Closing must give the focus back to what makes sessions.");
    expect((await named("My room")) === undefined, "What is no scene makes no session.");
    await dropUnderATitle(page);
    await pick(file("room.gltf", ROOM));
    await settled(page);
    expect(hash(page).includes("session=my-room"), `The address must name it: ${hash(page)}`);
    await page.locator(".scene-name", { hasText: "room" }).waitFor();
  } finally {
    rmSync(folder, { recursive: true });
  }
  await page.goBack();
  await link(page, "My room").waitFor();
}

/** A file is dropped while the dialog is open: its session has the typed name. */
async function dropUnderATitle(page) {
  await page.getByRole("button", { name: "New session" }).click();
  const dialog = page.getByRole("dialog", { name: "New session" });
  await dialog.getByLabel("Name").fill("Dropped here");
  await page.evaluate((text) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([text], "wall.gltf"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
  }, ROOM);
  await settled(page);
  expect(hash(page).includes("session=dropped-here"), `The address must name it: ${hash(page)}`);
  await page.goBack();
  await link(page, "Dropped here").waitFor();
}

/** The same by keys alone. */
async function byKeys(page, picture) {
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keys" }).waitFor();
  await picture(page, "4-keys");
  await page.keyboard.press("Escape");
  await page.keyboard.press("n");
  const dialog = page.getByRole("dialog", { name: "New session" });
  await dialog.waitFor();
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await settled(page);
  expect(/session=untitled/.test(hash(page)), `What nobody has named is untitled: ${hash(page)}`);
  await page.goBack();
  await link(page, "Untitled").waitFor();

  await page.keyboard.press("ArrowRight");
  const first = await focusedTitle(page);
  expect(first === "Untitled", `The latest is first: ${first}`);
  await page.keyboard.press("ArrowRight");
  const second = await focusedTitle(page);
  await page.keyboard.press("End");
  const last = await focusedTitle(page);
  await page.keyboard.press("Home");
  expect(new Set([first, second, last]).size === 3, `Arrows and End go on: ${first}, ${second}, ${last}`);
  expect((await focusedTitle(page)) === first, "Home goes back.");
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press("Tab");
  expect((await focusedTitle(page)) === first, "Tab comes to it too.");

  await page.keyboard.press("F2");
  await page.keyboard.type("By keys");
  await page.keyboard.press("Escape");
  expect((await named("Untitled")) !== undefined, "Escape leaves a name as it was.");
  await page.keyboard.press("F2");
  await page.keyboard.type("By ");
  await page.waitForResponse((answer) => new URL(answer.url()).pathname === "/sessions");
  await page.keyboard.type("keys");
  await page.keyboard.press("Enter");
  await link(page, "By keys").waitFor();
  await page.waitForFunction(() => document.activeElement.getAttribute("aria-label")?.startsWith("By keys,"));
  await page.keyboard.press("d");
  await link(page, "By keys copy").waitFor();
  await page.waitForFunction(() =>
    document.activeElement.getAttribute("aria-label")?.startsWith("By keys copy,"),
  );
  await page.keyboard.press("Delete");
  await link(page, "By keys copy").waitFor({ state: "detached" });
  const next = await focusedTitle(page);
  expect(next !== "" && next !== "By keys copy", `The focus is on another card: “${next}”`);
  await page.getByRole("button", { name: "Archived (1)" }).focus();
  await page.keyboard.press("Enter");
  await link(page, "By keys copy").focus();
  await page.keyboard.press("Delete");
  await page.getByRole("dialog", { name: "Delete “By keys copy”?" }).waitFor();
  const kept = await page.evaluate(() => document.activeElement.textContent);
  expect(kept === "Keep it", `What loses nothing has the focus: ${kept}`);
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await page.getByText("“By keys copy” is deleted.").waitFor();
  await link(page, "By keys").focus();
  await page.keyboard.press("Enter");
  await settled(page);
}

/** The fragment is the state: back leads to the list, forward to the session. */
async function backAndForth(page) {
  await page.goBack();
  await link(page, "By keys").waitFor();
  await page.goForward();
  await settled(page);
  await page.goBack();
  await link(page, "By keys").waitFor();
}

/** A link to a session that is not there says so, over the list. */
async function nowhere(visit, picture) {
  const lost = await visit(`#token=${TOKEN}&session=nope`);
  await lost.getByRole("alert").getByText("There is no session called “nope” here").waitFor();
  await link(lost, "By keys").waitFor();
  await picture(lost, "5-nope");
  await lost.close();
  const started = await visit(`#token=${TOKEN}`);
  await link(started, "By keys").waitFor();
  expect((await started.getByRole("alert").count()) === 0, "Where no session is named none is missing.");
  await started.close();
}

/** Names of people in a session are on its card, soon after they come and go; nobody deletes it under them. */
async function whoIsThere(open, page, picture) {
  const ada = await open("Ada Lovelace");
  const { session } = Object.fromEntries(new URLSearchParams(new URL(ada.url()).hash.slice(1)));
  const people = page.locator(`[data-session="${session}"] .card-people`);
  await people.getByText("Ada Lovelace").waitFor();
  await picture(page, "6-who-is-there");
  await api("PATCH", `/sessions/${session}`, { title: "Ada's shot" });
  await ada.locator(".session-name").getByText("Ada's shot").waitFor();
  await api("PATCH", `/sessions/${session}`, { archived: true });
  await ada.getByText("Archived", { exact: true }).waitFor();
  await page.getByRole("button", { name: "Archived (1)" }).waitFor();
  if ((await page.getByRole("button", { name: "Archived" }).getAttribute("aria-expanded")) === "false")
    await page.getByRole("button", { name: "Archived" }).click();
  await page.locator(`[data-session="${session}"] .card-link`).focus();
  await page.keyboard.press("Delete");
  await page.getByRole("dialog").getByRole("button", { name: "Delete", exact: true }).click();
  await page.getByText("Ada Lovelace is in session").waitFor();
  await ada.reload();
  await settled(ada);
  await ada.context().close();
  await people.waitFor({ state: "detached" });
  await api("PATCH", `/sessions/${session}`, { archived: false, title: session });
}

/** A card's link, given to somebody else, opens that session and no other. */
async function aStrangersLink(visit, page) {
  const href = await link(page, "Shot 010").getAttribute("href");
  const visitor = await visit(href);
  await settled(visitor);
  expect((await visitor.locator(".session-name").textContent()) === "Shot 010", "It is the one of the link.");
  await visitor.close();
}

/** The browser keeps pictures, and the server draws none twice. */
async function picturesComeOnce(page) {
  const count = async (status) => {
    const text = await (await api("GET", "/metrics")).text();
    const line = `bendylights_requests_total{method="GET",route="/sessions/{name}/render",status="${status}"} `;
    return Number(
      text
        .split("\n")
        .find((one) => one.startsWith(line))
        ?.slice(line.length) ?? 0,
    );
  };
  const shown = async () => {
    await card(page, "Shot 010").locator("[data-picture=shown]").waitFor();
    await page.waitForLoadState("networkidle");
  };
  await shown();
  const [drawn, known] = [await count(200), await count(304)];
  expect(drawn > 0, "Pictures are drawn at first.");
  await page.reload();
  await shown();
  expect((await count(200)) === drawn, "Nothing is drawn for a list that comes again.");
  expect((await count(304)) > known, "The browser asks whether what it has is still right.");
}

async function everyScreen(page, picture) {
  const long = "sequence-12-interior-night-the-long-corridor-shot-0450-lighting-v3";
  await api("PATCH", `/sessions/${(await named("By keys")).name}`, { title: long });
  for (const screen of SCREENS) {
    await page.setViewportSize(screen);
    await page.reload();
    await card(page, "Shot 010").locator("[data-picture=shown]").waitFor();
    const end = page.getByText("ighting-v3", { exact: true });
    const [ends, around] = [await end.boundingBox(), await card(page, long).boundingBox()];
    expect(ends.x + ends.width <= around.x + around.width, "The end of a long name stays in sight.");
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    expect(width <= screen.width, `Nothing is cut off at ${screen.width} pixels: ${width}`);
    await picture(page, `6-at-${screen.width}`);
  }
}

/** A hundred are listed at once; pictures are drawn of those in sight alone. */
async function many(visit, picture) {
  for (let number = 1; number <= MANY; number += 1) {
    const name = `many-${String(number).padStart(3, "0")}`;
    await api("POST", "/sessions", { name, scene: "demo:vases" });
  }
  const page = await visit(`#token=${TOKEN}`);
  const asked = new Set();
  page.on("request", (request) => {
    const path = new URL(request.url()).pathname;
    if (path.endsWith("/render")) asked.add(path);
  });
  await page.locator(".card").nth(MANY).waitFor();
  await page.locator("[data-picture=shown]").nth(3).waitFor();
  await page.waitForLoadState("networkidle");
  const inSight = await page.evaluate(
    () =>
      [...document.querySelectorAll(".card")].filter((one) => one.getBoundingClientRect().top < innerHeight)
        .length,
  );
  expect(
    asked.size > 0 && asked.size <= inSight && inSight < MANY / 2,
    `Pictures of cards in sight alone are drawn: ${asked.size} of ${inSight}`,
  );
  await picture(page, "7-many");
  await page.getByLabel("Find sessions").fill("many-07");
  await page.waitForFunction(() => document.querySelectorAll(".card").length === 10);
  await page.getByLabel("Find sessions").fill("no such");
  await page.getByText("No session has “no such” in its name.").waitFor();
}
