// The nodes of a scene as a tree, made of their paths (SPEC, LINK-1).

export interface TreeNode {
  path: string;
  /** The last name of its path, as people read it. */
  name: string;
  children: TreeNode[];
}

/** A node as a list shows it. */
export interface TreeRow {
  node: TreeNode;
  /** From 1. */
  level: number;
  /** True if the children are visible; `null` if there are none. */
  open: boolean | null;
  /** Among how many siblings it is which, from 1. */
  position: number;
  siblings: number;
}

/** Names in paths have these for characters that paths need themselves. */
const WRITTEN: { [code: string]: string } = { "~0": "~", "~1": "/", "~2": "#" };

/** The names of a path. */
export const namesOf = (path: string): string[] =>
  path.split("/").map((name) => name.replace(/~[012]/g, (code) => WRITTEN[code] ?? code));

/** The last name of a path, as people read it. */
export const nodeName = (path: string): string => namesOf(path).at(-1) ?? path;

/** The roots of the tree, in the order of the paths; nodes that no path names, but that paths lead through, are in it too. */
export function treeOf(paths: readonly string[]): TreeNode[] {
  const roots: TreeNode[] = [];
  const known = new Map<string, TreeNode>();
  const nodeAt = (path: string): TreeNode => {
    const there = known.get(path);
    if (there !== undefined) return there;
    const node = { path, name: nodeName(path), children: [] };
    known.set(path, node);
    const above = path.lastIndexOf("/");
    (above < 0 ? roots : nodeAt(path.slice(0, above)).children).push(node);
    return node;
  };
  for (const path of paths) nodeAt(path);
  return roots;
}

/** Filters the tree by `text` in paths, in any case, and keeps the ancestors of matches; an empty text keeps all. */
export function filtered(roots: readonly TreeNode[], text: string): TreeNode[] {
  const wanted = text.trim().toLowerCase();
  if (wanted === "") return [...roots];
  return roots.flatMap((node) => {
    // Descendants of a match may be needed, too.
    if (node.path.toLowerCase().includes(wanted)) return [node];
    const children = filtered(node.children, text);
    return children.length === 0 ? [] : [{ ...node, children }];
  });
}

/** The rows of the tree, of which those nodes are open that `isOpen` says. */
export function rowsOf(
  roots: readonly TreeNode[],
  isOpen: (node: TreeNode) => boolean,
  level = 1,
): TreeRow[] {
  return roots.flatMap((node, k) => {
    const open = node.children.length === 0 ? null : isOpen(node);
    const row = { node, level, open, position: k + 1, siblings: roots.length };
    return [row, ...(open === true ? rowsOf(node.children, isOpen, level + 1) : [])];
  });
}
