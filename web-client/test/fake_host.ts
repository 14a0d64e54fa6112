// Surroundings with a clock that stands still until it is told otherwise, and sockets that go nowhere.

import type { Host, SocketEvents } from "../src/core/connection";
import type { ClientMessage, ServerMessage } from "../src/core/protocol";
import { type Listed, type Session, startSession } from "../src/core/session";
import { TABLE } from "./parameters_fixture";

export interface FakeSocket {
  events: SocketEvents;
  sent: ClientMessage[];
  closed: boolean;
  /** Delivers a message of the server. */
  receive(message: ServerMessage): void;
}

export interface FakeHost extends Host {
  sockets: FakeSocket[];
  /** The latest socket. */
  socket(): FakeSocket;
  /** Lets `ms` pass, running what falls due. */
  pass(ms: number): void;
  /** Runs what waits for the next picture. */
  frame(): void;
}

export function fakeHost(): FakeHost {
  let nowMs = 1000;
  let ids = 0;
  let timers: { atMs: number; task: () => void }[] = [];
  let frames: (() => void)[] = [];
  const sockets: FakeSocket[] = [];

  function openSocket(events: SocketEvents) {
    const socket: FakeSocket = {
      events,
      sent: [],
      closed: false,
      receive: (message) => events.text(JSON.stringify(message)),
    };
    sockets.push(socket);
    return {
      send: (text: string) => void socket.sent.push(JSON.parse(text) as ClientMessage),
      close: () => {
        socket.closed = true;
      },
    };
  }

  return {
    sockets,
    openSocket,
    socket() {
      const latest = sockets.at(-1);
      if (latest === undefined) throw new Error("no socket was opened");
      return latest;
    },
    nowMs: () => nowMs,
    after(ms, task) {
      const timer = { atMs: nowMs + ms, task };
      timers.push(timer);
      return () => (timers = timers.filter((other) => other !== timer));
    },
    beforeRepaint: (task) => void frames.push(task),
    random: () => 0.5,
    newId() {
      ids += 1;
      return `id-${ids}`;
    },
    pass(ms) {
      const until = nowMs + ms;
      for (;;) {
        const next = timers.filter((timer) => timer.atMs <= until).sort((a, b) => a.atMs - b.atMs)[0];
        if (next === undefined) break;
        timers = timers.filter((timer) => timer !== next);
        nowMs = next.atMs;
        next.task();
      }
      nowMs = until;
    },
    frame() {
      const due = frames;
      frames = [];
      for (const task of due) task();
    },
  };
}

/** A session of a person called Me whose pictures go nowhere. */
export const sessionOn = (
  host: Host,
  notify: (message: string) => void = () => {},
  listed: (listed: Listed) => void = () => {},
): Session =>
  startSession({
    host,
    token: "secret",
    session: "main",
    table: TABLE,
    actor: { id: "me", name: "Me" },
    screen: { decode: () => Promise.resolve(null), draw: () => {} },
    notify,
    listed,
  });
