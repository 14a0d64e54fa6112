// Names that are too long for their place. They lose their middle: takes, numbers and the node of a path stand at the end.

/** Characters, as people count them, of the end that stays. */
const END = 6;

/** Characters that a name has at most where it is drawn over the picture. */
export const LONGEST_TAG = 32;

const segmenter = new Intl.Segmenter();

const charactersOf = (name: string): string[] => [...segmenter.segment(name)].map(({ segment }) => segment);

/** The part of a name that may be clipped, and its end, which stays; the end is empty where the name is not much longer. */
export function halvesOf(name: string): { start: string; end: string } {
  const characters = charactersOf(name);
  if (characters.length <= 2 * END) return { start: name, end: "" };
  return { start: characters.slice(0, -END).join(""), end: characters.slice(-END).join("") };
}

/** The name with at most so many characters, for places that cannot clip. */
export function clipMiddle(name: string, most: number): string {
  const characters = charactersOf(name);
  if (characters.length <= most) return name;
  const end = Math.min(END, Math.floor((most - 1) / 2));
  return `${characters.slice(0, most - 1 - end).join("")}…${characters.slice(-end).join("")}`;
}
