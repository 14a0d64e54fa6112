// What the page's address says: `#token=HEX&session=NAME`. A fragment is never sent to a server.

const TOKEN_KEY = "bendylights.token";

export interface Address {
  /** Empty where neither the address nor this tab knows one. */
  token: string;
  session: string;
}

/** Reads the address, and keeps its token for reloads of this tab. */
export function readAddress(): Address {
  const fields = new URLSearchParams(location.hash.slice(1));
  const token = fields.get("token") || (sessionStorage.getItem(TOKEN_KEY) ?? "");
  if (token !== "") sessionStorage.setItem(TOKEN_KEY, token);
  return { token, session: fields.get("session") ?? "main" };
}

/** Loads the page again with that token, in place of the address's own. */
export function signIn(token: string): void {
  sessionStorage.setItem(TOKEN_KEY, token.trim());
  const fields = new URLSearchParams(location.hash.slice(1));
  fields.delete("token");
  history.replaceState(null, "", `#${fields.toString()}`);
  location.reload();
}
