// Formats of cameras: width over height of what they frame.

export interface Format {
  /** Common name. */
  label: string;
  aspect: number;
}

/** Common formats of films, broadcasts and stills. */
export const FORMATS: readonly Format[] = [
  { label: "16:9", aspect: 16 / 9 },
  { label: "1.85", aspect: 1.85 },
  { label: "2.39", aspect: 2.39 },
  { label: "4:3", aspect: 4 / 3 },
  { label: "1:1", aspect: 1 },
];

/** Files round: so much of a ratio makes no other format. */
const SAME = 1e-4;

/** The common format that this is, if it is one. */
export const formatOf = (aspect: number): Format | undefined =>
  FORMATS.find((format) => Math.abs(format.aspect / aspect - 1) < SAME);
