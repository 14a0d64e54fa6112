// State of the picture, and its rate.

import { lightLabel } from "../core/document";
import { type FrameHeader, reductionsOf } from "../core/frame";
import { REDUCED, UNREDUCED } from "../core/viewer";
import { usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { StatsButton } from "./stats_panel";
import { ms } from "./stats_texts";

export function StatusBar() {
  const { session } = usePage();
  const frame = session.frame.value;
  const connected = session.connection.value.kind === "connected";
  const { latencyMs, framesPerSecond } = session.statistics.value;
  const times =
    frame === null
      ? ""
      : `waited ${ms(frame.waitUs)}, rendered ${ms(frame.renderUs)}, encoded ${ms(frame.encodeUs)}`;
  return (
    <footer class="status-bar">
      <SoloNote />
      <FullDetail />
      <StatsButton />
      {frame !== null && (
        <>
          <span class="quality" data-settle={frame.settle && connected}>
            {connected ? qualityOf(frame) : "Old"}
          </span>
          <span>
            {frame.codec.toUpperCase()} {frame.width} × {frame.height}
          </span>
          <span>
            {frame.samples} {frame.samples === 1 ? "sample" : "samples"}
          </span>
          <span title={`The latest picture: ${times}`}>render {ms(frame.renderUs)}</span>
        </>
      )}
      <span title="From a change to its picture on the screen, median of the latest">
        latency {latencyMs === null ? "–" : `${latencyMs.toFixed(0)} ms`}
      </span>
      <span>{frame === null || frame.settle ? "at rest" : `${framesPerSecond} fps`}</span>
      <span class="spring" />
      <span class="keys">drag or arrows orbit · with shift pan · wheel or + − zoom · A scene · F light</span>
      <span title="The latest record of the edit log">#{session.mirror.value.seq}</span>
    </footer>
  );
}

/** Quality of the picture in comparison with that at rest. */
function qualityOf(frame: FrameHeader): string {
  if (frame.settle) return "Lossless";
  return ["Live", reductionsOf(frame)].filter((said) => said !== "").join(", ");
}

/** Toggle of full detail: own pictures are not reduced while something moves. */
function FullDetail() {
  const { viewer } = usePage().session;
  if (viewer.following.value !== null) return null;
  const isFull = viewer.interaction.value.resolution === "full";
  return (
    <QuietButton
      title="All pixels and fine shadows also while something moves, however slowly pictures come then"
      label="Full detail while something moves"
      pressed={isFull}
      press={() => viewer.allow(isFull ? REDUCED : UNREDUCED)}
    >
      Full detail
    </QuietButton>
  );
}

/** Note of the lights that shine alone in this picture, with a button that shows all again. */
function SoloNote() {
  const { session } = usePage();
  const { viewer } = session;
  const { solo } = viewer.shownSettings.value;
  const alone = session.document.value.lights.filter(({ id }) => solo.includes(id));
  if (alone.length === 0) return null;
  const names = alone.map(lightLabel).join(", ");
  return (
    <span class="solo-note">
      <span role="status" class="clipped" title={`You see ${names} alone`}>
        Solo: {names}
      </span>
      {viewer.following.value === null && (
        <button class="quiet" onClick={() => viewer.set({ solo: [] })}>
          End solo
        </button>
      )}
    </span>
  );
}
