// The browser as the core's surroundings.

import type { AlternativeAnswer, AlternativesReply, AlternativesRequest } from "../core/alternatives";
import type { Host } from "../core/connection";
import type { Camera, ParameterTable, SceneNodes } from "../core/protocol";
import type { Vec3 } from "../core/vector";
import type { SendingEvents } from "./opening";

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
    beforeRepaint,
    random: Math.random,
    newId,
  };
}

/** A hidden page has no animation frames; after so long it goes on without, and still acknowledges. */
const HIDDEN_FRAME_MS = 500;

function beforeRepaint(task: () => void): void {
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

/** The table of parameters, or a sentence that says why there is none. */
export type TableAnswer = { table: ParameterTable } | { why: string; isTokenWrong: boolean };

/** Asks the server for it. */
export async function fetchTable(token: string): Promise<TableAnswer> {
  const headers = { authorization: `Bearer ${token}` };
  try {
    const answer = await fetch("/parameters", { headers });
    if (answer.ok) return { table: (await answer.json()) as ParameterTable };
    if (answer.status === 404) return { why: OLD_SERVER, isTokenWrong: false };
    const { error } = (await answer.json()) as { error: { message: string } };
    return { why: error.message, isTokenWrong: answer.status === 401 };
  } catch {
    return { why: NO_ANSWER, isTokenWrong: false };
  }
}

/** The point of the scene in the middle of a camera's picture; `null` where nothing is, or where the server does not say. */
export async function pickPoint(token: string, session: string, camera: Camera): Promise<Vec3 | null> {
  const headers = { authorization: `Bearer ${token}`, "content-type": "application/json" };
  const request = { method: "POST", headers, body: JSON.stringify({ camera }) };
  try {
    const answer = await fetch(`/sessions/${encodeURIComponent(session)}/pick`, request);
    return answer.ok ? ((await answer.json()) as { point: Vec3 | null }).point : null;
  } catch {
    return null;
  }
}

/** The nodes of a session's scene; `null` where the server does not say, and then links are typed. */
export async function fetchNodes(token: string, session: string): Promise<SceneNodes | null> {
  const headers = { authorization: `Bearer ${token}` };
  try {
    const answer = await fetch(`/sessions/${encodeURIComponent(session)}/nodes`, { headers });
    return answer.ok ? ((await answer.json()) as SceneNodes) : null;
  } catch {
    return null;
  }
}

/** All alternatives of a drag from the document as it is; nothing is edited. */
export async function fetchAlternatives(
  token: string,
  session: string,
  request: AlternativesRequest,
): Promise<AlternativesReply> {
  const headers = { authorization: `Bearer ${token}`, "content-type": "application/json" };
  const body = JSON.stringify([request]);
  try {
    const answer = await fetch(`/sessions/${encodeURIComponent(session)}/drags`, {
      method: "POST",
      headers,
      body,
    });
    if (!answer.ok) return { why: ((await answer.json()) as { error: { message: string } }).error.message };
    const [result] = (await answer.json()) as [{ alternatives?: AlternativeAnswer[] }?];
    return result?.alternatives === undefined
      ? { why: NO_ALTERNATIVES }
      : { alternatives: result.alternatives };
  } catch {
    return { why: NO_ANSWER_TO_DRAG };
  }
}

/** Sends a scene's file to the server, which keeps it under `name`, or where that is empty under the file's own. */
export function sendScene(token: string, file: Blob, name: string, events: SendingEvents): () => void {
  // `fetch` does not tell how much has gone.
  const request = new XMLHttpRequest();
  request.open("POST", name === "" ? "/assets" : `/assets?name=${encodeURIComponent(name)}`);
  request.setRequestHeader("authorization", `Bearer ${token}`);
  request.upload.onprogress = ({ loaded, total }) => events.progress(loaded, total);
  request.upload.onload = events.sent;
  request.onload = () => {
    const { asset, error } = answerOf(request.responseText);
    if (request.status === 201 && asset !== undefined) events.kept(asset);
    else events.failed(error?.message ?? `The server answered with ${request.status}: try again.`);
  };
  request.onerror = () => events.failed(BROKEN);
  request.send(file);
  return () => request.abort();
}

function answerOf(text: string): { asset?: string; error?: { message: string } } {
  try {
    return JSON.parse(text) as ReturnType<typeof answerOf>;
  } catch {
    // Something between here and the server has answered.
    return {};
  }
}

const BROKEN =
  "The connection broke while it was sent, or a file was changed meanwhile. The server has kept nothing of it: try again.";
const NO_ALTERNATIVES = "The server knows no other answers: it is an older one";
const NO_ANSWER_TO_DRAG = "The server does not answer: try again";
const NO_ANSWER =
  "The server does not answer, so the page cannot know what can be set on lights. Try again once it does.";
const OLD_SERVER =
  "The server does not say what can be set on lights, as this page needs: it is an older one. Start the one that the page came with.";
