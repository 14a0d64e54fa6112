// Faults of a page by axe-core: contrast, names, roles, landmarks, headings, sizes of targets.
//
// axe-core holds the rules of WCAG that a program can decide, and is what browsers' own audits run.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
/** Levels A and AA of WCAG 2.0 to 2.2, and what is good practice beyond them. */
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** A sentence for each element that breaks a rule as it is shown now. */
export async function findings(page) {
  // By the debugger: the page's own policy lets no script in.
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(AXE);
  return page.evaluate(async (values) => {
    const { violations, incomplete } = await window.axe.run(document, { runOnly: { type: "tag", values } });
    const found = violations.flatMap(({ id, help, nodes }) =>
      nodes
        .filter(({ target }) => id !== "target-size" || !canBeHit(target.join(" ")))
        .map(({ target, any, all, none }) => {
          const why = [...any, ...all, ...none].map(({ message }) => message).join("; ");
          return `${id} at ${target.join(" ")}: ${help} (${why})`;
        }),
    );
    const undecided = incomplete.filter(({ id }) => id === "color-contrast").flatMap(({ nodes }) => nodes);
    return [...found, ...undecided.flatMap(({ target }) => faint(target.join(" ")))];

    /** axe-core takes what the picture clips of a handle for a part that lies over the tools beside it. */
    function canBeHit(selector) {
      const element = document.querySelector(selector);
      const { x, y, width, height } = element?.getBoundingClientRect() ?? { width: 0, height: 0 };
      if (width < 24 || height < 24) return false;
      const shares = [0.05, 0.275, 0.5, 0.725, 0.95];
      const points = shares.flatMap((across) =>
        shares.map((down) => [x + across * width, y + down * height]),
      );
      return points.every(([x, y]) => element.contains(document.elementFromPoint(x, y)));
    }

    /** axe-core does not judge text of one letter, nor where things may overlap, which they do not here. */
    function faint(selector) {
      const element = document.querySelector(selector);
      // Removed elements are not shown, and drawings over the picture have a dark rim.
      if (element === null || element.closest(".overlay") !== null) return [];
      const text = channels(getComputedStyle(element).color);
      const ratio = contrast(text, surfaceOf(element));
      return ratio >= 4.5
        ? []
        : [`color-contrast at ${selector}: its contrast is ${ratio.toFixed(2)}, 4.5 is the least`];
    }

    /** The first opaque colour behind `element`. */
    function surfaceOf(element) {
      const [red, green, blue, alpha = 1] = channels(getComputedStyle(element).backgroundColor);
      return alpha === 1 ? [red, green, blue] : surfaceOf(element.parentElement);
    }

    function channels(color) {
      return color.match(/[\d.]+/g).map(Number);
    }

    function contrast(a, b) {
      const luminance = (color) => {
        const [red, green, blue] = color.map((c) =>
          c <= 10 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4,
        );
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
      };
      const [dark, light] = [luminance(a), luminance(b)].sort((a, b) => a - b);
      return (light + 0.05) / (dark + 0.05);
    }
  }, RULES);
}
