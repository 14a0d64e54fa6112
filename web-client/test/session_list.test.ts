import { expect, test } from "vitest";

import type { SessionEntry } from "../src/core/protocol";
import {
  agoText,
  changeText,
  clippable,
  copyTitle,
  freeTitle,
  latestFirst,
  matching,
  nameFor,
  peopleText,
} from "../src/core/session_list";

const entry = (name: string, more: Partial<SessionEntry> = {}): SessionEntry => ({
  name,
  title: name,
  epoch: "0".repeat(32),
  seq: 1,
  clients: 0,
  people: [],
  archived: false,
  madeMs: null,
  changed: null,
  ...more,
});

const MINUTE = 60_000;

test("a name in addresses is made of a title, and a number tells those of one title apart", () => {
  expect(nameFor("Shot 010 / Évening", 1)).toBe("shot-010-evening");
  expect(nameFor("Shot 010 / Évening", 3)).toBe("shot-010-evening-3");
  expect(nameFor("  ...夜", 1)).toBe("session");
  expect(nameFor("v1.2_final-", 1)).toBe("v1.2_final");
  // Titles that the server accepts, SPEC HTTP-4.
  for (const title of ["-a", "_.b", "x".repeat(200), "Ä ".repeat(50), "", "100 %"]) {
    expect(nameFor(title, 100)).toMatch(/^[a-zA-Z0-9][a-zA-Z0-9._-]{0,63}$/);
  }
});

test("titles that are new are no other session's", () => {
  const taken = new Set(["Untitled", "Untitled 2", "Shot", "Shot copy"]);
  expect(freeTitle("Untitled", taken)).toBe("Untitled 3");
  expect(copyTitle("Shot", taken)).toBe("Shot copy 2");
  expect(copyTitle("Shot copy", taken)).toBe("Shot copy 2");
  expect(copyTitle("Other copy 7", taken)).toBe("Other copy");
  const long = copyTitle("夜".repeat(85), new Set());
  expect(new TextEncoder().encode(long).length).toBeLessThanOrEqual(256);
  expect(long.endsWith("夜 copy")).toBe(true);
});

test("how long ago it was is told in words", () => {
  const now = Date.UTC(2026, 10, 26, 12);
  const ago = (minutes: number) => agoText(now - minutes * MINUTE, now);
  expect([0.9, 1, 3.9, 59.9].map(ago)).toEqual([
    "just now",
    "a minute ago",
    "3 minutes ago",
    "59 minutes ago",
  ]);
  expect([60, 150, 24 * 60 - 1].map(ago)).toEqual(["an hour ago", "2 hours ago", "23 hours ago"]);
  expect([24 * 60, 29 * 24 * 60].map(ago)).toEqual(["a day ago", "29 days ago"]);
  expect(ago(30 * 24 * 60)).toBe("2026-10-27");
  expect(agoText(now + MINUTE, now), "another clock is ahead").toBe("just now");
});

test("what changed last is told with who did it, or when the session was made", () => {
  const now = 10 * MINUTE;
  const changed = { timeMs: 7 * MINUTE, actor: "Ada" };
  expect(changeText(entry("a", { changed }), now)).toBe("3 minutes ago by Ada");
  expect(changeText(entry("a", { madeMs: 5 * MINUTE }), now)).toBe("made 5 minutes ago");
  expect(changeText(entry("a"), now)).toBe("not edited yet");
});

test("the latest come first", () => {
  const changed = (timeMs: number) => ({ changed: { timeMs, actor: "Ada" } });
  const list = [
    entry("b"),
    entry("a"),
    entry("old", changed(5)),
    entry("made", { madeMs: 9 }),
    entry("new", changed(11)),
  ];
  expect(latestFirst(list).map(({ name }) => name)).toEqual(["new", "made", "old", "a", "b"]);
});

test("sessions are found by any words of title and name", () => {
  const list = [entry("shot-010", { title: "Küche, abends" }), entry("shot-020"), entry("other")];
  const found = (wanted: string) => matching(list, wanted).map(({ name }) => name);
  expect(found("  ")).toEqual(["shot-010", "shot-020", "other"]);
  expect(found("SHOT")).toEqual(["shot-010", "shot-020"]);
  expect(found("abends shot")).toEqual(["shot-010"]);
  expect(found("020 abends")).toEqual([]);
});

test("people are told as far as there is room", () => {
  expect(peopleText([])).toBe("");
  expect(peopleText(["Ada"])).toBe("Ada");
  expect(peopleText(["Ada", "Bob"])).toBe("Ada and Bob");
  expect(peopleText(["Ada", "Bob", "Cy", "Di"])).toBe("Ada and 3 others");
});

test("a long name keeps its end, and all of it is there", () => {
  expect(clippable("Shot 10")).toEqual(["Shot 10", ""]);
  const name = "sequence-12-interior-night-shot-010-v3";
  const [start, end] = clippable(name);
  expect(start + end).toBe(name);
  expect(end).toBe("hot-010-v3");
  expect(clippable("👩‍🎨".repeat(12)).join("")).toBe("👩‍🎨".repeat(12));
});
