// Drawings of tools over the picture: the start of a drag of a feature, its distance from the pointer, and pins.

import { type Pixel, project, type Size, type View } from "../core/camera";
import type { Drawn } from "../core/handles";
import { centreLine, silhouette, tubeOf } from "../core/outline";
import { coneReach } from "./fitting";
import { Line } from "./lines";
import { usePage } from "./page";
import { PinMarks } from "./pin_marks";

interface ToolViewProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: Size;
}

export function ToolView({ view, at, size }: ToolViewProps) {
  const dragged = usePage().toolbox.dragged.value;
  return (
    <svg class="overlay tool-view" width={size.width} height={size.height} role="group" aria-label="Pins">
      <g transform={`translate(${at.x} ${at.y})`}>
        {dragged !== null && <DraggedFeature view={view} />}
        <PinMarks view={view} />
      </g>
    </svg>
  );
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
