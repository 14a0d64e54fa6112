// A .gltf file and the files that it names, made one file that the server takes: a GLB (glTF 2.0, section 4.4).

/** A file of a person's own, by its path from where it was picked or dropped. */
export interface Given<F> {
  path: string;
  file: F;
}

/** All that is asked of a file to pack it: its bytes are never read here. */
export interface Sized {
  size: number;
}

type Found<F> = { scene: Given<F> } | { why: string };

/** The parts of one file in their order, or a sentence that says why there is none. */
export type Packed<F> = { parts: (F | string | Uint8Array<ArrayBuffer>)[] } | { why: string };

const SCENE_FILE = /\.(glb|gltf)$/i;
const MOST_NAMED = 3;

/** The scene among files: the .glb or .gltf that lies highest in their folders. */
export function sceneAmong<F>(given: readonly Given<F>[]): Found<F> {
  const depth = ({ path }: Given<F>) => path.split("/").length;
  // A name that begins with a dot is a system's own note on a file.
  const scenes = given.filter(({ path }) => SCENE_FILE.test(path) && !fileName(path).startsWith("."));
  const least = Math.min(...scenes.map(depth));
  const [scene, ...others] = scenes.filter((one) => depth(one) === least);
  if (scene === undefined) {
    return { why: "No scene is among these files: a scene is a .glb file, or a .gltf file with its files." };
  }
  if (others.length === 0) return { scene };
  const names = namesOf([scene, ...others].map(({ path }) => fileName(path)));
  return { why: `There are ${others.length + 1} scenes, and one is loaded at a time: ${names}. Pick one.` };
}

export const isGltf = (path: string): boolean => /\.gltf$/i.test(path);

/** Name of a scene of such a file; empty if no part of the file's name can be one. */
export function sceneNameOf(path: string): string {
  const stem = fileName(path).replace(SCENE_FILE, "");
  const printable = stem.replace(/\p{Cc}/gu, " ").trim();
  // At most 256 bytes of UTF-8 (SPEC, HTTP-10), which 64 characters never exceed.
  return [...printable].slice(0, 64).join("").trim();
}

interface Json {
  [name: string]: unknown;
}

/** Range of the bytes of a buffer of the .gltf in the GLB. */
interface BufferRange {
  buffer: number;
  byteOffset: number;
}

/** The scene's .gltf, whose text is `text`, and what it names of the files, as one. One that needs no other file stays as it is. */
export function pack<F extends Sized>(scene: Given<F>, text: string, given: readonly Given<F>[]): Packed<F> {
  const root = parse(text);
  const outside = [...listOf(root, "buffers"), ...listOf(root, "images")].flatMap(outsideOf);
  // The server has the best message for a file that is not glTF either.
  if (outside.length === 0) return { parts: [scene.file] };
  const find = finder(scene.path, given);
  const missing = [...new Set(outside.filter((uri) => find(uri) === undefined).map(decoded))];
  if (missing.length > 0) {
    const why = `“${fileName(scene.path)}” needs files that did not come with it: ${namesOf(missing)}. Drop its folder, or pick it together with them.`;
    return { why };
  }
  const bin = startBin<F>();
  const places: BufferRange[] = [];
  /** The buffers that stay, behind the one of all files. */
  const kept: Json[] = [];
  for (const buffer of listOf(root, "buffers")) {
    const file = fileOf(buffer, find);
    if (file === undefined) {
      kept.push(buffer);
      places.push({ buffer: kept.length, byteOffset: 0 });
      continue;
    }
    const needed = Number(buffer.byteLength);
    if (file.file.size < needed) {
      const why = `“${file.path}” has ${file.file.size} bytes of the ${needed} that the scene needs of it: it is cut off, or of another export.`;
      return { why };
    }
    places.push({ buffer: 0, byteOffset: bin.add(file) });
  }
  const bufferViews = listOf(root, "bufferViews").map((view) => moved(view, places));
  const images = listOf(root, "images").map((image) => {
    const file = fileOf(image, find);
    if (file === undefined) return image;
    const { uri: _, ...rest } = image;
    const view = { buffer: 0, byteOffset: bin.add(file), byteLength: file.file.size };
    return { mimeType: typeOf(file.path), ...rest, bufferView: bufferViews.push(view) - 1 };
  });
  const json = {
    ...root,
    buffers: [{ byteLength: bin.length() }, ...kept],
    ...(bufferViews.length > 0 && { bufferViews }),
    ...(images.length > 0 && { images }),
  };
  return glb(asciiOf(json), bin.parts, bin.length());
}

function parse(text: string): Json {
  try {
    return asObject(JSON.parse(text));
  } catch {
    return {};
  }
}

const asObject = (value: unknown): Json =>
  typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Json) : {};

function listOf(root: Json, name: string): Json[] {
  const list = root[name];
  return Array.isArray(list) ? list.map(asObject) : [];
}

const isData = (uri: string): boolean => /^data:/i.test(uri);

/** The other file that an entry names, if it does. */
const outsideOf = ({ uri }: Json): string[] => (typeof uri === "string" && !isData(uri) ? [uri] : []);

const fileName = (path: string): string => path.slice(path.lastIndexOf("/") + 1);

function namesOf(names: readonly string[]): string {
  const rest = names.length - MOST_NAMED;
  const listed = names.slice(0, MOST_NAMED).join(", ");
  return rest > 0 ? `${listed} and ${rest} more` : listed;
}

function decoded(uri: string): string {
  try {
    return decodeURIComponent(uri);
  } catch {
    return uri;
  }
}

type Find<F> = (uri: string) => Given<F> | undefined;

function fileOf<F>(entry: Json, find: Find<F>): Given<F> | undefined {
  return outsideOf(entry).map(find)[0];
}

/** Finds files by the addresses of a .gltf at `scenePath`. Systems differ in case, in accents, and in what parts folders. */
function finder<F>(scenePath: string, given: readonly Given<F>[]): Find<F> {
  const composed = (path: string) => path.normalize("NFC");
  const folded = (path: string) => composed(path).toLowerCase();
  const exact = new Map(given.map((one) => [composed(one.path), one]));
  const inAnyCase = new Map(given.map((one) => [folded(one.path), one]));
  const folder = scenePath.split("/").slice(0, -1);
  return (uri) => {
    // Some exporters encode nothing: a name with a percent sign stands there as it is.
    for (const address of [decoded(uri), uri]) {
      const path = resolved(folder, address.replaceAll("\\", "/"));
      const found = path === null ? undefined : (exact.get(composed(path)) ?? inAnyCase.get(folded(path)));
      if (found !== undefined) return found;
    }
    return undefined;
  };
}

/** The path that an address leads to from a folder; `null` where it leads out of all that was given. */
function resolved(folder: readonly string[], address: string): string | null {
  const steps = [...folder];
  for (const step of address.split("/")) {
    if (step === "" || step === ".") continue;
    if (step !== "..") steps.push(step);
    else if (steps.pop() === undefined) return null;
  }
  return steps.join("/");
}

/** glTF wants a type beside a picture in a buffer; the server goes by its first bytes. */
function typeOf(path: string): string {
  const [, extension = ""] = /\.(\w+)$/.exec(path.toLowerCase()) ?? [];
  return { jpg: "image/jpeg", jpeg: "image/jpeg", webp: "image/webp" }[extension] ?? "image/png";
}

/** The view, and what extensions such as EXT_meshopt_compression say of it, where its buffer lies now. */
function moved(view: Json, places: readonly BufferRange[]): Json {
  const place = places[Number(view.buffer)];
  // It names no buffer of the file: the server says so.
  const own =
    place === undefined
      ? view
      : { ...view, buffer: place.buffer, byteOffset: Number(view.byteOffset ?? 0) + place.byteOffset };
  const extensions = Object.entries(asObject(view.extensions));
  if (extensions.length === 0) return own;
  const inside = ([name, said]: [string, unknown]) => {
    const extension = asObject(said);
    return [name, "buffer" in extension ? moved(extension, places) : said];
  };
  return { ...own, extensions: Object.fromEntries(extensions.map(inside)) };
}

/** The binary part of a GLB; each file in it begins at a multiple of four, and comes once however often it is named. */
function startBin<F extends Sized>() {
  const parts: (F | Uint8Array<ArrayBuffer>)[] = [];
  const offsets = new Map<F, number>();
  let length = 0;
  return {
    parts,
    length: () => length,
    add({ file }: Given<F>): number {
      const known = offsets.get(file);
      if (known !== undefined) return known;
      const offset = length;
      offsets.set(file, offset);
      parts.push(file, new Uint8Array(fill(file.size)));
      length += file.size + fill(file.size);
      return offset;
    },
  };
}

/** Bytes that are missing to a multiple of four. */
const fill = (length: number): number => (4 - (length % 4)) % 4;

/** JSON of one byte a character, so that its length is known without encoding it. */
const asciiOf = (json: Json): string =>
  JSON.stringify(json).replace(
    /[\u0080-\uffff]/g,
    (unit) => `\\u${unit.charCodeAt(0).toString(16).padStart(4, "0")}`,
  );

const MOST_BYTES = 2 ** 32 - 1;
const [GLTF, JSON_CHUNK, BIN_CHUNK] = [0x46546c67, 0x4e4f534a, 0x004e4942];

function glb<F>(json: string, bin: readonly (F | Uint8Array<ArrayBuffer>)[], binLength: number): Packed<F> {
  const padded = json + " ".repeat(fill(json.length));
  const length = 12 + 8 + padded.length + 8 + binLength;
  if (length > MOST_BYTES) return { why: "Its files have more than 4 GB together: split the scene." };
  const head = words(GLTF, 2, length, padded.length, JSON_CHUNK);
  return { parts: [head, padded, words(binLength, BIN_CHUNK), ...bin] };
}

/** Numbers of four bytes, least first. */
function words(...numbers: number[]): Uint8Array<ArrayBuffer> {
  const bytes = new DataView(new ArrayBuffer(4 * numbers.length));
  for (const [k, number] of numbers.entries()) bytes.setUint32(4 * k, number, true);
  return new Uint8Array(bytes.buffer);
}
