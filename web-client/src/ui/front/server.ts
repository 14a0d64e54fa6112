// Requests of the front page to the server.

import type { Actor, DemoScene, DemoScenes, SessionEntry, SessionList } from "../../core/protocol";

/** Why the server did not do what was asked. */
export class Refused extends Error {
  constructor(
    message: string,
    /** Status of the answer; 0 if there was none. */
    readonly status: number,
  ) {
    super(message);
  }
}

export interface NewSession {
  name: string;
  title: string;
  scene?: string;
  actor: Actor;
}

export type Server = ReturnType<typeof serverOf>;

const NO_ANSWER = "The server does not answer. What was asked may not be done: try again once it does.";

/** The server that the page came from, for who has `token`. What it refuses is thrown as `Refused`. */
export function serverOf(token: string) {
  const authorization = `Bearer ${token}`;

  async function ask(method: string, path: string, body?: object): Promise<Response> {
    const json = { authorization, "content-type": "application/json" };
    const request: RequestInit =
      body === undefined
        ? { method, headers: { authorization } }
        : { method, headers: json, body: JSON.stringify(body) };
    const answer = await fetch(path, request).catch(() => null);
    if (answer === null) throw new Refused(NO_ANSWER, 0);
    if (!answer.ok) throw new Refused(await reason(answer), answer.status);
    return answer;
  }

  const of = (session: string, below = "") => `/sessions/${encodeURIComponent(session)}${below}`;

  return {
    /** All sessions, archived ones too. */
    async list(): Promise<SessionEntry[]> {
      const answer = await ask("GET", "/sessions?archived=true");
      return ((await answer.json()) as SessionList).sessions;
    },
    /** Entry of a session in the list; `null` if no session has that name. */
    async entry(session: string): Promise<SessionEntry | null> {
      const answer = await ask("GET", `/sessions?name=${encodeURIComponent(session)}`);
      return ((await answer.json()) as SessionList).sessions[0] ?? null;
    },
    async demos(): Promise<DemoScene[]> {
      return ((await (await ask("GET", "/scenes")).json()) as DemoScenes).demos;
    },
    async create(session: NewSession): Promise<void> {
      await ask("POST", "/sessions", session);
    },
    async change(session: string, change: { title?: string; archived?: boolean }): Promise<void> {
      await ask("PATCH", of(session), change);
    },
    async duplicate(session: string, copy: { name: string; title: string }): Promise<void> {
      await ask("POST", of(session, "/duplicate"), copy);
    },
    async remove(session: string): Promise<void> {
      await ask("DELETE", of(session));
    },
    /** A picture of it. The browser keeps it, and asks whether it is still the same. */
    async picture(session: string, [width, height]: readonly [number, number]): Promise<Blob> {
      const answer = await ask("GET", of(session, `/render?size=${width}x${height}&samples=4`));
      return answer.blob();
    },
  };
}

async function reason(answer: Response): Promise<string> {
  try {
    return ((await answer.json()) as { error: { message: string } }).error.message;
  } catch {
    return `The server answers with ${answer.status}. Try again.`;
  }
}
