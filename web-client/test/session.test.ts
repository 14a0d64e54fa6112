import { beforeEach, describe, expect, test } from "vitest";

import { aspectOf } from "../src/core/camera";
import { isAtLimit, lightOf } from "../src/core/document";
import type { Change, ClientMessage, Command, ServerMessage, Welcome } from "../src/core/protocol";
import type { Listed, Session } from "../src/core/session";
import type { Vec3 } from "../src/core/vector";
import { BENDY, CAMERA, log, radiusChange, record, STATS, WELCOME } from "./examples";
import { type FakeHost, fakeHost, sessionOn } from "./fake_host";

let host: FakeHost;
let session: Session;
let notices: string[];
let listed: Listed[];

beforeEach(() => {
  host = fakeHost();
  [notices, listed] = [[], []];
  session = sessionOn(
    host,
    (message) => notices.push(message),
    (now) => listed.push(now),
  );
  session.viewer.resize(640, 360);
});

const receive = (message: ServerMessage) => host.socket().receive(message);

function welcome(changed: Partial<Welcome> = {}): void {
  host.socket().events.open();
  receive({ type: "welcome", ...WELCOME, ...changed });
}

function sent<T extends ClientMessage["type"]>(type: T): Extract<ClientMessage, { type: T }>[] {
  return host.socket().sent.filter((m): m is Extract<ClientMessage, { type: T }> => m.type === type);
}

/** Messages of the page when it connects. */
const JUST_CONNECTED = ["hello", "openView", "presence", "history"];

function radius(point: number): number | undefined {
  const light = lightOf(session.document.value, 1);
  return light?.type === "bendy" ? light.radii[point] : undefined;
}

const setRadius = (point: number, to: number): Command => ({
  type: "setPoint",
  light: 1,
  point,
  parameter: { radius: to },
});

function reconnect(changed: Partial<Welcome>): void {
  host.socket().events.closed();
  host.pass(1000);
  welcome(changed);
}

test("what the list says of the session is told when it changes", () => {
  welcome();
  receive({ type: "sessionChanged", title: "Shot 10", archived: true });
  expect(listed).toMatchObject([{ title: "Shot 10", archived: true }]);
});

const dragTo = (to: Vec3): Command => ({
  type: "dragPoint",
  light: 1,
  point: 2,
  position: to,
  radii: "keep",
});

const moved = (to: Vec3): Change => ({
  type: "point",
  light: 1,
  layout: 1,
  point: 2,
  old: { position: BENDY.points[2] ?? [0, 0, 0] },
  new: { position: to },
});

const held = () => ({
  gesture: sent("gestureBegin")[0]?.gesture ?? "",
  client: 7,
  light: 1,
  liveRevision: 1,
});

/** The server lets control point 2 go so far. */
function answer(update: number, to: Vec3): void {
  receive({ type: "gestureState", ...held(), update, changes: [moved(to)] });
}

function position(point: number): Vec3 | undefined {
  const light = lightOf(session.document.value, 1);
  return light?.type === "bendy" ? light.points[point] : undefined;
}

const atLimit = () => isAtLimit(session.document.value, session.ownDrag.value?.taken ?? null);

describe("the mirror", () => {
  test("takes the snapshot, then each record once and in order", () => {
    welcome();
    expect(session.mirror.value).toMatchObject({ seq: 3, hash: "hash-3", epoch: "first" });
    receive(log(record(4, [radiusChange(1, 0.7)])));
    receive(log(record(4, [radiusChange(1, 0.9)])));
    expect(radius(1)).toBe(0.7);
    expect(session.mirror.value).toMatchObject({ seq: 4, hash: "hash-4" });
  });

  test("asks anew where a record is missing", () => {
    welcome();
    receive(log(record(5, [radiusChange(1, 0.7)])));
    expect(host.sockets).toHaveLength(2);
    expect(session.mirror.value.seq).toBe(3);
  });

  test("comes back with what it knows, and takes the tail", () => {
    welcome();
    receive(log(record(4, [radiusChange(1, 0.7)])));
    reconnect({ seq: 6, hash: "h", state: { tail: [record(5, [radiusChange(2, 0.8)]), record(6, [])] } });
    expect(sent("hello")[0]).toMatchObject({ epoch: "first", lastSeq: 4 });
    expect([radius(1), radius(2), session.mirror.value.seq]).toEqual([0.7, 0.8, 6]);
  });

  test("goes on from a resync, and drops what that holds already", () => {
    welcome();
    session.edit(setRadius(1, 0.6));
    const opId = sent("edit")[0]?.opId ?? "";
    const person = {
      client: 9,
      actor: { id: "ada", name: "Ada" },
      selection: null,
      following: null,
      camera: null,
      settings: null,
    };
    receive({
      type: "resync",
      seq: 2004,
      hash: "hash-2004",
      document: session.document.value,
      bounds: { min: [0, 0, 0], max: [9, 9, 9] },
      notes: ["skins are not posed: hero"],
      clients: [person],
      gestures: [],
    });
    expect(session.mirror.value).toMatchObject({ seq: 2004, hash: "hash-2004", epoch: "first" });
    expect([session.bounds.value.max, session.people.value]).toEqual([[9, 9, 9], [person]]);
    expect(session.notes.value).toEqual(["skins are not posed: hero"]);
    receive({ type: "editResult", opId, status: "committed", seq: 2000 });
    receive(log(record(2005, [radiusChange(1, 0.3)])));
    expect(radius(1)).toBe(0.3);
    expect(host.sockets).toHaveLength(1);
  });

  // Rules: SOCK-11
  test("knows the notes of the scene that is there, and of the next", () => {
    const notes = ["points and lines are not drawn: fence"];
    const scene = { asset: "sha256:01", name: "room" };
    welcome({ notes });
    expect(session.notes.value).toEqual(notes);
    receive(log(record(4, [radiusChange(1, 0.7)])));
    expect(session.notes.value).toEqual(notes);
    receive({
      ...log(record(5, [{ type: "scene", old: null, new: scene }])),
      bounds: WELCOME.bounds,
      notes: [],
    });
    expect(session.notes.value).toEqual([]);
    expect(session.document.value.scene?.name).toBe("room");
  });

  test("forgets what it knows where the history is another", () => {
    welcome();
    receive(log(record(4, [radiusChange(1, 0.7)])));
    reconnect({ epoch: "second", seq: 1 });
    expect(radius(1)).toBe(BENDY.radii[1]);
    expect(session.mirror.value).toMatchObject({ epoch: "second", seq: 1 });
  });

  test("knows which records a picture can show", () => {
    welcome();
    receive(log(record(4, [radiusChange(1, 0.7)])));
    receive(
      log(record(5, [{ type: "lightParameter", light: 1, old: { name: "key" }, new: { name: "rim" } }])),
    );
    receive(log(record(6, [{ type: "camera", camera: 9, old: null, new: CAMERA }])));
    expect(session.mirror.value).toMatchObject({ seq: 6, pictureSeq: 4 });
  });
});

describe("edits", () => {
  test("show at once and stay when the record comes", () => {
    welcome();
    session.edit(setRadius(1, 0.6));
    expect(radius(1)).toBe(0.6);
    expect(sent("edit")[0]).toMatchObject({ baseSeq: 3, command: setRadius(1, 0.6) });
    receive(log(record(4, [radiusChange(1, 0.6)], sent("edit")[0]?.opId)));
    receive(log(record(5, [radiusChange(1, 0.2)])));
    expect(radius(1)).toBe(0.2);
  });

  test("that are rejected are taken back, with the server's sentence", () => {
    welcome();
    session.edit(setRadius(1, 9));
    const opId = sent("edit")[0]?.opId ?? "";
    receive({ type: "editResult", opId, status: "rejected", code: "invalidLight", message: "It folds." });
    expect(radius(1)).toBe(BENDY.radii[1]);
    expect(notices).toEqual(["It folds."]);
  });

  test("without an answer are sent again with the same opId, and those in the tail are not", () => {
    welcome();
    session.edit(setRadius(1, 0.6));
    session.edit(setRadius(2, 0.7));
    session.undo("mine");
    const [first, second] = sent("edit");
    const tail = [record(4, [radiusChange(1, 0.6)], first?.opId)];
    const undo = sent("undo")[0];
    reconnect({ seq: 4, state: { tail } });
    expect(sent("edit")).toEqual([second]);
    expect(sent("undo")).toEqual([undo]);
  });

  test("that a snapshot holds already are done with their answer", () => {
    welcome();
    session.edit(setRadius(1, 0.6));
    const opId = sent("edit")[0]?.opId ?? "";
    reconnect({ epoch: "second", seq: 9 });
    receive({ type: "editResult", opId, status: "committed", seq: 8 });
    expect(radius(1)).toBe(BENDY.radii[1]);
  });

  test("are refused here where there is no connection", () => {
    session.edit(setRadius(1, 0.6));
    expect(radius(1)).toBeUndefined();
    expect(notices).toHaveLength(1);
  });

  test("tell their record to the one who asked", () => {
    welcome();
    const records: number[] = [];
    session.edit(setRadius(1, 0.6), ({ seq }) => records.push(seq));
    receive(log(record(4, [])));
    receive(log(record(5, [], sent("edit")[0]?.opId)));
    expect(records).toEqual([5]);
  });
});

describe("what undo would take back", () => {
  const step = { seq: 4, actor: { id: "ada", name: "Ada" }, what: "the radius of “key”" };

  test("is asked for at first, and once after records that come together", () => {
    welcome();
    expect([sent("history"), session.history.value]).toEqual([[{ type: "history" }], null]);
    receive(log(record(4, [radiusChange(1, 0.7)])));
    receive(log(record(5, [radiusChange(1, 0.8)])));
    expect(sent("history")).toHaveLength(1);
    host.pass(1000);
    expect(sent("history")).toHaveLength(2);
    const none = { mine: null, session: null };
    receive({ type: "history", seq: 5, undo: { mine: null, session: step }, redo: none });
    expect(session.history.value?.undo.session?.what).toBe("the radius of “key”");
  });

  test("is not known on another connection before it is told", () => {
    welcome();
    const none = { mine: null, session: null };
    receive({ type: "history", seq: 3, undo: none, redo: none });
    reconnect({ seq: 3, state: { tail: [] } });
    expect([session.history.value, sent("history").length]).toEqual([null, 1]);
  });
});

describe("drags", () => {
  test("send nothing before they move, then at most one update a frame, the latest", () => {
    welcome();
    const drag = session.drag(1);
    host.frame();
    expect(sent("gestureBegin")).toEqual([]);
    drag.update(setRadius(1, 0.3));
    drag.update(setRadius(1, 0.4));
    expect(radius(1)).toBe(0.4);
    host.frame();
    drag.update(setRadius(1, 0.5));
    host.frame();
    host.frame();
    expect(sent("gestureBegin")).toHaveLength(1);
    expect(sent("gestureUpdate").map((m) => m.command)).toEqual([setRadius(1, 0.4), setRadius(1, 0.5)]);
    expect(sent("gestureUpdate").map((m) => m.update)).toEqual([1, 2]);
  });

  test("commit what was last under the hand, once", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 0.3));
    host.frame();
    drag.update(setRadius(1, 0.45));
    drag.commit();
    drag.update(setRadius(1, 0.9));
    drag.commit();
    host.frame();
    expect(sent("gestureUpdate").at(-1)?.command).toEqual(setRadius(1, 0.45));
    expect(sent("gestureCommit")).toHaveLength(1);
    expect(radius(1)).toBe(0.45);
    receive(log(record(4, [radiusChange(1, 0.45)], sent("gestureCommit")[0]?.opId)));
    expect(radius(1)).toBe(0.45);
  });

  test("tell who asked about their record, once it is in the log", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 0.3));
    const told: number[] = [];
    drag.commit(({ seq }) => told.push(seq));
    receive(log(record(4, [radiusChange(2, 0.9)])));
    expect(told, "that was another's").toEqual([]);
    receive(log(record(5, [radiusChange(1, 0.3)], sent("gestureCommit")[0]?.opId)));
    expect(told).toEqual([5]);
  });

  test("that never moved leave no trace", () => {
    welcome();
    session.drag(1).commit();
    expect(host.socket().sent.map((m) => m.type)).toEqual(JUST_CONNECTED);
  });

  test("that are cancelled leave the light as it was", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 0.3));
    host.frame();
    drag.cancel();
    expect(radius(1)).toBe(BENDY.radii[1]);
    expect(sent("gestureCancel")).toHaveLength(1);
  });

  test("say why the server keeps an earlier state, until it takes one again", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 9));
    host.frame();
    const gesture = sent("gestureBegin")[0]?.gesture ?? "";
    const state = { gesture, client: 7, light: 1, liveRevision: 1, changes: [] };
    receive({ type: "gestureState", ...state, update: 1, code: "invalidLight", message: "It folds." });
    expect(session.ownDrag.value).toMatchObject({ refusal: "It folds.", taken: null });
    drag.update(setRadius(1, 0.2));
    host.frame();
    receive({ type: "gestureState", ...state, update: 2 });
    expect(session.ownDrag.value).toMatchObject({ refusal: null, taken: setRadius(1, 0.2) });
  });

  test("of control points show where the server lets them go, and that this is as far as it goes", () => {
    welcome();
    const drag = session.drag(1);
    const [asked, wall] = [
      [9, 9, 9],
      [1.5, -1, 0.25],
    ] as const satisfies Vec3[];
    drag.update(dragTo(asked));
    host.frame();
    expect(position(2)).toEqual(BENDY.points[2]);
    expect(atLimit()).toBe(false);
    answer(1, wall);
    expect(position(2)).toEqual(wall);
    expect(session.ownDrag.value?.refusal).toBeNull();
    expect(atLimit()).toBe(true);
    // A cursor that comes back: the server's word counts, and until it comes the point stays.
    const near: Vec3 = [1.25, -1, 0.25];
    drag.update(dragTo(near));
    host.frame();
    expect([position(2), atLimit()]).toEqual([wall, true]);
    answer(2, near);
    expect([position(2), atLimit()]).toEqual([near, false]);
    // A point that does not move at all has no change.
    drag.update(dragTo(asked));
    host.frame();
    receive({ type: "gestureState", ...held(), update: 3, changes: [] });
    expect([position(2), atLimit()]).toEqual([BENDY.points[2], true]);
  });

  test("of control points stay where they were let go of until the record is there", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(dragTo([9, 9, 9]));
    host.frame();
    const wall: Vec3 = [1.5, -1, 0.25];
    answer(1, wall);
    drag.commit();
    expect([position(2), session.ownDrag.value]).toEqual([wall, null]);
    receive(log(record(4, [moved(wall)], sent("gestureCommit")[0]?.opId)));
    expect(position(2)).toEqual(wall);
    receive(log(record(5, [moved([0.5, -1, 0.25])])));
    expect(position(2)).toEqual([0.5, -1, 0.25]);
  });

  test("on a light that somebody holds end with the server's sentence", () => {
    welcome();
    session.drag(1).update(setRadius(1, 0.3));
    host.frame();
    const gesture = sent("gestureBegin")[0]?.gesture ?? "";
    const state = { gesture, client: 7, light: 1, update: 0, liveRevision: 0, changes: [] };
    receive({ type: "gestureState", ...state, ended: "rejected", code: "locked", message: "Ada holds it." });
    expect(radius(1)).toBe(BENDY.radii[1]);
    expect(notices).toEqual(["Ada holds it."]);
  });

  test("end with the connection", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 0.3));
    host.frame();
    reconnect({ state: { tail: [] } });
    drag.update(setRadius(1, 0.5));
    drag.commit();
    host.frame();
    expect(host.socket().sent.map((m) => m.type)).toEqual(JUST_CONNECTED);
    expect(radius(1)).toBe(BENDY.radii[1]);
    expect(notices).toHaveLength(1);
  });

  test("whose commit was not answered become edits on the next connection, under the same opId", () => {
    welcome();
    const drag = session.drag(1);
    drag.update(setRadius(1, 0.3));
    drag.commit();
    const opId = sent("gestureCommit")[0]?.opId;
    reconnect({ state: { tail: [] } });
    expect(sent("edit")).toEqual([{ type: "edit", opId, baseSeq: 3, command: setRadius(1, 0.3) }]);
  });
});

describe("others", () => {
  const state = { gesture: "g", client: 8, light: 1, update: 1, liveRevision: 1 };

  test("are seen while they drag, and no longer than that", () => {
    welcome();
    receive({ type: "gestureState", ...state, changes: [radiusChange(2, 0.9)] });
    expect(radius(2)).toBe(0.9);
    expect(session.gestures.value).toHaveLength(1);
    receive({ type: "gestureState", ...state, update: 2, changes: [radiusChange(2, 0.8)] });
    expect(radius(2)).toBe(0.8);
    receive({ type: "gestureState", ...state, changes: [], ended: "cancelled" });
    expect(radius(2)).toBe(BENDY.radii[2]);
    expect(session.gestures.value).toEqual([]);
  });

  test("who were dragging when this page came are seen too", () => {
    welcome({ gestures: [{ ...state, changes: [radiusChange(2, 0.9)] }] });
    expect(radius(2)).toBe(0.9);
  });
});

describe("views", () => {
  const ada = {
    client: 8,
    actor: { id: "ada", name: "Ada" },
    selection: null,
    following: null,
    camera: { ...CAMERA, name: "ada's" },
    settings: { exposure: 2, solo: [1] },
  };

  test("start at the welcome's camera and move at most once a frame", () => {
    welcome();
    expect(sent("openView")[0]).toMatchObject({ source: { own: CAMERA }, cameraRevision: 1 });
    for (let k = 1; k <= 3; k += 1) {
      session.viewer.move((from) => ({
        ...from,
        camera: { ...from.camera, name: `moved ${k}` },
      }));
    }
    host.frame();
    expect(sent("setCamera")).toMatchObject([{ camera: { name: "moved 3" }, cameraRevision: 2 }]);
  });

  test("are asked for once the stage has a size, and keep all of the shot when it changes", () => {
    session = sessionOn(host);
    welcome();
    expect(sent("openView")).toEqual([]);
    session.viewer.resize(400, 700);
    session.viewer.resize(700, 400);
    const aspects = sent("openView").map(({ source }) => "own" in source && aspectOf(source.own));
    expect(aspects).toEqual([16 / 9]);
    expect(sent("openView")[0]).toMatchObject({ width: 400, height: 700 });
    expect(sent("viewport")).toMatchObject([{ width: 700, height: 400 }]);
    expect(sent("setCamera")).toEqual([]);
  });

  test("stay where they are over a reconnection", () => {
    welcome();
    session.viewer.jump({ ...CAMERA, name: "mine" });
    host.frame();
    reconnect({ state: { tail: [] } });
    expect(sent("openView")[0]).toMatchObject({ source: { own: { name: "mine" } } });
  });

  test("follow another's, and leave from there when moved", () => {
    welcome({ clients: [ada] });
    session.viewer.follow(8);
    expect(sent("openView").at(-1)?.source).toEqual({ follow: 8 });
    expect(session.viewer.cameraOf(null)?.name).toBe("ada's");
    session.viewer.move((from) => from);
    expect(sent("openView").at(-1)).toMatchObject({ source: { own: { name: "ada's" } } });
    expect(session.viewer.following.value).toBeNull();
  });

  test("do not follow somebody else who has the number after a restart", () => {
    welcome({ clients: [ada] });
    session.viewer.follow(8);
    reconnect({ clients: [{ ...ada, actor: { id: "eve", name: "Eve" } }], state: { tail: [] } });
    expect(session.viewer.following.value).toBeNull();
  });

  test("of somebody who follows are the followed one's", () => {
    const bob = { ...ada, client: 9, following: 8, camera: null, settings: null };
    welcome({ clients: [ada, bob] });
    session.viewer.follow(9);
    expect(session.viewer.cameraOf(null)?.name).toBe("ada's");
    expect(session.viewer.shownSettings.value).toEqual(ada.settings);
  });

  test("are one's own again when the followed one has left, from where that was", () => {
    welcome({ clients: [ada] });
    session.viewer.follow(8);
    receive({ type: "presence", clients: [] });
    expect(session.viewer.following.value).toBeNull();
    expect(sent("openView").at(-1)).toMatchObject({ source: { own: { name: "ada's" } } });
  });

  // Rules: SOCK-12
  test("have settings of their own, which frames count like cameras", () => {
    session = sessionOn(host);
    const { viewer } = session;
    viewer.set({ exposure: 1 });
    welcome();
    viewer.resize(640, 360);
    expect(sent("openView")).toMatchObject([{ cameraRevision: 1, settings: { exposure: 1, solo: [] } }]);
    viewer.set({ solo: [1] });
    viewer.move((from) => ({ ...from, camera: { ...from.camera, name: "moved" } }));
    viewer.set({ exposure: -0.5 });
    expect([viewer.revision.value, sent("setView")]).toEqual([3, []]);
    host.frame();
    expect(sent("setCamera")).toMatchObject([{ camera: { name: "moved" }, cameraRevision: 2 }]);
    const settings = { exposure: -0.5, solo: [1] };
    expect(sent("setView")).toEqual([{ type: "setView", settings, cameraRevision: 3 }]);

    // Another's view is as the other has it, and one's own afterwards as it was.
    receive({ type: "presence", clients: [ada] });
    viewer.follow(8);
    expect(viewer.shownSettings.value).toEqual(ada.settings);
    viewer.set({ exposure: 3 });
    host.frame();
    expect(sent("setView")).toHaveLength(1);
    viewer.follow(null);
    expect(sent("openView").at(-1)?.settings).toEqual({ exposure: 3, solo: [1] });
    expect(viewer.shownSettings.value).toEqual(viewer.settings.value);
  });

  // Rules: FRAME-13
  test("are told what pictures came to while that is asked for, by the view's settings or, of another's, by its own", () => {
    welcome();
    session.viewer.askStats(true);
    host.frame();
    const settings = { exposure: 0, solo: [] };
    expect(sent("setView")).toEqual([{ type: "setView", settings, stats: true, cameraRevision: 2 }]);
    const stats: ServerMessage = { type: "stats", ...STATS };
    receive(stats);
    expect(session.frameStats.value.moving).toMatchObject({ frame: 1 });
    session.viewer.set({ exposure: 1 });
    host.frame();
    expect(sent("setView").at(-1)).not.toHaveProperty("stats");
    reconnect({});
    expect(session.frameStats.value.moving).toBeNull();
    expect(sent("openView")).toMatchObject([{ stats: true }]);
    receive({ type: "presence", clients: [ada] });
    session.viewer.follow(8);
    session.viewer.askStats(false);
    expect(sent("openView").map((view) => view.stats)).toEqual([true, true, false]);
    receive(stats);
    expect(session.frameStats.value.moving).toBeNull();
  });

  // Rules: SOCK-12
  test("show no light alone that was removed, also when it is back", () => {
    welcome();
    session.viewer.set({ solo: [1] });
    host.frame();
    const placed = { layout: 0, light: BENDY };
    const removed = { type: "light", light: 1, old: placed, new: null } as const;
    receive(log(record(4, [removed])));
    host.frame();
    expect(sent("setView").map(({ settings }) => settings.solo)).toEqual([[1], []]);
    receive(log(record(5, [{ ...removed, old: null, new: placed }])));
    expect(session.viewer.settings.value.solo).toEqual([]);
  });
});
