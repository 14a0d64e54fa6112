// The states of the page that people seldom see, and that what would be wrong with them is found.

import { findings } from "./accessible.mjs";
import { expect, field, runBrowserTest, settled, startDragging } from "./page.mjs";

await runBrowserTest(async ({ open, visit, picture }) => {
  const sockets = [];
  let connected = true;
  const prepare = (page) =>
    page.routeWebSocket(/\/socket$/, (socket) => {
      if (!connected) return socket.close();
      socket.connectToServer();
      sockets.push(socket);
    });
  const ada = await open("Ada", { width: 1440, height: 860 }, { prepare });
  await plantedFaultsAreFound(ada);
  await picture(ada, "1-opened");
  await keys(ada, picture);
  await ada.getByRole("button", { name: "2", exact: true }).click();
  await picture(ada, "3-a-control-point");
  await held(ada, await open("Bob", { width: 1024, height: 640 }), picture);
  await refused(ada, picture);
  await ada.getByRole("button", { name: "Remove key" }).click();
  await ada.getByText("No lights.").waitFor();
  await settled(ada);
  await picture(ada, "9-no-lights");

  connected = false;
  for (const socket of sockets) await socket.close();
  await ada.getByText("Connection lost").waitFor();
  await picture(ada, "10-connection-lost");
  const turnedAway = await open("Cy", { width: 1280, height: 760 }, { prepare: turnAway, shows: refusal });
  const focused = await turnedAway.evaluate(() => document.activeElement.textContent);
  expect(focused === "Try again", `The dialog must have the focus; ${focused} has.`);
  await picture(turnedAway, "11-refused");
  const lost = await visit("");
  await lost.getByLabel("Token").waitFor();
  await picture(lost, "12-no-token");
});

/** In place of a server of a later version. */
function turnAway(page) {
  const message = "this server speaks protocol 2, not 1: reload the page, or use a client of that version";
  const answer = JSON.stringify({ type: "error", code: "protocol", message, fatal: true });
  return page.routeWebSocket(/\/socket$/, (socket) => socket.onMessage(() => socket.send(answer)));
}

function refusal(page) {
  return page.getByRole("alertdialog").waitFor();
}

/** A nameless button, and text that is too faint where axe-core decides and where it does not. */
async function plantedFaultsAreFound(page) {
  const before = await findings(page);
  expect(before.length === 0, `The page must be without fault as it opens: ${before.join("\n")}`);
  for (const [rule, tag, text] of [
    ["button-name at #planted", "button", ""],
    ["color-contrast at #planted", "p", "Select a control point."],
    ["color-contrast at #planted", "p", "x"],
  ]) {
    await page.locator(".right").evaluate(
      (panel, [tag, text]) => {
        const planted = Object.assign(document.createElement(tag), { id: "planted", textContent: text });
        planted.style.color = "#666666";
        panel.append(planted);
      },
      [tag, text],
    );
    const found = await findings(page);
    await page.locator("#planted").evaluate((planted) => planted.remove());
    expect(
      found.length === 1 && found[0].startsWith(rule),
      `A faint ${tag} with "${text}" must be found, and it alone: ${found.join("\n")}`,
    );
  }
}

async function keys(page, picture) {
  await page.locator(".stage").focus();
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keys" }).waitFor();
  await picture(page, "2-keys");
  await page.keyboard.press("Escape");
  await page.getByRole("dialog", { name: "Keys" }).waitFor({ state: "hidden" });
}

async function held(ada, bob, picture) {
  await startDragging(ada, "point-2", { x: 30, y: 20 });
  await bob.locator('.light[data-held="true"]').waitFor();
  await picture(ada, "4-a-drag");
  await picture(bob, "5-held-by-another");
  await ada.keyboard.press("Escape");
  await ada.mouse.up();
  await ada.getByRole("button", { name: "Follow Bob's view" }).click();
  await ada.getByText("Bob's view").waitFor();
  await settled(ada);
  await picture(ada, "6-following");
  await ada.locator(".banner").getByRole("button", { name: "Stop following" }).click();
  await ada.getByText("Bob's view").waitFor({ state: "hidden" });
  await settled(ada);
}

async function refused(page, picture) {
  await startDragging(page, "radius-2", { x: -400, y: 300 });
  await page.locator(".refused-drag").waitFor();
  await picture(page, "7-a-refused-drag");
  await page.keyboard.press("Escape");
  await page.mouse.up();
  await field(page, "Radius").fill("1000");
  await page.keyboard.press("Enter");
  await page.locator(".toast").waitFor();
  await page.getByRole("button", { name: "Change your name" }).click();
  await picture(page, "8-a-toast-and-a-new-name");
  await page.keyboard.press("Escape");
}
