// The page's parts.

import { useEffect, useRef } from "preact/hooks";

import { CameraList } from "./camera_list";
import { KeyList } from "./key_list";
import { LightList } from "./light_list";
import { LightPanel } from "./light_panel";
import { usePage } from "./page";
import { sentence } from "./sentence";
import { StatusBar } from "./status_bar";
import { TopBar } from "./top_bar";
import { Viewport } from "./viewport";

export function App() {
  const refused = usePage().session.connection.value.kind === "refused";
  return (
    <>
      <div class="app" inert={refused}>
        <TopBar />
        <aside class="left" aria-label="Scene">
          <LightList />
          <CameraList />
        </aside>
        <Viewport />
        <aside class="right" aria-label="Parameters">
          <LightPanel />
        </aside>
        <StatusBar />
        <Toasts />
        <KeyList />
      </div>
      {refused && <Refusal />}
    </>
  );
}

function Toasts() {
  const { toasts } = usePage();
  const close = (key: number) => (toasts.value = toasts.value.filter((toast) => toast.key !== key));
  return (
    <div class="toasts" role="log" aria-label="Messages">
      {toasts.value.map(({ key, message }) => (
        <button key={key} class="toast" title="Dismiss" onClick={() => close(key)}>
          {sentence(message)}
        </button>
      ))}
    </div>
  );
}

/** Over everything: the server said no, and trying again by itself would be no use. */
function Refusal() {
  const { session } = usePage();
  const state = session.connection.value;
  const again = useRef<HTMLButtonElement>(null);
  useEffect(() => again.current?.focus(), []);
  if (state.kind !== "refused") return null;
  return (
    <div
      class="refusal"
      role="alertdialog"
      aria-modal="true"
      aria-label="The server refused the connection"
      aria-describedby="refusal"
    >
      <p id="refusal">{sentence(state.message)}</p>
      <button class="solid" ref={again} onClick={session.reconnect}>
        Try again
      </button>
    </div>
  );
}

/** In place of everything: the address lacks the token. */
export function NoToken() {
  return (
    <main class="refusal">
      <h1>BendyLights</h1>
      <p role="alert">
        This address has no token. Open the page with the address that <code>bendylights serve</code> printed:
        it ends in <code>#token=…</code>
      </p>
    </main>
  );
}
