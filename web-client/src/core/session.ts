// The page's side of a session: what it knows, what it has asked for, and what it shows.

import { batch, computed, effect, type ReadonlySignal, signal } from "@preact/signals-core";

import { connect, type Connection, type ConnectionState, type Host } from "./connection";
import { applyChange, lightName, predict } from "./document";
import { display, type Screen, type Statistics } from "./display";
import { type Drag, dragging, type OwnDrag } from "./drags";
import type { FrameHeader } from "./frame";
import { type LatestStats, NO_STATS, withStats } from "./frame_stats";
import type { ClientId, LightId } from "./ids";
import { latencyMeter } from "./latency";
import { advance, type Mirror, NOTHING, snapshotOf } from "./mirror";
import { operations, type Request } from "./operations";
import { type Probing, probing } from "./probing";
import type { ParameterTable } from "./protocol";
import type {
  Actor,
  Bounds,
  Change,
  ClientMessage,
  Command,
  Document,
  GestureState,
  History,
  Presence,
  Record,
  Resync,
  Scope,
  ServerMessage,
  Welcome,
} from "./protocol";
import { type Viewer, viewing } from "./viewer";

export interface Session {
  /** Parameters of the server. */
  table: ParameterTable;
  connection: ReadonlySignal<ConnectionState>;
  /** Document of the log. */
  mirror: ReadonlySignal<Mirror>;
  /** The mirror with everybody's drags and this page's own edits under way. */
  document: ReadonlySignal<Document>;
  bounds: ReadonlySignal<Bounds>;
  /** Parts of the scene's file that are not drawn or were changed, a sentence each. */
  notes: ReadonlySignal<readonly string[]>;
  /** This client's number. */
  client: ReadonlySignal<ClientId | null>;
  actor: ReadonlySignal<Actor>;
  people: ReadonlySignal<readonly Presence[]>;
  /** Drags by others. */
  gestures: ReadonlySignal<readonly GestureState[]>;
  ownDrag: ReadonlySignal<OwnDrag | null>;
  /** Steps that undo and redo would take; `null` before the server has sent them. */
  history: ReadonlySignal<History | null>;
  /** The picture on the screen. */
  frame: ReadonlySignal<FrameHeader | null>;
  statistics: ReadonlySignal<Statistics>;
  /** Statistics of the latest pictures, while they are requested. */
  frameStats: ReadonlySignal<LatestStats>;
  viewer: Viewer;
  /** Asks what is seen at a pixel, and what each light does there. */
  probe: Probing["ask"];
  /** Asks for `command`; `done` is told its record. */
  edit(command: Command, done?: (record: Record) => void): void;
  undo(scope: Scope): void;
  redo(scope: Scope): void;
  /** A drag on `light`; nothing is sent before its first update. */
  drag(light: LightId): Drag;
  select(light: LightId | null): void;
  rename(name: string): void;
  /** Connects again at once, after a refusal too. */
  reconnect(): void;
  /** Tries at once if it is waiting to try again. */
  wake(): void;
}

export interface SessionOptions<T> {
  host: Host;
  token: string;
  session: string;
  /** Parameters of the server, which sends them before the connection. */
  table: ParameterTable;
  actor: Actor;
  screen: Screen<T>;
  /** A sentence for the person at the page. */
  notify(message: string): void;
  /** Reports a changed entry in the list of sessions. */
  listed(listed: Listed): void;
}

/** Entry of a session in the list. */
export interface Listed {
  title: string;
  archived: boolean;
}

/** The version of the protocol that this page speaks. */
const PROTOCOL = 1;
/** After a record, so that several that come together are asked about once. */
const ASK_HISTORY_AFTER_MS = 100;
const UNIT_BOX: Bounds = { min: [-1, -1, -1], max: [1, 1, 1] };

/** Connects to `session` and stays connected. */
export function startSession<T>(options: SessionOptions<T>): Session {
  const { host, screen, notify, table } = options;
  const connection = signal<ConnectionState>({ kind: "connecting" });
  const mirror = signal<Mirror>(NOTHING);
  const bounds = signal<Bounds>(UNIT_BOX);
  const notes = signal<readonly string[]>([]);
  const client = signal<ClientId | null>(null);
  const actor = signal<Actor>(options.actor);
  const people = signal<readonly Presence[]>([]);
  const gestures = signal<readonly GestureState[]>([]);
  const history = signal<History | null>(null);
  const frameStats = signal<LatestStats>(NO_STATS);
  const latency = latencyMeter();
  let selection: LightId | null = null;
  let cancelAsking = () => {};

  const send = (message: ClientMessage): boolean => link.send(message);
  const asked = operations({ host, send, notify, latency });
  const drags = dragging({
    host,
    send,
    notify,
    latency,
    baseSeq: () => mirror.value.seq,
    lightName: (light) => lightName(mirror.value.document, light),
    commit: (edit, commit, changes, done) => asked.start(edit, commit, done, changes),
  });
  const probes = probing({ host, send });
  const viewer = viewing({ host, send, bounds: () => bounds.value, latency });
  const { frame, statistics, feed, roundTrip } = display({ host, screen, send, notify, latency });

  const document = computed(() => {
    const changed = (document: Document, changes: readonly Change[]) =>
      changes.reduce((document, change) => applyChange(table, document, change), document);
    const live = gestures.value.reduce(
      (document, { changes }) => changed(document, changes),
      mirror.value.document,
    );
    const dragged = drags.own.value === null ? [] : [drags.own.value];
    return [...asked.underway.value, ...dragged].reduce(
      (document, { command, changes }) => predict(table, changed(document, changes), command),
      live,
    );
  });

  // A light that is gone is alone no more, also when an undo brings it back.
  effect(() => {
    const there = new Set(mirror.value.document.lights.map(({ id }) => id));
    const { solo } = viewer.settings.peek();
    if (solo.some((id) => !there.has(id))) viewer.set({ solo: solo.filter((id) => there.has(id)) });
  });

  effect(() => {
    if (!viewer.stats.value) frameStats.value = NO_STATS;
  });

  function welcomed(welcome: Welcome): void {
    frameStats.value = NO_STATS;
    client.value = welcome.client;
    feed.restart();
    latency.restart();
    const { epoch, seq, hash, state } = welcome;
    if ("tail" in state) for (const record of state.tail) take(record, hash);
    else mirror.value = snapshotOf(epoch, seq, hash, state.snapshot);
    setOthers(welcome);
    viewer.open(welcome.camera);
    send({ type: "presence", selection });
    history.value = null;
    send({ type: "history" });
    asked.resend();
  }

  /** Goes on from where the session is by now (SPEC, SOCK-10). */
  function resynced(resync: Resync): void {
    mirror.value = snapshotOf(mirror.value.epoch, resync.seq, resync.hash, resync.document);
    setOthers(resync);
    askHistory();
  }

  function askHistory(): void {
    cancelAsking();
    cancelAsking = host.after(ASK_HISTORY_AFTER_MS, () => void send({ type: "history" }));
  }

  /** Takes a record into the mirror. One that is missing before it can only come with a new welcome. */
  function take(record: Record, hash: string): void {
    const next = advance(table, mirror.value, record, hash);
    if (next !== null) {
      mirror.value = next;
      asked.logged(record, next.pictureSeq === record.seq);
      askHistory();
    } else if (record.seq > mirror.value.seq) {
      link.restart();
    }
  }

  function gestureChanged(state: GestureState): void {
    if (state.client === client.value) {
      drags.answered(state);
      return;
    }
    const others = gestures.value.filter((g) => g.client !== state.client || g.gesture !== state.gesture);
    gestures.value = state.ended === undefined ? [...others, state] : others;
  }

  function setOthers(there: Welcome | Resync): void {
    bounds.value = there.bounds;
    notes.value = there.notes;
    gestures.value = there.gestures.filter((gesture) => gesture.client !== client.value);
    setPeople(there.clients);
  }

  function setPeople(present: readonly Presence[]): void {
    people.value = present;
    viewer.people(present);
  }

  function receive(message: ServerMessage): void {
    switch (message.type) {
      case "welcome":
        welcomed(message);
        break;
      case "log":
        if (message.bounds !== undefined) bounds.value = message.bounds;
        if (message.notes !== undefined) notes.value = message.notes;
        take(message.record, message.hash);
        break;
      case "resync":
        resynced(message);
        break;
      case "editResult":
        asked.answered(message, mirror.value.seq);
        break;
      case "gestureState":
        gestureChanged(message);
        break;
      case "history":
        history.value = message;
        break;
      case "presence":
        setPeople(message.clients);
        break;
      case "probed":
        probes.answered(message);
        break;
      case "stats":
        // One that was under way when they were no longer asked for is passed over.
        if (viewer.stats.value) frameStats.value = withStats(frameStats.value, message);
        break;
      case "error":
        if (!message.fatal) notify(message.message);
        break;
      case "sessionChanged":
        options.listed(message);
        break;
      case "viewConfig":
      case "pong":
      case "draining":
        break;
    }
  }

  const link: Connection = connect(host, {
    hello: () => {
      const { epoch, seq } = mirror.value;
      const known = epoch === "" ? {} : { epoch, lastSeq: seq };
      const { token, session } = options;
      return { type: "hello", protocol: PROTOCOL, token, session, actor: actor.value, ...known };
    },
    message: (message) => batch(() => receive(message)),
    frame: feed.receive,
    state(state) {
      connection.value = state;
      if (state.kind !== "reconnecting") return;
      drags.lost();
      probes.lost();
    },
    roundTrip,
  });

  return {
    table,
    connection,
    mirror,
    document,
    bounds,
    notes,
    client,
    actor,
    people,
    gestures,
    ownDrag: drags.own,
    history,
    frame,
    statistics,
    frameStats,
    viewer,
    probe: probes.ask,
    edit(command, done) {
      const request: Request = { type: "edit", opId: host.newId(), baseSeq: mirror.value.seq, command };
      asked.start(request, request, done);
    },
    undo: (scope) => asked.start({ type: "undo", opId: host.newId(), scope }),
    redo: (scope) => asked.start({ type: "redo", opId: host.newId(), scope }),
    drag: drags.begin,
    select(light) {
      selection = light;
      send({ type: "presence", selection });
    },
    rename(name) {
      actor.value = { ...actor.value, name };
      link.restart();
    },
    reconnect: link.restart,
    wake: link.wake,
  };
}
