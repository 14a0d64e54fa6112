// Cases that the server's tests run too.

import { readFileSync } from "node:fs";

/** The cases of `protocol/vectors/NAME`. */
export function vectors<T>(name: string): T {
  return JSON.parse(readFileSync(new URL(`../../protocol/vectors/${name}`, import.meta.url), "utf8")) as T;
}
