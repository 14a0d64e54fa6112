// Why the pixel under the pointer is lit or not, while that is asked for: a panel beside it, and the way of the light.

import { type Pixel, project, type Size, type View } from "../core/camera";
import { clipMiddle, LONGEST_TAG } from "../core/clipping";
import { lightLabel } from "../core/document";
import { nodeName } from "../core/node_tree";
import { drawnWay, mattering, splitAt } from "../core/probed";
import type { Probed, ProbedLight } from "../core/protocol";
import { Line } from "./lines";
import { Name } from "./name";
import { type Page, usePage } from "./page";
import { placeText, shareText, stateText } from "./probe_texts";
import { useProbed } from "./use_probed";

interface ProbeViewProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: Size;
}

export const isProbing = ({ probe }: Page): boolean => probe.held.value || probe.on.value;

/** Results of the probe, while it is on; without a pointer over the picture, of the picture's middle. */
export function ProbeView(props: ProbeViewProps) {
  const page = usePage();
  const middle: Pixel = { x: props.view.width / 2, y: props.view.height / 2 };
  return isProbing(page) ? <Probe {...props} pixel={page.probe.at.value ?? middle} /> : null;
}

function Probe({ view, at, size, pixel }: ProbeViewProps & { pixel: Pixel }) {
  const page = usePage();
  const { selectedLight } = page;
  const { x, y } = pixel;
  const found = useProbed("panel", view, pixel);
  const way = found === null ? null : drawnWay(found, selectedLight.value);
  const onStage: Pixel = { x: at.x + x, y: at.y + y };
  return (
    <>
      <svg class="overlay probe" width={size.width} height={size.height} aria-hidden="true">
        <g transform={`translate(${at.x} ${at.y})`}>
          {way !== null && <Way view={view} probed={way} />}
          <Cross at={pixel} />
        </g>
      </svg>
      {found !== null && <Panel found={found} way={way} at={onStage} size={size} />}
    </>
  );
}

/** The way of the light to the surface, dashed behind what it meets first. */
export function Way({ view, probed: { path, shadowedBy } }: { view: View; probed: ProbedLight }) {
  if (shadowedBy === null) return <Line view={view} points={path} kind="way" />;
  const { before, after } = splitAt(path, shadowedBy.position);
  const met = project(view, shadowedBy.position);
  return (
    <>
      <Line view={view} points={before} kind="way" />
      <Line view={view} points={after} kind="way kept-off" />
      {met !== null && (
        <g class="obstacle" transform={`translate(${met.x.toFixed(2)} ${met.y.toFixed(2)})`}>
          <circle class="mark" r={4.5} />
          <text class="light-name" x={9} y={-7}>
            {clipMiddle(nodeName(shadowedBy.node), LONGEST_TAG)}
          </text>
        </g>
      )}
    </>
  );
}

/** Mark of the probed point; its empty middle leaves the pixel visible. */
function Cross({ at }: { at: Pixel }) {
  const lines = "M-9 0h6M3 0h6M0 -9v6M0 3v6";
  return (
    <g transform={`translate(${at.x.toFixed(2)} ${at.y.toFixed(2)})`}>
      <path class="rim" d={lines} />
      <path class="line cross" d={lines} />
    </g>
  );
}

/** Room that the panel takes at most: of a light, and of all else in it; pixels. */
const ROW_HEIGHT = 36;
const OTHER_HEIGHT = 62;
const WIDTH = 290;
const MOST_ROWS = 8;
/** From the pixel that is asked about. */
const BESIDE = 18;
/** On a stage that is narrower the panel takes its whole width, at the edge that is farther from the pixel. */
const NARROW = 520;

interface PanelProps {
  found: Probed;
  /** The light whose way is drawn. */
  way: ProbedLight | null;
  /** The pixel that is asked about, in the stage. */
  at: Pixel;
  size: Size;
}

function Panel({ found, way, at, size }: PanelProps) {
  const { document } = usePage().session;
  const { seen } = found;
  const room = Math.max(at.y, size.height - at.y) - BESIDE - OTHER_HEIGHT;
  const most = Math.min(MOST_ROWS, Math.max(1, Math.floor(room / ROW_HEIGHT)));
  const { lights, left } = mattering(found, most);
  const entryOf = (light: number) => document.value.lights.find(({ id }) => id === light);
  return (
    <div
      class="probe-panel"
      role="status"
      aria-label="Lights at the pointer"
      style={besideOf(at, size, lights.length)}
    >
      <h2>
        <Name name={seen === null ? "Nothing is seen here" : nodeName(seen.node)} />
      </h2>
      {lights.length > 0 && (
        <ul>
          {lights.map((probed) => {
            const entry = entryOf(probed.light);
            const place = placeText(probed);
            return (
              <li key={probed.light} data-state={probed.state} data-way={probed.light === way?.light}>
                <Name name={entry === undefined ? probed.name : lightLabel(entry)} />
                <span class="share">{shareText(probed)}</span>
                <span class="why clipped">
                  {stateText(probed, entry?.light.type)}
                  {place !== "" && `, ${place}`}
                </span>
              </li>
            );
          })}
        </ul>
      )}
      {left > 0 && (
        <p>
          and {left} more {left === 1 ? "light" : "lights"}
        </p>
      )}
    </div>
  );
}

/** Below and to the right of the pixel, if a panel of so many rows has the room there or less on the other side. */
function besideOf(at: Pixel, size: Size, rows: number): { [side: string]: string } {
  const goesAfter = (here: number, all: number, needed: number) =>
    all - here - BESIDE >= needed || all - here >= here;
  const px = (length: number) => `${(length + BESIDE).toFixed(0)}px`;
  if (size.width < NARROW)
    return { [at.y < size.height / 2 ? "bottom" : "top"]: "8px", left: "8px", right: "8px" };
  const vertical: { [side: string]: string } = goesAfter(at.y, size.height, rows * ROW_HEIGHT + OTHER_HEIGHT)
    ? { top: px(at.y) }
    : { bottom: px(size.height - at.y) };
  const horizontal: { [side: string]: string } = goesAfter(at.x, size.width, WIDTH)
    ? { left: px(at.x) }
    : { right: px(size.width - at.x) };
  return { ...vertical, ...horizontal, maxWidth: `${WIDTH}px` };
}
