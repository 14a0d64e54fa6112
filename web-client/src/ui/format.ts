// Values as people read them.

/** A number with at most `decimals`, and fewer the larger it is. */
export function formatNumber(value: number, decimals: number): string {
  const spare = Math.floor(Math.log10(Math.max(Math.abs(value), 1)));
  return String(Number(value.toFixed(Math.max(0, decimals - spare))));
}
