// Starts the page.

import { effect } from "@preact/signals";
import { render } from "preact";

import { startSession } from "../core/session";
import { readAddress } from "./address";
import type { Camera, ParameterTable } from "../core/protocol";
import { App, Refusal, SignIn } from "./app";
import { browserHost, fetchNodes, fetchTable, pickPoint } from "./host";
import { keepPage, restorePage } from "./kept";
import { bindKeys } from "./keys";
import { PageProvider, startPage, startToasts } from "./page";
import { keepActor, readActor } from "./person";
import { canvasScreen } from "./screen";
import "./style/page.css";
import "./style/fields.css";
import "./style/panels.css";
import "./style/viewport.css";
import "./style/directing.css";
import "./style/tools.css";
import "./style/layout.css";

const root = document.getElementById("page") as HTMLElement;
const { token, session: name } = readAddress();
addEventListener("hashchange", () => location.reload());

if (token === "") {
  render(<SignIn />, root);
} else {
  void open();
}

/** Nothing can be shown of a document before it is known what stands in it. */
async function open(): Promise<void> {
  const answer = await fetchTable(token);
  render(null, root);
  if ("table" in answer) start(answer.table);
  else if (answer.isTokenWrong) render(<SignIn why={answer.why} />, root);
  else render(<Refusal why={answer.why} again={() => void open()} />, root);
}

function start(table: ParameterTable): void {
  const toasts = startToasts();
  const host = browserHost();
  const screen = canvasScreen();
  const session = startSession({
    host,
    token,
    session: name,
    table,
    actor: readActor(),
    screen,
    notify: toasts.add,
  });
  const page = startPage({
    host,
    session,
    screen,
    name,
    pick: (camera: Camera) => pickPoint(token, name, camera),
    toasts,
    fetchNodes: () => fetchNodes(token, name),
  });
  effect(() => keepActor(session.actor.value));
  effect(() => {
    document.title = `${name} - BendyLights`;
    showState(root);
  });
  restorePage(page);
  bindKeys(page);
  // A page that goes takes its drags with it, but for what was done.
  addEventListener("pagehide", page.presses.commit);
  addEventListener("pagehide", () => keepPage(page));
  addEventListener("online", session.wake);
  document.addEventListener("visibilitychange", () => document.hidden || session.wake());
  render(
    <PageProvider value={page}>
      <App />
    </PageProvider>,
    root,
  );

  /** What tests and people with developer tools can read off the page's root element. */
  function showState({ dataset }: HTMLElement): void {
    const { seq, hash, pictureSeq } = session.mirror.value;
    const frame = session.frame.value;
    dataset.connection = session.connection.value.kind;
    dataset.client = String(session.client.value ?? "");
    dataset.seq = String(seq);
    dataset.hash = hash;
    dataset.pictureSeq = String(pictureSeq);
    dataset.frame = String(frame?.frame ?? 0);
    dataset.frameLogSeq = String(frame?.logSeq ?? 0);
    dataset.frameSettle = String(frame?.settle ?? false);
    dataset.following = String(session.viewer.following.value ?? "");
    dataset.cameraRevision = String(session.viewer.revision.value);
    dataset.frameCameraRevision = String(frame?.cameraRevision ?? 0);
    dataset.liveRevision = String(frame?.liveRevision ?? 0);
    dataset.camera = JSON.stringify(session.viewer.own.value?.camera ?? null);
    dataset.latencyMs = String(session.statistics.value.latencyMs ?? "");
  }
}
