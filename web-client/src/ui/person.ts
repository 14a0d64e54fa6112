// User of this page, and the names and colors of actors.

import type { ClientId } from "../core/ids";
import type { Actor, Presence } from "../core/protocol";
import { newId } from "./host";

const ACTOR_KEY = "bendylights.actor";

/** This browser's person; the id stays, so that undo takes back the same person's steps after a reload. */
export function readActor(): Actor {
  const kept = localStorage.getItem(ACTOR_KEY);
  const known = kept === null ? null : parseActor(kept);
  const actor = known ?? { id: newId(), name: `Guest ${10 + Math.floor(Math.random() * 90)}` };
  keepActor(actor);
  return actor;
}

export function keepActor(actor: Actor): void {
  localStorage.setItem(ACTOR_KEY, JSON.stringify(actor));
}

function parseActor(text: string): Actor | null {
  try {
    const { id, name } = JSON.parse(text) as Partial<Actor>;
    return typeof id === "string" && typeof name === "string" ? { id, name } : null;
  } catch {
    return null;
  }
}

/** A client's colour. Clients that come one after another are far apart: steps of the golden angle. */
export const colorOf = (client: ClientId): string =>
  `hsl(${Math.round(client * 137.508 + 170) % 360} 55% 62%)`;

export const nameOf = (people: readonly Presence[], client: ClientId): string =>
  people.find((person) => person.client === client)?.actor.name ?? "Somebody";
