// The nodes of the scene that count for a light: those to include, and those to exclude.

import { useState } from "preact/hooks";

import { type LinkList, type LinksValue, pathsOf, withPaths } from "../core/links";
import type { Parameter } from "../core/protocol";
import { type Binding, through } from "./binding";
import type { FieldProps } from "./fields";
import { Icon } from "./icons";
import { toggleLinking } from "./linking";
import { Name } from "./name";
import { NodeList } from "./node_list";
import { usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { Row } from "./row";

const LISTS: readonly { list: LinkList; tag: string; none: string; title: string }[] = [
  { list: "include", tag: "Only", none: "all", title: "What is chosen counts, and nothing else" },
  { list: "exclude", tag: "Not", none: "none", title: "What is chosen does not count" },
];

/** Chosen nodes, and buttons to choose more: in the tree of nodes, or in the picture. */
export function LinksField({ row, ...props }: FieldProps<LinksValue> & { row: Parameter }) {
  const page = usePage();
  const { label, doc, value, binding, disabled } = props;
  const { linking, selectedLight } = page;
  const [list, setList] = useState<LinkList>("include");
  const [isOpen, setOpen] = useState(false);
  const set = (paths: readonly string[]) => binding.set(withPaths(value, list, paths));
  const toggle = (path: string) => {
    const paths = pathsOf(value, list);
    set(paths.includes(path) ? paths.filter((other) => other !== path) : [...paths, path]);
  };
  const tagOf = (path: string) => LISTS.find((each) => pathsOf(value, each.list).includes(path))?.tag;
  const light = selectedLight.value;
  const picks = linking.value?.light === light && linking.value?.row.name === row.name;
  const choose = (next: LinkList) => {
    setList(next);
    if (picks && light !== null) toggleLinking(page, light, row, next);
  };
  return (
    <Row {...props}>
      <div class="links">
        {LISTS.map((each) => (
          <Paths
            key={each.list}
            {...each}
            label={`${label}: ${each.tag.toLowerCase()}`}
            paths={pathsOf(value, each.list)}
            binding={through(binding, (paths: readonly string[]) => withPaths(value, each.list, paths))}
            disabled={disabled}
          />
        ))}
        <div class="links-tools">
          <div class="toggle" role="group" aria-label={`${label}: what is chosen next`}>
            {LISTS.map(({ list: each, tag, title }) => (
              <button
                key={each}
                title={title}
                aria-label={`${label}: ${tag.toLowerCase()}`}
                aria-pressed={list === each}
                onClick={() => choose(each)}
              >
                {tag}
              </button>
            ))}
          </div>
          <QuietButton
            title={`Choose nodes. ${doc ?? ""}`}
            label={`${label}: choose nodes`}
            expanded={isOpen}
            press={() => setOpen(!isOpen)}
          >
            <Icon name="fold" /> Nodes
          </QuietButton>
          <QuietButton
            title="Click objects in the picture (Escape ends it)"
            label={`${label}: pick in the picture`}
            pressed={picks}
            disabled={disabled || light === null}
            press={() => light !== null && toggleLinking(page, light, row, list)}
          >
            <Icon name="aim" />
          </QuietButton>
        </div>
        {isOpen && <NodeList label={label} tagOf={tagOf} disabled={disabled} choose={toggle} />}
      </div>
    </Row>
  );
}

interface PathsProps {
  label: string;
  /** Before the paths. */
  tag: string;
  /** Meaning of an empty list. */
  none: string;
  paths: readonly string[];
  binding: Binding<readonly string[]>;
  disabled: boolean;
}

function Paths({ label, tag, none, paths, binding, disabled }: PathsProps) {
  return (
    <div class="path-list" role="group" aria-label={label}>
      <span class="path-tag">{tag}</span>
      {paths.length === 0 && <span class="path-none">{none}</span>}
      {paths.map((path) => (
        <Path
          key={path}
          path={path}
          label={label}
          disabled={disabled}
          remove={() => binding.set(paths.filter((other) => other !== path))}
        />
      ))}
    </div>
  );
}

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
    <span class="path" data-missing={isMissing}>
      <Name name={path} title={path + missing} />
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
