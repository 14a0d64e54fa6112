// The browser as the core's surroundings.

import type { Host } from "../core/connection";

/** Opens sockets at the server that the page came from. */
export function browserHost(): Host {
  const address = new URL("/socket", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  return {
    openSocket(events) {
      const socket = new WebSocket(address);
      socket.binaryType = "arraybuffer";
      socket.onopen = events.open;
      socket.onclose = events.closed;
      socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) =>
        typeof data === "string" ? events.text(data) : events.binary(data);
      return {
        send: (text) => {
          if (socket.readyState === WebSocket.OPEN) socket.send(text);
        },
        close: () => socket.close(),
      };
    },
    nowMs: () => performance.now(),
    after(ms, task) {
      const timer = setTimeout(task, ms);
      return () => clearTimeout(timer);
    },
    nextFrame,
    random: Math.random,
    newId,
  };
}

/** A hidden page has no animation frames; after so long it goes on without, and still acknowledges. */
const HIDDEN_FRAME_MS = 500;

function nextFrame(task: () => void): void {
  const run = () => {
    cancelAnimationFrame(frame);
    clearTimeout(timer);
    task();
  };
  const frame = requestAnimationFrame(run);
  const timer = setTimeout(run, HIDDEN_FRAME_MS);
}

/** 128 random bits; `crypto.randomUUID` is missing on pages that come over plain http from elsewhere. */
export function newId(): string {
  return [...crypto.getRandomValues(new Uint8Array(16))]
    .map((byte) => byte.toString(16).padStart(2, "0"))
    .join("");
}
