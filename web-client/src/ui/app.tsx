// The page's parts.

import { useEffect, useRef } from "preact/hooks";

import { addressOf, signIn } from "./address";
import { CameraList } from "./camera_list";
import { DropTarget } from "./drop_target";
import { KeyList, SESSION_KEYS } from "./key_list";
import { LightList } from "./light_list";
import { LightPanel } from "./light_panel";
import { OpeningPanel } from "./opening_panel";
import { usePage } from "./page";
import { RemovalQuestion } from "./removing";
import { MENU_BUTTON } from "./scene_menu";
import { sentence } from "./sentence";
import { StatusBar } from "./status_bar";
import { Toasts } from "./toasts";
import { TopBar } from "./top_bar";
import { Viewport } from "./viewport";

export function App() {
  const page = usePage();
  const { session } = page;
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
        <div class="corner">
          <OpeningPanel opener={MENU_BUTTON} />
          <Toasts toasts={page.toasts} />
        </div>
        <KeyList shown={page.showKeys} keys={SESSION_KEYS} />
        <RemovalQuestion />
        <DropTarget />
      </div>
      {state.kind === "refused" && <Refusal why={state.message} again={session.reconnect} />}
    </>
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
      <a class="quiet" href={addressOf(null)}>
        All sessions
      </a>
    </div>
  );
}

interface SignInProps {
  /** Message of the server about the last token; none before the first. */
  why?: string;
}

/** In place of everything: the page knows no token, or a wrong one. */
export function SignIn({ why }: SignInProps) {
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), []);
  const submit = (event: Event) => {
    event.preventDefault();
    signIn(field.current?.value ?? "");
  };
  return (
    <main class="refusal">
      <h1>BendyLights</h1>
      {why !== undefined && <p role="alert">{sentence(why)}</p>}
      <form class="sign-in" onSubmit={submit}>
        <input
          ref={field}
          class="text"
          type="password"
          aria-label="Token"
          placeholder="Token"
          autocomplete="current-password"
          required
        />
        <button class="solid">Sign in</button>
      </form>
      <p>
        The token is in the address that <code>bendylights serve</code> prints, after <code>#token=</code>,
        and in the file <code>token</code> of the server's data folder.
      </p>
    </main>
  );
}
