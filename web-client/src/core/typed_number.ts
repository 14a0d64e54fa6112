// Text in a field for a number: sums, products and shares of the present value, and units.

/** Number in a text, or the reason why there is none. */
export type Typed = { value: number } | { problem: string };

/** Units of a number: each name with the count of the field's own unit. */
type Units = { [name: string]: number };

const DEGREES: Units = { "°": 1, deg: 1, degrees: 1, rad: 180 / Math.PI, turn: 360 };
const METRES: Units = { m: 1, cm: 0.01, mm: 0.001, km: 1000, ft: 0.3048, in: 0.0254 };
/** glTF's units of brightness, by the shape of the light: the field does not say which it has. */
const BRIGHTNESS: Units = { cd: 1, kcd: 1000, lx: 1, klx: 1000 };
const UNITS: { [unit: string]: Units } = {
  degrees: DEGREES,
  "°": DEGREES,
  K: { k: 1, kelvin: 1 },
  stops: { stops: 1, stop: 1, ev: 1 },
  "%": { "%": 1 },
  "world units": METRES,
  "": BRIGHTNESS,
};

const WHAT = "type a number, a sum such as 1+1, *2, or 50%";

/** Reads `text` in a field that has `now` and counts in `unit`. A factor alone, `*2`, is of what the field has, and so is a share,
 * `50%`, unless the field counts in percent. */
export function readNumber(text: string, now: number, unit = ""): Typed {
  const units = UNITS[unit] ?? {};
  const tokens =
    text.replaceAll(",", ".").match(/\d+\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?|[a-z°%]+|\S/gi) ?? [];
  let at = 0;
  const next = (...wanted: string[]): string | null => {
    const token = tokens[at];
    if (token === undefined || !wanted.includes(token)) return null;
    at += 1;
    return token;
  };
  let problem: string | null = null;
  const fail = (why: string): number => {
    problem ??= why;
    return Number.NaN;
  };
  const notUnderstood = `“${text.trim()}” is not understood: ${WHAT}`;

  function number(): number {
    const token = tokens[at];
    if (token === undefined || !/^[\d.]/.test(token)) return fail(notUnderstood);
    at += 1;
    const value = Number(token);
    const named = tokens[at];
    if (named === undefined || !/^[a-z°%]/i.test(named)) return value;
    at += 1;
    const factor = units[named.toLowerCase()] ?? units[named];
    if (factor !== undefined) return value * factor;
    if (named === "%") return (value / 100) * now;
    const known = Object.keys(units);
    const instead = known.length === 0 ? "leave the unit out" : `it takes ${known.join(", ")}`;
    return fail(`The field does not count in “${named}”: ${instead}`);
  }

  function factor(): number {
    if (next("-") !== null) return -factor();
    if (next("+") !== null) return factor();
    if (next("(") === null) return number();
    const value = sum();
    return next(")") === null ? fail(notUnderstood) : value;
  }

  function product(first: number): number {
    let value = first;
    for (let sign = next("*", "/"); sign !== null; sign = next("*", "/")) {
      const by = factor();
      value = sign === "*" ? value * by : value / by;
    }
    return value;
  }

  function sum(): number {
    const isOfNow = tokens[at] === "*" || tokens[at] === "/";
    let value = product(isOfNow ? now : factor());
    for (let sign = next("+", "-"); sign !== null; sign = next("+", "-")) {
      const by = product(factor());
      value = sign === "+" ? value + by : value - by;
    }
    return value;
  }

  const value = sum();
  if (problem === null && (at < tokens.length || !Number.isFinite(value))) problem = notUnderstood;
  return problem === null ? { value } : { problem };
}
