// Drawings of tools over the picture: the feature under the pointer, the start of a drag and its distance from the pointer, and pins.

import { type Pixel, project, type Size, type View } from "../core/camera";
import type { Drawn } from "../core/handles";
import { centreLine, silhouette, tubeOf } from "../core/outline";
import type { Pin } from "../core/protocol";
import { dragsFeatures, pinsOf, pinText, takenLight } from "../core/tools";
import { coneReach } from "./fitting";
import { isFree } from "./light_actions";
import { Line } from "./lines";
import { type Page, usePage } from "./page";
import { Way } from "./probe_view";
import { useProbed } from "./use_probed";

interface ToolViewProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: Size;
}

export function ToolView({ view, at, size }: ToolViewProps) {
  const { toolbox, probe } = usePage();
  const tool = toolbox.tool.value;
  const dragged = toolbox.dragged.value;
  return (
    <svg class="overlay tool-view" width={size.width} height={size.height} role="group" aria-label="Pins">
      <g transform={`translate(${at.x} ${at.y})`}>
        {dragsFeatures(tool) && dragged === null && probe.at.value !== null && (
          <Takeable view={view} pixel={probe.at.value} kind={tool} />
        )}
        {dragged !== null && <DraggedFeature view={view} />}
        <Pins view={view} />
      </g>
    </svg>
  );
}

/** The way of the light that a press would take, and what stands in it. */
function Takeable({
  view,
  pixel,
  kind,
}: {
  view: View;
  pixel: Pixel;
  kind: Parameters<typeof takenLight>[0];
}) {
  const { selectedLight } = usePage();
  const found = useProbed("hover", view, pixel);
  const taken = found === null ? null : takenLight(kind, found, selectedLight.value);
  return taken === null ? null : <Way view={view} probed={taken} />;
}

/** The light as it was, where the drag began, and where the feature is to be. */
function DraggedFeature({ view }: { view: View }) {
  const page = usePage();
  const { toolbox, session } = page;
  const dragged = toolbox.dragged.value;
  if (dragged === null) return null;
  const { light, from, to, seen } = dragged;
  const tube = tubeOf(light, coneReach(page));
  const scale = view.width / seen.size.width;
  const [start, end] = [from, to].map(({ x, y }) => ({ x: scale * x, y: scale * y }));
  const outcome = session.ownDrag.value?.outcome ?? null;
  const pivot = outcome?.pivotWorld == null ? null : project(view, outcome.pivotWorld);
  const edges = light.type === "omni" ? [] : Object.values(silhouette(tube, view.camera));
  return (
    <g class="dragged-feature" data-status={outcome?.status ?? "asked"}>
      <Ghost view={view} tube={tube} edges={edges} />
      {start !== undefined && end !== undefined && (
        <>
          <path class="rim" d={`M${start.x} ${start.y}L${end.x} ${end.y}`} />
          <path class="line leash" d={`M${start.x} ${start.y}L${end.x} ${end.y}`} />
          <circle class="mark from" cx={start.x} cy={start.y} r={4} />
          <circle class="mark to" cx={end.x} cy={end.y} r={9} />
        </>
      )}
      {pivot !== null && <circle class="mark pivot" cx={pivot.x} cy={pivot.y} r={4.5} />}
    </g>
  );
}

function Ghost({
  view,
  tube,
  edges,
}: {
  view: View;
  tube: Drawn["tube"];
  edges: ReturnType<typeof centreLine>[];
}) {
  return (
    <g class="ghost">
      <Line view={view} points={centreLine(tube)} kind="centre" />
      {edges.map((edge, k) => (
        // biome-ignore lint/suspicious/noArrayIndexKey: right and left
        <Line key={k} view={view} points={edge} kind="edge" />
      ))}
    </g>
  );
}

/** The pins of the selected light. Delete removes the one that has the focus. */
function Pins({ view }: { view: View }) {
  const page = usePage();
  const pins = pinsOf(page.session.document.value, page.selectedLight.value);
  return (
    <>
      {pins.map(({ id, pin }) => (
        <PinMark key={id} view={view} id={id} pin={pin} page={page} />
      ))}
    </>
  );
}

function PinMark({ view, id, pin, page }: { view: View; id: number; pin: Pin; page: Page }) {
  const { session, toolbox } = page;
  // The pin of an object has no one place, and is in the list alone.
  const at = typeof pin.at === "string" ? null : project(view, pin.at);
  if (at === null) return null;
  const said = `${pin.hard ? "Hard" : "Soft"} pin: ${pinText(pin)}`;
  const holds = session.ownDrag.value?.outcome?.pin === id;
  return (
    <g
      class="pin"
      data-pin={id}
      data-kind={pin.kind}
      data-hard={pin.hard}
      data-holds={holds}
      data-current={toolbox.selectedPin.value === id}
      transform={`translate(${at.x.toFixed(2)} ${at.y.toFixed(2)})`}
      role="button"
      tabIndex={0}
      aria-label={said}
      onFocus={() => (toolbox.selectedPin.value = id)}
      onPointerDown={(event) => {
        event.stopPropagation();
        toolbox.selectedPin.value = id;
      }}
      onKeyDown={(event) => {
        if ((event.key !== "Delete" && event.key !== "Backspace") || !isFree(page, pin.light)) return;
        event.preventDefault();
        session.edit({ type: "removePin", pin: id });
      }}
    >
      <title>{said}</title>
      <circle class="reach" r={12} />
      <path class="mark" d="M0 0-4.5-7a5.4 5.4 0 1 1 9 0z" />
    </g>
  );
}
