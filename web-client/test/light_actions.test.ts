import { expect, test } from "vitest";

import type { Camera, Command, Light } from "../src/core/protocol";
import type { Vec3 } from "../src/core/vector";
import { bendLight } from "../src/ui/light_actions";
import type { Page } from "../src/ui/page";
import { CAMERA, DIRECTIONAL, DOCUMENT, OMNI, SPOT, WELCOME } from "./examples";
import { fakeHost, sessionOn } from "./fake_host";

/** Command of the page that bends `light`, and the cameras that it probed: `seen` is in the middle of the view. */
async function bent(light: Light, seen: Vec3 | null): Promise<{ command: Command; asked: Camera[] }> {
  const host = fakeHost();
  const session = sessionOn(host);
  host.socket().events.open();
  const state = { snapshot: { ...DOCUMENT, lights: [{ id: 1, layout: 1, light }] } };
  host.socket().receive({ type: "welcome", ...WELCOME, state });
  const asked: Camera[] = [];
  const pick = (camera: Camera) => {
    asked.push(camera);
    return Promise.resolve(seen);
  };
  await bendLight({ session, pick } as unknown as Page, 1);
  const edit = host.socket().sent.find((message) => message.type === "edit");
  if (edit === undefined) throw new Error("nothing was asked for");
  return { command: edit.command, asked };
}

test("a light without a cone is bent towards what is in the middle of one's own view", async () => {
  for (const light of [OMNI, DIRECTIONAL]) {
    const { command, asked } = await bent(light, [1, 0.5, -2]);
    expect(command).toEqual({ type: "bendLight", light: 1, toward: [1, 0.5, -2] });
    expect(asked.map(({ translation }) => translation)).toEqual([CAMERA.translation]);
  }
});

test("where nothing is seen the server chooses", async () => {
  expect((await bent(OMNI, null)).command).toEqual({ type: "bendLight", light: 1 });
});

test("a spotlight is bent the way it shines, and nothing is looked at", async () => {
  const { command, asked } = await bent(SPOT, [1, 0.5, -2]);
  expect(command).toEqual({ type: "bendLight", light: 1 });
  expect(asked).toEqual([]);
});
