import { expect, test } from "vitest";

import { filtered, rowsOf, treeOf, type TreeNode } from "../src/core/node_tree";

const PATHS = ["set", "set/table", "set/table/cup~1saucer", "set/table/cup#2", "props/deep/vase", "sun"];

/** The tree as a text: a node, and in brackets what is under it. */
const text = (nodes: readonly TreeNode[]): string =>
  nodes.map(({ name, children }) => (children.length === 0 ? name : `${name}[${text(children)}]`)).join(" ");

test("paths are a tree, with what they lead through", () => {
  const tree = treeOf(PATHS);
  expect(text(tree)).toBe("set[table[cup/saucer cup#2]] props[deep[vase]] sun");
  expect(tree[1]?.children[0]?.path).toBe("props/deep");
  expect(treeOf([])).toEqual([]);
  // A path that comes before the one above it.
  expect(text(treeOf(["a/b", "a", "a/b"]))).toBe("a[b]");
});

test("a filter leaves what leads to what it finds, and what is under it", () => {
  const tree = treeOf(PATHS);
  expect(text(filtered(tree, "VASE"))).toBe("props[deep[vase]]");
  expect(text(filtered(tree, " table "))).toBe("set[table[cup/saucer cup#2]]");
  expect(text(filtered(tree, "set/table/cup#"))).toBe("set[table[cup#2]]");
  expect(filtered(tree, "attic")).toEqual([]);
  expect(text(filtered(tree, " "))).toBe(text(tree));
});

test("only what is open shows what is under it", () => {
  const tree = treeOf(PATHS);
  const shown = (open: string[]) =>
    rowsOf(tree, ({ path }) => open.includes(path)).map(({ node, level, open, position, siblings }) => [
      node.name,
      level,
      open,
      `${position}/${siblings}`,
    ]);
  expect(shown(["set/table"])).toEqual([
    ["set", 1, false, "1/3"],
    ["props", 1, false, "2/3"],
    ["sun", 1, null, "3/3"],
  ]);
  expect(shown(["set"]).slice(0, 2)).toEqual([
    ["set", 1, true, "1/3"],
    ["table", 2, false, "1/1"],
  ]);
});
