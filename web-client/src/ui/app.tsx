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
  const { session } = usePage();
  const state = session.connection.value;
  return (
    <>
      <div class="app" inert={state.kind === "refused"}>
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
      {state.kind === "refused" && <Refusal why={state.message} again={session.reconnect} />}
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

interface RefusalProps {
  why: string;
  again(): void;
}

/** Over everything: the server said no, and trying again by itself would be no use. */
export function Refusal({ why, again }: RefusalProps) {
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => button.current?.focus(), []);
  return (
    <div
      class="refusal"
      role="alertdialog"
      aria-modal="true"
      aria-label="The page is not connected"
      aria-describedby="refusal"
    >
      <p id="refusal">{sentence(why)}</p>
      <button class="solid" ref={button} onClick={again}>
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
