// A new session: what it is called and the scene that it begins with.

import { useEffect, useRef, useState } from "preact/hooks";

import { sentence } from "../sentence";
import { useFront } from "./front";

const EMPTY = "empty";

export function NewSession() {
  const { making, demos, create } = useFront();
  const dialog = useRef<HTMLDialogElement>(null);
  const isShown = making.value;
  useEffect(() => {
    if (isShown) dialog.current?.showModal();
    else dialog.current?.close();
  }, [isShown]);
  const close = () => (making.value = false);
  return (
    <dialog class="front-dialog" ref={dialog} aria-labelledby="new-session" onCancel={close}>
      {isShown && (
        <Form
          scenes={demos.value}
          cancel={close}
          make={(title, scene) => {
            close();
            void create(title, scene);
          }}
        />
      )}
    </dialog>
  );
}

interface FormProps {
  scenes: readonly { scene: string; name: string; shows: string }[];
  cancel(): void;
  make(title: string, scene: string | null): void;
}

function Form({ scenes, cancel, make }: FormProps) {
  const title = useRef<HTMLInputElement>(null);
  const [scene, setScene] = useState(scenes[0]?.scene ?? EMPTY);
  const choices = [
    ...scenes.map(({ scene, name, shows }) => ({
      value: scene,
      name: sentence(name),
      shows: sentence(shows),
    })),
    { value: EMPTY, name: "Empty", shows: "No scene: a program loads one of your own" },
  ];
  const submit = (event: Event) => {
    event.preventDefault();
    make(title.current?.value.trim() ?? "", scene === EMPTY ? null : scene);
  };
  return (
    <form onSubmit={submit}>
      <h2 id="new-session">New session</h2>
      <label class="front-label">
        Name
        <input class="text" ref={title} placeholder="Untitled" maxLength={120} autocomplete="off" />
      </label>
      <fieldset class="front-scenes">
        <legend>Scene</legend>
        {choices.map(({ value, name, shows }) => (
          <label key={value}>
            <input
              type="radio"
              name="scene"
              value={value}
              checked={scene === value}
              onChange={() => setScene(value)}
            />
            <span>
              {name}
              <small>{shows}</small>
            </span>
          </label>
        ))}
      </fieldset>
      <div class="dialog-buttons">
        <button class="solid" type="button" onClick={cancel}>
          Cancel
        </button>
        <button class="solid primary">Create</button>
      </div>
    </form>
  );
}
