// A scene that comes over HTTP: the page says what it is called and what of it is not drawn.

import { expect, reached, runBrowserTest, seqOf } from "./page.mjs";

const LIGHTS = "KHR_lights_punctual";
/** Longer than a line of the notes. */
const BULB = "bulb over the table by the window, as the director of photography asked for on the second day";
/** A triangle under a point light of less than no intensity, with an animation, which is not played. */
const SCENE = {
  asset: { version: "2.0" },
  scenes: [{ name: "Kitchen", nodes: [0, 1] }],
  nodes: [{ mesh: 0 }, { extensions: { [LIGHTS]: { light: 0 } } }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
  bufferViews: [{ buffer: 0, byteLength: 36 }],
  buffers: [{ byteLength: 36, uri: `data:application/octet-stream;base64,${triangle()}` }],
  animations: [{ channels: [], samplers: [] }],
  extensionsUsed: [LIGHTS],
  extensions: { [LIGHTS]: { lights: [{ type: "point", name: BULB, intensity: -1 }] } },
};

function triangle() {
  return Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer).toString("base64");
}

await runBrowserTest(async ({ open, picture }) => {
  const page = await open("Ada");
  const notes = page.getByRole("button", { name: "2 notes on the scene" });
  const list = page.getByRole("region", { name: "Notes on the scene" });
  expect((await notes.count()) === 0, "The demo has no notes.");

  await load(page, (await send(page, "?name=Grandma%E2%80%99s%20kitchen", SCENE)).asset);
  await page.getByText("Grandma’s kitchen", { exact: true }).waitFor();
  await notes.waitFor();
  await picture(page, "1-a-scene-with-notes");
  expect(!(await list.isVisible()), "The notes must wait until somebody asks for them.");
  await notes.focus();
  await page.keyboard.press("Enter");
  await list.waitFor();
  const said = await list.getByRole("listitem").allTextContents();
  expect(
    said.length === 2 && said.some((note) => note.includes("bulb")),
    `The notes must name what is not as in the file: ${said.join("; ")}`,
  );
  const cut = () =>
    list.evaluate(
      (list) => [list, ...list.querySelectorAll("li")].filter((e) => e.scrollWidth > e.clientWidth).length,
    );
  expect((await cut()) === 0, "Notes must break into lines that fit their list.");
  await list.evaluate((list) => (list.style.whiteSpace = "nowrap"));
  expect((await cut()) > 0, "A note that is cut off must be noticed.");
  await list.evaluate((list) => (list.style.whiteSpace = ""));
  await picture(page, "2-its-notes");
  await page.keyboard.press("Escape");
  await list.waitFor({ state: "hidden" });
  const focused = await notes.evaluate((button) => button === document.activeElement);
  expect(focused, "Escape must give the focus back to the button.");

  await page.reload();
  await notes.waitFor();
  await page.setViewportSize({ width: 900, height: 500 });
  await notes.click();
  await list.waitFor();
  await picture(page, "3-after-a-reload");
  await page.mouse.click(450, 300);
  await list.waitFor({ state: "hidden" });

  // Log entry of versions before names of scenes.
  await load(page, "demo:vases", `sha256:${"0123456789abcdef".repeat(4)}`);
  await page.getByText("scene 01234567", { exact: true }).waitFor();
  expect((await notes.count()) === 0, "The notes of a scene must go with it.");
  await picture(page, "4-a-scene-without-a-name");
});

/** Sends a scene's file; the answer. */
async function send(page, query, scene) {
  return (await post(page, `/assets${query}`, scene)).json();
}

/** Loads a scene into the page's session, and waits until the page knows. */
async function load(page, scene, name) {
  const seq = await seqOf(page);
  const { session } = addressOf(page);
  await post(page, `/sessions/${session}/edits`, {
    edits: [{ command: { type: "loadScene", scene, name } }],
  });
  await reached(page, seq + 1);
}

async function post(page, path, body) {
  const { origin, token } = addressOf(page);
  const headers = { authorization: `Bearer ${token}`, "content-type": "application/json" };
  const answer = await fetch(`${origin}${path}`, { method: "POST", headers, body: JSON.stringify(body) });
  expect(answer.ok, `${path} is refused: ${answer.status}`);
  return answer;
}

function addressOf(page) {
  const { origin, hash } = new URL(page.url());
  const named = new URLSearchParams(hash.slice(1));
  return { origin, token: named.get("token"), session: named.get("session") };
}
