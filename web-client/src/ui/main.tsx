// Starts the page.

import { effect, signal } from "@preact/signals";
import { render } from "preact";

import { type Listed, startSession } from "../core/session";
import { readAddress } from "./address";
import type { Camera, ParameterTable, SessionEntry } from "../core/protocol";
import { App, Refusal, SignIn } from "./app";
import { FrontProvider, startFront } from "./front/front";
import { FrontPage } from "./front/front_page";
import { Refused, serverOf } from "./front/server";
import { browserHost, fetchAlternatives, fetchNodes, fetchTable, pickPoint, sendScene } from "./host";
import { areHintsSeen, keepPage, restorePage } from "./kept";
import { bindKeys } from "./keys";
import { OpeningProvider, type SendScene, startOpening } from "./opening";
import { PageProvider, startPage, startToasts } from "./page";
import { keepActor, readActor } from "./person";
import { watchPins } from "./pin_watch";
import { loadScene, sceneHindrance } from "./scene_loading";
import { canvasScreen } from "./screen";
import "./style/page.css";
import "./style/fields.css";
import "./style/panels.css";
import "./style/viewport.css";
import "./style/directing.css";
import "./style/tools.css";
import "./style/answers.css";
import "./style/layout.css";
import "./style/front.css";
import "./style/forced.css";

const root = document.getElementById("page") as HTMLElement;
const { token, session: named } = readAddress();
const server = serverOf(token);
const send: SendScene = (file, scene, events) => sendScene(token, file, scene, events);
addEventListener("hashchange", () => location.reload());

if (token === "") {
  render(<SignIn />, root);
} else {
  void open();
}

/** The session that the address names or, where it names none that there is, the list of all. */
async function open(): Promise<void> {
  try {
    const entry = named === null ? null : await server.entry(named);
    if (entry === null) await list();
    else await enter(entry);
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    refuse(error.message, error.status === 401);
  }
}

function refuse(why: string, isTokenWrong: boolean): void {
  render(null, root);
  if (isTokenWrong) render(<SignIn why={why} />, root);
  else render(<Refusal why={why} again={() => void open()} />, root);
}

/** Nothing can be shown of a document before it is known what stands in it. */
async function enter({ name, title, archived }: SessionEntry): Promise<void> {
  const answer = await fetchTable(token);
  render(null, root);
  if ("table" in answer) start(answer.table, name, { title, archived });
  else refuse(answer.why, answer.isTokenWrong);
}

async function list(): Promise<void> {
  const sessions = await server.list();
  const toasts = startToasts();
  const front = startFront({ server, sessions, missing: named, actor: readActor(), toasts });
  const opening = startOpening({ send, load: front.begin, hindrance: () => null, say: toasts.add });
  document.title = "BendyLights";
  render(null, root);
  render(
    <FrontProvider value={front}>
      <OpeningProvider value={opening}>
        <FrontPage />
      </OpeningProvider>
    </FrontProvider>,
    root,
  );
  front.demos.value = await server.demos();
}

function start(table: ParameterTable, name: string, asListed: Listed): void {
  const listed = signal(asListed);
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
    listed: ({ title, archived }) => (listed.value = { title, archived }),
  });
  const page = startPage({
    host,
    session,
    screen,
    name,
    listed,
    pick: (camera: Camera) => pickPoint(token, name, camera),
    toasts,
    fetchNodes: () => fetchNodes(token, name),
    fetchAlternatives: (request) => fetchAlternatives(token, name, request),
  });
  const opening = startOpening({
    send,
    load: (asset) => loadScene(page, asset),
    hindrance: () => sceneHindrance(page),
    say: toasts.add,
  });
  effect(() => keepActor(session.actor.value));
  effect(() => {
    // It may have been called otherwise before, or while the page was not connected.
    if (session.connection.value.kind === "connected") void relist();
  });
  effect(() => {
    document.title = `${listed.value.title} - BendyLights`;
    showState(root);
  });
  restorePage(page);
  if (!areHintsSeen()) page.hint.value = 0;
  bindKeys(page);
  watchPins(page, host);
  // A page that goes takes its drags with it, but for what was done.
  addEventListener("pagehide", page.presses.commit);
  addEventListener("pagehide", () => keepPage(page));
  addEventListener("online", session.wake);
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) session.wake();
  });
  render(
    <PageProvider value={page}>
      <OpeningProvider value={opening}>
        <App />
      </OpeningProvider>
    </PageProvider>,
    root,
  );

  async function relist(): Promise<void> {
    const entry = await server.entry(name).catch(() => null);
    if (entry !== null) listed.value = { title: entry.title, archived: entry.archived };
  }

  /** Writes state to the page's root element, for tests and developer tools. */
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
