// Texts of the list of sessions, and names of new ones.

import type { SessionEntry } from "./protocol";

const LONGEST_NAME = 64;
/** Room for a number behind a name that is taken. */
const LONGEST_STEM = LONGEST_NAME - 4;
const LONGEST_TITLE_BYTES = 256;
/** Bytes of " copy" and a number. */
const ROOM_FOR_COPY = 16;

/** Title of a session without one. */
export const UNTITLED = "Untitled";

/** The latest change first; what has none by when it was made. */
export function latestFirst(sessions: readonly SessionEntry[]): SessionEntry[] {
  const timeOf = ({ changed, madeMs }: SessionEntry) => changed?.timeMs ?? madeMs ?? 0;
  return [...sessions].sort((a, b) => timeOf(b) - timeOf(a) || (a.name < b.name ? -1 : 1));
}

/** Those whose title or name has all words of `wanted`. */
export function matching(sessions: readonly SessionEntry[], wanted: string): readonly SessionEntry[] {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return sessions;
  return sessions.filter(({ title, name }) => {
    const text = `${title} ${name}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** The name in addresses of a session with that title; try `attempt` (from 1) where those before are taken. */
export function nameFor(title: string, attempt: number): string {
  const plain = title
    .normalize("NFKD")
    .replace(/\p{M}/gu, "")
    .toLowerCase()
    .replace(/[^a-z0-9._-]+/g, "-")
    .replace(/^[-_.]+/, "");
  const stem = plain.slice(0, LONGEST_STEM).replace(/[-_.]+$/, "") || "session";
  return attempt === 1 ? stem : `${stem}-${attempt}`;
}

/** A title that none of `titles` is: `wanted`, or with a number behind it. */
export function freeTitle(wanted: string, titles: ReadonlySet<string>): string {
  for (let number = 1; ; number += 1) {
    const title = number === 1 ? wanted : `${wanted} ${number}`;
    if (!titles.has(title)) return title;
  }
}

/** Title of a copy of `title` beside `titles`: "Shot copy", then "Shot copy 2", also of a copy. */
export function copyTitle(title: string, titles: ReadonlySet<string>): string {
  return freeTitle(`${clipBytes(title.replace(/ copy( \d+)?$/, ""))} copy`, titles);
}

/** Shortens a title so that there is room for a suffix. */
function clipBytes(title: string): string {
  let bytes = 0;
  const fits = [...title].filter((letter) => {
    bytes += bytesOf(letter.codePointAt(0) ?? 0);
    return bytes <= LONGEST_TITLE_BYTES - ROOM_FOR_COPY;
  });
  return fits.join("").trimEnd();
}

/** Number of bytes of a letter in UTF-8. */
const bytesOf = (code: number) => (code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4);

const MINUTE_MS = 60_000;
const HOUR_MS = 60 * MINUTE_MS;
const DAY_MS = 24 * HOUR_MS;

const several = (count: number, what: string) => (count === 1 ? `a ${what}` : `${count} ${what}s`);

/** Age of a moment, both in milliseconds since 1970; past a month the day. */
export function agoText(timeMs: number, nowMs: number): string {
  const ago = nowMs - timeMs;
  if (ago < MINUTE_MS) return "just now";
  if (ago < HOUR_MS) return `${several(Math.floor(ago / MINUTE_MS), "minute")} ago`;
  if (ago < DAY_MS) return `${several(Math.floor(ago / HOUR_MS), "hour")} ago`.replace("a hour", "an hour");
  if (ago < 30 * DAY_MS) return `${several(Math.floor(ago / DAY_MS), "day")} ago`;
  return new Date(timeMs).toISOString().slice(0, 10);
}

/** When a session was last changed and by whom. */
export function changeText({ changed, madeMs }: SessionEntry, nowMs: number): string {
  if (changed !== null) return `${agoText(changed.timeMs, nowMs)} by ${changed.actor}`;
  return madeMs === null ? "not edited yet" : `made ${agoText(madeMs, nowMs)}`;
}

/** Names of the people in a session, as many as fit in a line. */
export function peopleText(people: readonly string[]): string {
  const [first, second, ...others] = people;
  if (first === undefined) return "";
  if (second === undefined) return first;
  return others.length === 0 ? `${first} and ${second}` : `${first} and ${others.length + 1} others`;
}

/** The end of a name that stays where its middle is clipped: numbers of shots and versions stand there. */
const KEPT_END = 10;

/** A name in two parts, of which the first may be clipped. */
export function clippable(name: string): [start: string, end: string] {
  const letters = [...name];
  const cut = letters.length > 2 * KEPT_END ? letters.length - KEPT_END : letters.length;
  return [letters.slice(0, cut).join(""), letters.slice(cut).join("")];
}
