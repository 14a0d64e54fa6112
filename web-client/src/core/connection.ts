// One socket at a time, opened again for as long as the page lives.

import type { ClientMessage, ErrorCode, ServerMessage } from "./protocol";

/** Environment of the page. Tests bring their own. */
export interface Host {
  openSocket(events: SocketEvents): Socket;
  nowMs(): number;
  /** Runs `task` once after `ms`; the answer cancels it. */
  after(ms: number, task: () => void): () => void;
  /** Runs `task` before the next picture is put on the screen. */
  beforeRepaint(task: () => void): void;
  /** A number from 0 to 1. */
  random(): number;
  /** A name that nobody else comes up with. */
  newId(): string;
}

export interface SocketEvents {
  open(): void;
  text(message: string): void;
  binary(message: ArrayBuffer): void;
  closed(): void;
}

export interface Socket {
  send(text: string): void;
  close(): void;
}

export type ConnectionState =
  | { kind: "connecting" }
  | { kind: "connected" }
  /** Lost; tried again by itself. */
  | { kind: "reconnecting" }
  /** The server is stopping; it takes no more edits. */
  | { kind: "draining" }
  /** The server said no, and would again. */
  | { kind: "refused"; message: string };

export interface ConnectionEvents {
  hello(): ClientMessage;
  message(message: ServerMessage): void;
  frame(message: ArrayBuffer): void;
  state(state: ConnectionState): void;
  /** From a ping to its answer. */
  roundTrip(ms: number): void;
}

export interface Connection {
  /** Sends, or says `false` where there is no connection to send by. */
  send(message: ClientMessage): boolean;
  /** Closes and opens again at once. */
  restart(): void;
  /** Tries at once if it is waiting to try again. */
  wake(): void;
}

const FIRST_RETRY_MS = 250;
const LONGEST_RETRY_MS = 10_000;
const PING_EVERY_MS = 5_000;
/** Without an answer for so long the connection is taken for dead, as after a computer's sleep. */
const SILENCE_MS = 12_000;
/** Fatal errors after which the same hello may be welcome: they are about a moment, not about who asks. */
const PASSING_ERRORS: readonly ErrorCode[] = ["helloTooLate", "draining"];

/** Delay before try `attempt` (from 0): twice as long each time, half of it random. */
export function retryDelayMs(attempt: number, random: number): number {
  const longest = Math.min(FIRST_RETRY_MS * 2 ** attempt, LONGEST_RETRY_MS);
  return longest * (0.5 + 0.5 * random);
}

/** Opens the first socket. */
export function connect(host: Host, events: ConnectionEvents): Connection {
  let socket: Socket | null = null;
  let welcomed = false;
  let refused = false;
  let attempt = 0;
  let retryAfterMs: number | null = null;
  let heardMs = 0;
  let cancelRetry = () => {};
  let cancelPing = () => {};

  function open(): void {
    cancelRetry();
    cancelRetry = () => {};
    const isCurrent = () => socket === own;
    heardMs = host.nowMs();
    const own: Socket = host.openSocket({
      open: () => isCurrent() && own.send(JSON.stringify(events.hello())),
      text: (text) => isCurrent() && receive(JSON.parse(text) as ServerMessage),
      binary: (bytes) => {
        if (!isCurrent()) return;
        heardMs = host.nowMs();
        events.frame(bytes);
      },
      closed: () => isCurrent() && lost(),
    });
    socket = own;
    cancelPing();
    cancelPing = host.after(PING_EVERY_MS, ping);
  }

  function receive(message: ServerMessage): void {
    heardMs = host.nowMs();
    if (message.type === "welcome") {
      [welcomed, attempt, retryAfterMs] = [true, 0, null];
      events.state({ kind: "connected" });
    } else if (message.type === "pong") {
      events.roundTrip(host.nowMs() - message.sent);
    } else if (message.type === "draining") {
      retryAfterMs = message.retryAfterMs;
      events.state({ kind: "draining" });
    } else if (message.type === "error" && message.fatal && !PASSING_ERRORS.includes(message.code)) {
      refused = true;
      events.state({ kind: "refused", message: message.message });
    }
    events.message(message);
  }

  function ping(): void {
    if (host.nowMs() - heardMs > SILENCE_MS) {
      lost();
      return;
    }
    if (welcomed) send({ type: "ping", sent: host.nowMs() });
    cancelPing = host.after(PING_EVERY_MS, ping);
  }

  function drop(): void {
    const old = socket;
    [socket, welcomed] = [null, false];
    cancelPing();
    old?.close();
  }

  function lost(): void {
    drop();
    if (refused) return;
    events.state({ kind: "reconnecting" });
    const delay = Math.max(retryDelayMs(attempt, host.random()), retryAfterMs ?? 0);
    attempt += 1;
    cancelRetry = host.after(delay, open);
  }

  function send(message: ClientMessage): boolean {
    if (socket === null || !welcomed) return false;
    socket.send(JSON.stringify(message));
    return true;
  }

  function restart(): void {
    drop();
    refused = false;
    events.state({ kind: "reconnecting" });
    open();
  }

  events.state({ kind: "connecting" });
  open();
  return {
    send,
    restart,
    wake: () => {
      if (socket === null && !refused) open();
    },
  };
}
