// The nodes of the scene that count for a light: those to include, and those to exclude.

import { useId, useState } from "preact/hooks";

import { type LinkList, type LinksValue, pathsOf, withPaths } from "../core/links";
import { type Binding, through } from "./binding";
import type { FieldProps } from "./fields";
import { Icon } from "./icons";
import { usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { Row } from "./row";

const LISTS: { list: LinkList; label: string; hint: string }[] = [
  { list: "include", label: "Only", hint: "all" },
  { list: "exclude", label: "Not", hint: "none" },
];

/** Two lists of nodes' paths, each with a field that offers those of the scene. */
export function LinksField(props: FieldProps<LinksValue>) {
  const { label, value, binding, disabled } = props;
  const nodes = useId();
  return (
    <Row {...props}>
      <div class="links">
        {LISTS.map(({ list, label: name, hint }) => (
          <PathList
            key={list}
            label={`${label}: ${name.toLowerCase()}`}
            tag={name}
            hint={hint}
            doc={props.doc}
            paths={pathsOf(value, list)}
            binding={through(binding, (paths: readonly string[]) => withPaths(value, list, paths))}
            nodes={nodes}
            disabled={disabled}
          />
        ))}
        <datalist id={nodes}>
          {usePage().nodes.value?.paths.map((path) => (
            <option key={path} value={path} />
          ))}
        </datalist>
      </div>
    </Row>
  );
}

interface PathListProps {
  label: string;
  /** Before the field. */
  tag: string;
  /** What it means that there is no path. */
  hint: string;
  doc?: string | undefined;
  paths: readonly string[];
  binding: Binding<readonly string[]>;
  /** The id of the list of what can be picked. */
  nodes: string;
  disabled: boolean;
}

function PathList({ label, tag, hint, doc, paths, binding, nodes, disabled }: PathListProps) {
  const nodesHere = usePage().nodes.value;
  const known = nodesHere?.paths ?? [];
  const noteId = useId();
  /** What was typed and names nothing. */
  const [refused, setRefused] = useState<string | null>(null);
  const add = (input: HTMLInputElement) => {
    const path = input.value.trim();
    // A light that is to light nothing but what is not there would light nothing.
    if (path !== "" && nodesHere?.leftOut === 0 && !known.includes(path)) {
      setRefused(path);
      return;
    }
    input.value = "";
    if (path !== "" && !paths.includes(path)) binding.set([...paths, path]);
  };
  return (
    <div class="path-list">
      <span class="path-tag">{tag}</span>
      {paths.map((path) => (
        <Path
          key={path}
          path={path}
          label={label}
          disabled={disabled}
          remove={() => binding.set(paths.filter((other) => other !== path))}
        />
      ))}
      <input
        class="text"
        aria-label={label}
        title={doc}
        list={nodes}
        placeholder={paths.length === 0 ? hint : "more"}
        disabled={disabled}
        aria-invalid={refused !== null}
        aria-describedby={refused === null ? undefined : noteId}
        onInput={(event) => {
          setRefused(null);
          if (isPick(event)) add(event.currentTarget);
        }}
        onKeyDown={(event) => {
          if (event.key === "Enter") add(event.currentTarget);
          if (event.key !== "Escape") return;
          setRefused(null);
          event.currentTarget.value = "";
        }}
        // What was only begun is no path.
        onBlur={(event) => known.includes(event.currentTarget.value.trim()) && add(event.currentTarget)}
      />
      {refused !== null && (
        <p class="path-note" id={noteId} role="status">
          “{refused}” names nothing in this scene: pick one of the list
        </p>
      )}
    </div>
  );
}

/** Whether a whole path came at once, from the list. */
const isPick = (event: Event): boolean =>
  !(event instanceof InputEvent) || event.inputType === "insertReplacementText";

interface PathProps {
  path: string;
  label: string;
  disabled: boolean;
  remove(): void;
}

function Path({ path, label, disabled, remove }: PathProps) {
  const nodes = usePage().nodes.value;
  const isMissing = nodes !== null && nodes.leftOut === 0 && !nodes.paths.includes(path);
  const missing = isMissing ? " names nothing in this scene and has no effect" : "";
  return (
    <span class="path" data-missing={isMissing} title={path + missing}>
      <span class="clipped">{path}</span>
      <QuietButton
        title={`Take ${path} out`}
        label={`Take ${path} out of ${label}${missing === "" ? "" : `: it${missing}`}`}
        disabled={disabled}
        press={remove}
      >
        <Icon name="close" />
      </QuietButton>
    </span>
  );
}
