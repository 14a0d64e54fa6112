// Links: which nodes of the scene count for a light (SPEC, LINK-1 to LINK-4).

/** The two lists of links. */
export type LinkList = "include" | "exclude";

/** A value of links, as in JSON; `null` for all nodes. */
export type LinksValue = { include?: readonly string[]; exclude?: readonly string[] } | null;

/** The paths of one list. */
export const pathsOf = (value: LinksValue, list: LinkList): readonly string[] => value?.[list] ?? [];

/** The value with `paths` as one of its lists; `null` where both are empty. */
export function withPaths(value: LinksValue, list: LinkList, paths: readonly string[]): LinksValue {
  const of = (each: LinkList) => (each === list ? [...new Set(paths)] : pathsOf(value, each));
  const [include, exclude] = [of("include"), of("exclude")];
  if (include.length === 0 && exclude.length === 0) return null;
  return { ...(include.length > 0 && { include }), ...(exclude.length > 0 && { exclude }) };
}

/** A word for each of the two lists as people read them. */
export function textOfLinks(value: LinksValue): string {
  const [include, exclude] = [pathsOf(value, "include"), pathsOf(value, "exclude")];
  const some = include.length === 0 ? "all" : include.join(", ");
  return exclude.length === 0 ? some : `${some} without ${exclude.join(", ")}`;
}
