// The nodes of the scene as a tree that is filtered and opened, for what is made of nodes.

import { useId, useMemo, useRef, useState } from "preact/hooks";

import { filtered, rowsOf, treeOf, type TreeNode, type TreeRow } from "../core/node_tree";
import { Icon } from "./icons";
import { Name } from "./name";
import { usePage } from "./page";

/** Rows past which the filter has to be narrowed. */
const MOST_ROWS = 400;

interface NodeListProps {
  label: string;
  /** Tag of a chosen node; `undefined` for others. */
  tagOf(path: string): string | undefined;
  disabled: boolean;
  /** Takes a node, or a path that was typed and may name none. */
  choose(path: string): void;
}

/** A filter, and below it the nodes: arrows go through them and open them, Enter chooses. */
export function NodeList({ label, tagOf, disabled, choose }: NodeListProps) {
  const nodes = usePage().nodes.value;
  const paths = nodes?.paths;
  const [text, setText] = useState("");
  const [note, setNote] = useState<string | null>(null);
  const noteId = useId();
  const list = useRef<HTMLDivElement>(null);
  const tree = useMemo(() => treeOf(paths ?? []), [paths]);
  const [folds, setFolds] = useState<{ [path: string]: boolean }>({});
  const found = useMemo(() => filtered(tree, text), [tree, text]);
  // Matches of a search are visible; so are the children of a single root.
  const isOpen = ({ path, children }: TreeNode) =>
    folds[path] ??
    (children.length > 0 && (text.trim() !== "" || (tree.length === 1 && tree[0]?.path === path)));
  const rows = rowsOf(found, isOpen);
  const shown = rows.slice(0, MOST_ROWS);
  const [current, setCurrent] = useState("");
  const tabbed = shown.some(({ node }) => node.path === current) ? current : shown[0]?.node.path;

  const submit = () => {
    const typed = text.trim();
    if (typed === "") return;
    // If not every node is listed, the typed path may be valid although the list lacks it.
    if (paths === undefined || paths.includes(typed) || nodes?.leftOut !== 0) {
      choose(typed);
      setText("");
    } else setNote(`“${typed}” names nothing in this scene: pick one of the list`);
  };
  const go = (path: string | undefined) => {
    if (path === undefined) return;
    [...(list.current?.querySelectorAll<HTMLElement>(".node") ?? [])]
      .find(({ dataset }) => dataset.path === path)
      ?.focus();
  };
  const fold = ({ path }: TreeNode, open: boolean) => setFolds((others) => ({ ...others, [path]: open }));
  const press = (event: KeyboardEvent, row: TreeRow, k: number) => {
    const task = taskFor(event.key, { shown, row, k, go, fold, choose: disabled ? () => {} : choose });
    if (task === null || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    task();
  };
  return (
    <div class="nodes">
      <input
        class="text"
        type="search"
        aria-label={`${label}: find nodes`}
        placeholder="find nodes"
        value={text}
        aria-invalid={note !== null}
        aria-describedby={note === null ? undefined : noteId}
        onInput={(event) => {
          setNote(null);
          setFolds({});
          setText(event.currentTarget.value);
        }}
        onKeyDown={(event) => {
          if (event.key === "Enter") submit();
          else if (event.key === "ArrowDown") go(tabbed);
          else if (event.key === "Escape") {
            setNote(null);
            setText("");
          } else return;
          event.preventDefault();
        }}
      />
      {note !== null && (
        <p class="path-note" id={noteId} role="status">
          {note}
        </p>
      )}
      {shown.length > 0 ? (
        <div class="node-tree" role="tree" aria-label={`${label}: nodes`} ref={list}>
          {shown.map((row, k) => (
            <NodeRow
              key={row.node.path}
              row={row}
              tag={tagOf(row.node.path)}
              isTabbed={row.node.path === tabbed}
              disabled={disabled}
              fold={fold}
              choose={choose}
              press={(event) => press(event, row, k)}
              focused={() => setCurrent(row.node.path)}
            />
          ))}
        </div>
      ) : (
        <p class="hint">
          {paths === undefined ? "The nodes are not known: type a path." : "No node is called so."}
        </p>
      )}
      {rows.length > MOST_ROWS && (
        <p class="hint">and {rows.length - MOST_ROWS} more: say more of the name above.</p>
      )}
    </div>
  );
}

interface Keys {
  shown: readonly TreeRow[];
  row: TreeRow;
  /** The row's place among those that are shown. */
  k: number;
  go(path: string | undefined): void;
  fold(node: TreeNode, open: boolean): void;
  choose(path: string): void;
}

/** Task of a key at a row, as in every tree. */
function taskFor(key: string, { shown, row, k, go, fold, choose }: Keys): (() => void) | null {
  const { node, open, level } = row;
  switch (key) {
    case "ArrowDown":
      return () => go(shown[k + 1]?.node.path);
    case "ArrowUp":
      return () => go(shown[k - 1]?.node.path);
    case "Home":
      return () => go(shown[0]?.node.path);
    case "End":
      return () => go(shown.at(-1)?.node.path);
    case "ArrowRight":
      if (open === true) return () => go(shown[k + 1]?.node.path);
      return open === false ? () => fold(node, true) : null;
    case "ArrowLeft": {
      if (open === true) return () => fold(node, false);
      const above = shown.slice(0, k).findLast((other) => other.level < level);
      return () => go(above?.node.path);
    }
    case "Enter":
    case " ":
      return () => choose(node.path);
    default:
      return null;
  }
}

interface NodeRowProps {
  row: TreeRow;
  tag: string | undefined;
  isTabbed: boolean;
  disabled: boolean;
  fold(node: TreeNode, open: boolean): void;
  choose(path: string): void;
  press(event: KeyboardEvent): void;
  focused(): void;
}

function NodeRow({ row, tag, isTabbed, disabled, fold, choose, press, focused }: NodeRowProps) {
  const { node, level, open, position, siblings } = row;
  return (
    <div
      class="node"
      role="treeitem"
      data-path={node.path}
      aria-level={level}
      aria-posinset={position}
      aria-setsize={siblings}
      aria-expanded={open ?? undefined}
      aria-selected={tag !== undefined}
      aria-disabled={disabled}
      tabIndex={isTabbed ? 0 : -1}
      style={{ paddingLeft: `${Math.min(level - 1, DEEPEST) * INDENT_PX}px` }}
      onFocus={focused}
      onKeyDown={press}
      onClick={() => disabled || choose(node.path)}
    >
      {/* biome-ignore lint/a11y/noStaticElementInteractions: arrow keys do it too */}
      {/* biome-ignore lint/a11y/useKeyWithClickEvents: arrow keys do it too */}
      <span
        class="node-fold"
        onClick={(event) => {
          event.stopPropagation();
          // A leaf is chosen wherever it is pressed.
          if (open !== null) fold(node, !open);
          else if (!disabled) choose(node.path);
        }}
      >
        {open !== null && <Icon name="fold" />}
      </span>
      <Name name={node.name} title={node.path} />
      {tag !== undefined && <span class="node-tag">{tag}</span>}
    </div>
  );
}

const INDENT_PX = 12;
/** Deeper levels are indented no further: their names need the room. */
const DEEPEST = 8;
