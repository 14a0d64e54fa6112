import { expect, test } from "vitest";

import { connect, type ConnectionState, retryDelayMs } from "../src/core/connection";
import type { ServerMessage } from "../src/core/protocol";
import { WELCOME } from "./examples";
import { fakeHost } from "./fake_host";

function start() {
  const host = fakeHost();
  const states: ConnectionState["kind"][] = [];
  const received: ServerMessage["type"][] = [];
  const roundTrips: number[] = [];
  const connection = connect(host, {
    hello: () => ({ type: "hello", protocol: 1, token: "t", session: "main", actor: { id: "a", name: "A" } }),
    message: (message) => received.push(message.type),
    frame: () => {},
    state: (state) => states.push(state.kind),
    roundTrip: (ms) => roundTrips.push(ms),
  });
  const welcome = () => {
    host.socket().events.open();
    host.socket().receive({ type: "welcome", ...WELCOME });
  };
  return { host, states, received, roundTrips, connection, welcome };
}

test("says hello first, and nothing else before the welcome", () => {
  const { host, connection, welcome } = start();
  expect(connection.send({ type: "ack", frame: 1 })).toBe(false);
  host.socket().events.open();
  expect(host.socket().sent.map((m) => m.type)).toEqual(["hello"]);
  welcome();
  expect(connection.send({ type: "ack", frame: 1 })).toBe(true);
});

test("a lost connection is tried again, later each time, at most ten seconds apart", () => {
  const { host, states, welcome } = start();
  welcome();
  host.socket().events.closed();
  expect(states).toEqual(["connecting", "connected", "reconnecting"]);
  // The fake draws one half each time, so each wait is three quarters of the longest: 187.5, 375, ... ms.
  host.pass(187);
  expect(host.sockets).toHaveLength(1);
  host.pass(1);
  expect(host.sockets).toHaveLength(2);
  host.socket().events.closed();
  host.pass(370);
  expect(host.sockets).toHaveLength(2);
  host.pass(10);
  expect(host.sockets).toHaveLength(3);
  expect(retryDelayMs(50, 1)).toBe(10_000);
  expect(retryDelayMs(0, 0)).toBe(125);
});

test("a welcome starts the waiting anew", () => {
  const { host, welcome } = start();
  for (let k = 0; k < 6; k += 1) {
    host.socket().events.closed();
    host.pass(10_000);
  }
  const before = host.sockets.length;
  welcome();
  host.socket().events.closed();
  host.pass(200);
  expect(host.sockets).toHaveLength(before + 1);
});

test("a refusal is not tried again by itself, but by the person", () => {
  const { host, states, connection } = start();
  host.socket().events.open();
  host.socket().receive({ type: "error", code: "unauthorized", message: "The token is wrong.", fatal: true });
  host.socket().events.closed();
  host.pass(60_000);
  expect(host.sockets).toHaveLength(1);
  expect(states.at(-1)).toBe("refused");
  connection.restart();
  expect(host.sockets).toHaveLength(2);
});

test.each(["helloTooLate", "draining"] as const)("an error of the moment, %s, is tried again", (code) => {
  const { host, welcome } = start();
  welcome();
  host.socket().receive({ type: "error", code, message: "Not now.", fatal: true });
  host.socket().events.closed();
  host.pass(1000);
  expect(host.sockets).toHaveLength(2);
});

test("a stopping server is given the time it asks for", () => {
  const { host, states, welcome } = start();
  welcome();
  host.socket().receive({ type: "draining", retryAfterMs: 3000 });
  expect(states.at(-1)).toBe("draining");
  host.socket().events.closed();
  host.pass(2990);
  expect(host.sockets).toHaveLength(1);
  host.pass(20);
  expect(host.sockets).toHaveLength(2);
});

test("a connection that went silent is given up, one that answers is kept", () => {
  const { host, states, roundTrips, welcome } = start();
  welcome();
  host.pass(5000);
  const ping = host.socket().sent.at(-1);
  expect(ping?.type).toBe("ping");
  host.pass(40);
  host.socket().receive({ type: "pong", sent: ping?.type === "ping" ? ping.sent : 0, serverTimeUs: 1 });
  expect(roundTrips).toEqual([40]);
  host.pass(12_000);
  expect(states.at(-1)).toBe("connected");
  host.pass(5000);
  expect(host.sockets[0]?.closed).toBe(true);
  expect(states).toContain("reconnecting");
});

test("what an old socket still says is not heard", () => {
  const { host, received, connection, welcome } = start();
  welcome();
  const old = host.socket();
  connection.restart();
  old.receive({ type: "presence", clients: [] });
  old.events.closed();
  expect(received).toEqual(["welcome"]);
  expect(host.sockets).toHaveLength(2);
});
