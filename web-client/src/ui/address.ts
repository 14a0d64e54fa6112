// Address of the page: `#token=HEX&session=NAME`. A fragment is never sent to a server.

const TOKEN_KEY = "bendylights.token";

export interface Address {
  /** Empty where neither the address nor this tab knows one. */
  token: string;
  /** `null` where it names none: then the page lists all. */
  session: string | null;
}

const fields = () => new URLSearchParams(location.hash.slice(1));

/** Reads the address, and keeps its token for reloads of this tab. */
export function readAddress(): Address {
  const token = fields().get("token") || (sessionStorage.getItem(TOKEN_KEY) ?? "");
  if (token !== "") sessionStorage.setItem(TOKEN_KEY, token);
  return { token, session: fields().get("session") || null };
}

/** The address of a session or, with `null`, of the list. It shows the token where the page's own does. */
export function addressOf(session: string | null): string {
  const there = fields();
  if (session === null) there.delete("session");
  else there.set("session", session);
  return `#${there.toString()}`;
}

/** Leads there: the browser can go back from it. */
export function goTo(session: string | null): void {
  location.hash = addressOf(session);
}

/** Loads the page again with that token, in place of the address's own. */
export function signIn(token: string): void {
  sessionStorage.setItem(TOKEN_KEY, token.trim());
  const there = fields();
  there.delete("token");
  history.replaceState(null, "", `#${there.toString()}`);
  location.reload();
}
