// Costs of the latest pictures: the passes that ran, their causes, and their times.

import type { FrameStats } from "../core/protocol";
import { usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { ms, passText } from "./stats_texts";

const PANEL = "stats";

/** Asks for stats and shows them, or no longer. */
export function StatsButton() {
  const { viewer } = usePage().session;
  const isOpen = viewer.stats.value;
  return (
    <QuietButton
      title="Which passes each picture came to, and why"
      label="Stats"
      expanded={isOpen}
      controls={PANEL}
      press={() => viewer.askStats(!isOpen)}
    >
      Stats
    </QuietButton>
  );
}

/** In a corner of the picture, while they are asked for. */
export function StatsPanel() {
  const { session } = usePage();
  if (!session.viewer.stats.value) return null;
  const { moving, settled } = session.frameStats.value;
  return (
    // It scrolls, and so has to be reached by keys.
    // biome-ignore lint/a11y/noNoninteractiveTabindex: see above
    <section id={PANEL} class="stats" aria-label="Stats" tabIndex={0}>
      {moving === null && settled === null && <p>With the next picture.</p>}
      {moving !== null && <OfFrame heading="Live" stats={moving} />}
      {settled !== null && <OfFrame heading="Lossless" stats={settled} />}
    </section>
  );
}

function OfFrame({ heading, stats }: { heading: string; stats: FrameStats }) {
  const document = usePage().session.document.value;
  const { frame, waitUs, renderUs, encodeUs, bytes, tiles, size, shadowMapDivisor, passes } = stats;
  const parts = tiles === 1 ? "1 tile" : `${tiles} tiles`;
  const map = shadowMapDivisor === 1 ? "" : `, shadow maps 1/${shadowMapDivisor}`;
  return (
    <>
      <h2>
        {heading}, frame {frame}
      </h2>
      <p>
        Waited {ms(waitUs)}, rendered {ms(renderUs)}, encoded {ms(encodeUs)}
        <br />
        {size.join(" × ")}, {parts}, {(bytes / 1000).toFixed(1)} KB{map}
      </p>
      <ul>
        {passes.map((run) => {
          const text = passText(document, run);
          return <li key={text}>{text}</li>;
        })}
        {passes.length === 0 && <li>Held: nothing had to be drawn</li>}
      </ul>
    </>
  );
}
