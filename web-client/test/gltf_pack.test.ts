import { expect, test } from "vitest";

import { type Given, pack, type Packed, sceneAmong, sceneNameOf } from "../src/core/gltf_pack";

const given = (path: string, text = ""): Given<Blob> => ({ path, file: new Blob([text]) });

interface Glb {
  json: {
    buffers: { byteLength: number; uri?: string }[];
    bufferViews: { buffer: number; byteOffset?: number; byteLength: number; extensions?: object }[];
    images: { uri?: string; bufferView?: number; mimeType?: string; name?: string }[];
  };
  bin: Uint8Array;
}

/** Reads a GLB as glTF 2.0, section 4.4 has it. */
async function read(packed: Packed<Blob>): Promise<Glb> {
  if ("why" in packed) throw new Error(packed.why);
  const bytes = new DataView(await new Blob(packed.parts).arrayBuffer());
  const word = (at: number) => bytes.getUint32(at, true);
  expect([word(0), word(4), word(8)]).toEqual([0x46546c67, 2, bytes.byteLength]);
  const length = word(12);
  expect([length % 4, word(16), word(24 + length)]).toEqual([0, 0x4e4f534a, 0x004e4942]);
  const text = new TextDecoder().decode(new Uint8Array(bytes.buffer, 20, length));
  const bin = new Uint8Array(bytes.buffer, 28 + length);
  expect(word(20 + length)).toBe(bin.length);
  return { json: JSON.parse(text) as Glb["json"], bin };
}

/** The text that a view shows. */
function shown({ json, bin }: Glb, view: number): string {
  const { buffer, byteOffset = 0, byteLength } = json.bufferViews[view] ?? { buffer: -1, byteLength: 0 };
  expect(buffer).toBe(0);
  return new TextDecoder().decode(bin.slice(byteOffset, byteOffset + byteLength));
}

const SCENE = {
  asset: { version: "2.0" },
  buffers: [
    { byteLength: 2, uri: "data:;base64,aGk=" },
    { byteLength: 5, uri: "geo%20metry.bin" },
    { byteLength: 3, uri: "./parts/B.bin" },
  ],
  bufferViews: [
    { buffer: 0, byteLength: 2 },
    { buffer: 1, byteOffset: 1, byteLength: 4 },
    { buffer: 2, byteLength: 3, extensions: { EXT_meshopt_compression: { buffer: 2, byteOffset: 1 } } },
  ],
  images: [
    { uri: "textures\\Küche.JPG", name: "café ☕" },
    { uri: "data:image/png;base64,aGk=" },
    { bufferView: 1, mimeType: "image/png" },
    { uri: "textures/K%C3%BCche.JPG" },
  ],
};

const FILES = [
  given("room/geo metry.bin", "0abcd"),
  given("room/Parts/b.bin", "xyz"),
  // Spelling of an umlaut by some systems.
  given("room/textures/Ku\u0308che.JPG", "picture"),
  given("elsewhere/b.bin", "no"),
];

test("a .gltf and its files become one file, and data stays where it is", async () => {
  const glb = await read(pack(given("room/scene.gltf"), JSON.stringify(SCENE), FILES));
  const { buffers, bufferViews, images } = glb.json;
  expect(buffers).toEqual([{ byteLength: glb.bin.length }, SCENE.buffers[0]]);
  expect(bufferViews[0]).toEqual({ buffer: 1, byteOffset: 0, byteLength: 2 });
  expect([shown(glb, 1), shown(glb, 2)]).toEqual(["abcd", "xyz"]);
  expect(bufferViews[2]?.extensions).toEqual({ EXT_meshopt_compression: { buffer: 0, byteOffset: 9 } });
  expect(images[0]).toEqual({ bufferView: 3, mimeType: "image/jpeg", name: "café ☕" });
  expect(shown(glb, 3)).toBe("picture");
  expect(images.slice(1, 3)).toEqual(SCENE.images.slice(1, 3));
  // The same picture twice is there once.
  expect(glb.json.bufferViews[4]?.byteOffset).toBe(glb.json.bufferViews[3]?.byteOffset);
  expect(glb.bin.length).toBe(8 + 4 + 8);
});

test("what is missing is named, and what is cut off", () => {
  const scene = given("room/scene.gltf");
  const some = pack(scene, JSON.stringify(SCENE), FILES.slice(0, 1));
  expect(some).toEqual({
    why: "“scene.gltf” needs files that did not come with it: ./parts/B.bin, textures\\Küche.JPG, textures/Küche.JPG. Drop its folder, or pick it together with them.",
  });
  const many = { buffers: [1, 2, 3, 4, 5].map((k) => ({ byteLength: 1, uri: `../../${k}.bin` })) };
  expect(pack(scene, JSON.stringify(many), [given("1.bin", "1")])).toHaveProperty(
    "why",
    expect.stringContaining("../../3.bin and 2 more"),
  );
  const short = pack(scene, JSON.stringify(SCENE), [given("room/geo metry.bin", "0"), ...FILES.slice(1)]);
  expect(short).toHaveProperty("why", expect.stringContaining("has 1 bytes of the 5"));
});

test("a folder beside the scene's is found, and a percent sign in a name", async () => {
  const scene = { buffers: [{ byteLength: 1, uri: "../data/50%.bin" }] };
  const { bin } = await read(
    pack(given("room/scene/a.gltf"), JSON.stringify(scene), [given("room/data/50%.bin", "x")]),
  );
  expect(bin[0]).toBe("x".charCodeAt(0));
});

test("what needs no other file is sent as it is, also where it is no glTF", () => {
  const scene = given("a.gltf", "{}");
  const alone = JSON.stringify({ buffers: SCENE.buffers.slice(0, 1), images: "none" });
  for (const text of [alone, "{", "[1]", "null", ""]) {
    expect(pack(scene, text, FILES)).toEqual({ parts: [scene.file] });
  }
});

test("the scene is the one file of its kind that lies highest", () => {
  const among = (...paths: string[]) => sceneAmong(paths.map((path) => given(path)));
  expect(among("room/a.bin", "room/A.GLTF", "room/old/b.glb", "room/._a.gltf")).toHaveProperty(
    "scene.path",
    "room/A.GLTF",
  );
  expect(among("a.glb")).toHaveProperty("scene.path", "a.glb");
  expect(among("a.bin", "b.png")).toHaveProperty("why", expect.stringContaining("No scene"));
  expect(among()).toHaveProperty("why", expect.stringContaining("No scene"));
  expect(among("r/a.glb", "r/b.gltf")).toHaveProperty("why", expect.stringContaining("2 scenes"));
});

test("a scene is called as its file is", () => {
  expect(sceneNameOf("room/Grandma’s kitchen.GLTF")).toBe("Grandma’s kitchen");
  expect(sceneNameOf("\u0007 a\tb .glb")).toBe("a b");
  expect(sceneNameOf(".glb")).toBe("");
  expect(new TextEncoder().encode(sceneNameOf(`${"☕🙂".repeat(200)}.glb`)).length).toBeLessThanOrEqual(256);
});
