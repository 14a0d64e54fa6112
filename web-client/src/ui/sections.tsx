// Sections of the panels, which fold. Which are open is remembered in this browser.

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";

import { Icon } from "./icons";

const SECTIONS_KEY = "bendylights.sections";

/** State of each section that was ever opened or closed. */
type Folds = { [group: string]: boolean };

const folds = signal<Folds>(readFolds());

function readFolds(): Folds {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(SECTIONS_KEY) ?? "{}");
    return typeof kept === "object" && kept !== null ? (kept as Folds) : {};
  } catch {
    return {};
  }
}

interface FoldingProps {
  /** Key in the browser's storage. */
  group: string;
  heading: string;
  /** True if it is open until the user closes it. */
  openAtFirst: boolean;
  /** Buttons beside the heading. */
  tools?: ComponentChildren;
  children: ComponentChildren;
}

export function FoldingSection({ group, heading, openAtFirst, tools, children }: FoldingProps) {
  const open = folds.value[group] ?? openAtFirst;
  const toggle = () => {
    folds.value = { ...folds.value, [group]: !open };
    localStorage.setItem(SECTIONS_KEY, JSON.stringify(folds.value));
  };
  return (
    <section class="panel" aria-label={group} data-open={open}>
      <header class="panel-head">
        <h2>
          <button class="fold" aria-expanded={open} onClick={toggle}>
            <Icon name="fold" /> {heading}
          </button>
        </h2>
        {open && tools}
      </header>
      {open && children}
    </section>
  );
}
