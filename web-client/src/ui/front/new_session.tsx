// A new session: what it is called and the scene that it begins with.

import type { Signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import { pickFiles } from "../given_files";
import { useOpening } from "../opening";
import { sentence } from "../sentence";
import { useFront } from "./front";

const EMPTY = "empty";

export function NewSession() {
  const { making, title, demos, create } = useFront();
  const opening = useOpening();
  const dialog = useRef<HTMLDialogElement>(null);
  const isShown = making.value;
  useEffect(() => {
    if (isShown) dialog.current?.showModal();
    else dialog.current?.close();
    title.value = "";
  }, [isShown, title]);
  const close = () => (making.value = false);
  const isOpening = opening.state.value !== null;
  useEffect(() => {
    // A scene was dropped.
    if (isOpening) making.value = false;
  }, [isOpening, making]);
  return (
    <dialog class="front-dialog" ref={dialog} aria-labelledby="new-session" onCancel={close}>
      {isShown && (
        <Form
          title={title}
          scenes={demos.value}
          cancel={close}
          pick={(title, folder) =>
            pickFiles(folder, (given) => {
              close();
              opening.open(given, title);
            })
          }
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
  title: Signal<string>;
  scenes: readonly { scene: string; name: string; shows: string }[];
  cancel(): void;
  make(title: string, scene: string | null): void;
  /** Makes one of files, or of a folder, that a person picks. */
  pick(title: string, folder: boolean): void;
}

function Form({ title, scenes, cancel, make, pick }: FormProps) {
  const [scene, setScene] = useState(scenes[0]?.scene ?? EMPTY);
  const choices = [
    ...scenes.map(({ scene, name, shows }) => ({
      value: scene,
      name: sentence(name),
      shows: sentence(shows),
    })),
    { value: EMPTY, name: "Empty", shows: "No scene yet: you or a program can load one later" },
  ];
  const typed = () => title.value.trim();
  const submit = (event: Event) => {
    event.preventDefault();
    make(typed(), scene === EMPTY ? null : scene);
  };
  return (
    <form onSubmit={submit}>
      <h2 id="new-session">New session</h2>
      <label class="front-label">
        Name
        <input
          class="text"
          placeholder="Untitled"
          maxLength={120}
          autocomplete="off"
          onInput={(event) => (title.value = event.currentTarget.value)}
        />
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
      <div class="front-own" role="group" aria-label="A scene of your own">
        <p>
          Or a scene of your own: a .glb, or a .gltf together with its files. They can be dropped here too.
        </p>
        <button class="solid" type="button" onClick={() => pick(typed(), false)}>
          Pick files
        </button>
        <button class="solid" type="button" onClick={() => pick(typed(), true)}>
          Pick a folder
        </button>
      </div>
      <div class="dialog-buttons">
        <button class="solid" type="button" onClick={cancel}>
          Cancel
        </button>
        <button class="solid primary">Create</button>
      </div>
    </form>
  );
}
