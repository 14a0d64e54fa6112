// A session's beginnings for tests, and numbers that look random and are the same every time.

import { type Owner, rowsOf } from "../src/core/parameters";
import type {
  Bendy,
  Camera,
  Change,
  Command,
  Directional,
  Document,
  FrameStats,
  Omni,
  Record,
  ServerLog,
  Spot,
  Welcome,
} from "../src/core/protocol";
import type { Vec3 } from "../src/core/vector";
import { TABLE } from "./parameters_fixture";

/** The fields of a light that have defaults, at those. */
function defaults<L>(owner: Owner): L {
  const rows = rowsOf(TABLE, owner);
  const fields = rows.filter(({ path, default: initial }) => !path.includes("/") && initial[owner] !== null);
  return Object.fromEntries(fields.map(({ path, default: initial }) => [path, initial[owner]])) as L;
}

export const CAMERA: Camera = {
  name: "camera",
  translation: [0.3, 2.3, 4.5],
  rotation: [0, 0, 0, 1],
  projection: { perspective: { yfov: 0.6, znear: 0.1 } },
};

export const BENDY: Bendy = {
  ...defaults<Bendy>("bendy"),
  type: "bendy",
  name: "key",
  transform: { translation: [0, 2, -3], rotation: [0, 0, 0, 1], scale: 1.5 },
  points: [
    [0, 0, 0],
    [0.5, -0.3, 0],
    [1.2, -1, 0.2],
    [1.4, -1.6, 0.3],
  ],
  radii: [0.1, 0.2, 0.35, 0.5],
  colors: [
    [1, 1, 1],
    [1, 1, 1],
    [1, 0.9, 0.8],
    [1, 0.9, 0.8],
  ],
  intensities: [4, 4, 4, 4],
};

export const SPOT: Spot = {
  ...defaults<Spot>("spot"),
  type: "spot",
  name: "rim",
  transform: { translation: [0, 2.5, -3], rotation: [0, Math.SQRT1_2, 0, Math.SQRT1_2], scale: 1 },
  coneAngle: 20,
  decay: "none",
};

export const OMNI: Omni = {
  ...defaults<Omni>("omni"),
  type: "omni",
  name: "bulb",
  transform: SPOT.transform,
};

export const DIRECTIONAL: Directional = {
  ...defaults<Directional>("directional"),
  type: "directional",
  name: "sun",
  transform: SPOT.transform,
};

export const DOCUMENT: Document = {
  scene: { asset: "sha256:00", name: "demo:vases" },
  lights: [{ id: 1, layout: 1, light: BENDY }],
  cameras: [{ id: 2, camera: CAMERA }],
};

export const WELCOME: Welcome = {
  protocol: 1,
  session: "main",
  client: 7,
  epoch: "first",
  seq: 3,
  hash: "hash-3",
  state: { snapshot: DOCUMENT },
  bounds: { min: [-2, 0, -2], max: [2, 2, 2] },
  notes: [],
  camera: CAMERA,
  clients: [],
  gestures: [],
  settings: { ackWindow: 3, leaseMs: 30_000, maxViewSide: 4096 },
};

export const radiusChange = (point: number, to: number): Change => ({
  type: "point",
  light: 1,
  layout: 1,
  point,
  old: { radius: BENDY.radii[point] ?? 0 },
  new: { radius: to },
});

export function record(seq: number, changes: Change[], opId = `other-${seq}`): Record {
  return {
    format: 1,
    seq,
    timeMs: 0,
    actor: { id: "ada", name: "Ada" },
    opId,
    action: { type: "edit", command: { type: "removeLight", light: 1 } },
    changes,
  };
}

export const log = (entry: Record): ServerLog => ({
  type: "log",
  record: entry,
  hash: `hash-${entry.seq}`,
});

/** Numbers from 0 to 1, the same for the same seed (mulberry32). */
export function seeded(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** A vector with components from -size to size. */
export const someVector = (next: () => number, size: number): Vec3 => [
  (2 * next() - 1) * size,
  (2 * next() - 1) * size,
  (2 * next() - 1) * size,
];

/** Largest difference between two lists of numbers. */
export function difference(a: readonly number[], b: readonly number[]): number {
  if (a.length !== b.length) return Infinity;
  return a.reduce((most, value, k) => Math.max(most, Math.abs(value - (b[k] ?? NaN))), 0);
}

/** Result of the server for the drag of a control point without a limit; other commands are returned unchanged. */
export function unhindered(command: Command): Command {
  if (command.type !== "dragPoint") return command;
  const { light, point, position } = command;
  return { type: "setPoint", light, point, parameter: { position } };
}

/** Statistics of a held picture. */
export const STATS: FrameStats = {
  frame: 1,
  waitUs: 1,
  renderUs: 2,
  encodeUs: 3,
  bytes: 4,
  tiles: 1,
  size: [64, 36],
  shadowMapDivisor: 1,
  quality: "moving",
  passes: [],
};
