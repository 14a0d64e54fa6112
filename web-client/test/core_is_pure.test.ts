// core/ must run without a page: no DOM, nothing of ui/.

import { readdirSync, readFileSync } from "node:fs";
import { expect, test } from "vitest";

const FORBIDDEN =
  /\b(document\.(body|head|createElement|getElementById|querySelector|addEventListener)|window\b|HTMLElement|localStorage|sessionStorage|navigator\.|from "(\.\.\/ui|preact))/;

/** Lines of `source` that reach for the page. */
const impurities = (source: string): string[] => source.split("\n").filter((line) => FORBIDDEN.test(line));

test("core knows neither the DOM nor the ui", () => {
  const folder = new URL("../src/core/", import.meta.url);
  const files = readdirSync(folder).filter((name) => name.endsWith(".ts"));
  expect(files.length).toBeGreaterThan(10);
  for (const name of files) {
    expect(impurities(readFileSync(new URL(name, folder), "utf8")), name).toEqual([]);
  }
});

test("planted violations are caught", () => {
  expect(impurities('document.getElementById("page");')).toHaveLength(1);
  expect(impurities("window.open();")).toHaveLength(1);
  expect(impurities('import { App } from "../ui/app";')).toHaveLength(1);
  expect(impurities('import { render } from "preact";')).toHaveLength(1);
});
