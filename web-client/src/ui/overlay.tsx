// The lights drawn over the picture: curve and tube. What can be grabbed is in handles.tsx.

import { type Pixel, project, type View } from "../core/camera";
import { clipMiddle, LONGEST_TAG } from "../core/clipping";
import { segmentCount } from "../core/curve";
import { lightLabel } from "../core/document";
import type { Drawn } from "../core/handles";
import { arrowHead, centreLine, ringAt, silhouette, sphereOf, tubeOf } from "../core/outline";
import type { DocumentLight } from "../core/protocol";
import { coneReach } from "./fitting";
import { Handles, REACH_PX, tabIndexAt } from "./handles";
import { Line } from "./lines";
import { selectLight, usePage } from "./page";
import { colorOf, nameOf } from "./person";

interface OverlayProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: { width: number; height: number };
}

/** Everything over the picture. */
export function Overlay({ view, at, size }: OverlayProps) {
  const { session, selectedLight } = usePage();
  const { lights } = session.document.value;
  const isSelected = ({ id }: DocumentLight) => id === selectedLight.value;
  // The selected light is on top.
  const ordered = [...lights.filter((entry) => !isSelected(entry)), ...lights.filter(isSelected)];
  return (
    <svg
      class="overlay"
      width={size.width}
      height={size.height}
      role="group"
      aria-label="Lights"
      data-dragging={session.ownDrag.value !== null}
    >
      <g transform={`translate(${at.x} ${at.y})`}>
        {ordered.map((entry) => (
          <LightOverlay key={entry.id} entry={entry} view={view} selected={isSelected(entry)} />
        ))}
      </g>
      {lights.map((entry) => (
        <NameTag key={entry.id} entry={entry} view={view} at={at} size={size} />
      ))}
    </svg>
  );
}

interface LightOverlayProps {
  entry: DocumentLight;
  view: View;
  selected: boolean;
}

function LightOverlay({ entry: { id, light }, view, selected }: LightOverlayProps) {
  const page = usePage();
  const { session } = page;
  const radii = page.radiiFollow.value ? "follow" : "keep";
  const drawn: Drawn = { id, light, tube: tubeOf(light, coneReach(page)), view, radii };
  const holder = session.gestures.value.find((gesture) => gesture.light === id)?.client;
  const refused = session.ownDrag.value?.light === id && session.ownDrag.value.refusal !== null;
  const color = holder === undefined ? undefined : colorOf(holder);
  const source = project(view, light.transform.translation);
  return (
    <g
      class="light"
      data-selected={selected}
      data-held={holder !== undefined}
      data-refused={refused}
      style={{ color }}
    >
      {selected || holder !== undefined ? (
        <TubeLines {...drawn} />
      ) : (
        <Line view={view} points={centreLine(drawn.tube)} kind="centre" />
      )}
      {selected && <Handles drawn={drawn} locked={holder !== undefined} />}
      {source !== null && !selected && (
        <g
          class="handle source"
          data-handle={`light-${id}`}
          transform={`translate(${source.x} ${source.y})`}
          tabindex={tabIndexAt(view, light.transform.translation)}
          role="button"
          aria-label={`Select ${lightLabel({ id, light })}`}
          onPointerDown={(event) => {
            event.stopPropagation();
            selectLight(page, id);
          }}
          onKeyDown={(event) => {
            if (event.key !== "Enter" && event.key !== " ") return;
            event.preventDefault();
            const stage = event.currentTarget.closest(".stage");
            selectLight(page, id);
            // Its handles take this one's place.
            requestAnimationFrame(() => stage?.querySelector<SVGElement>('[data-handle="source"]')?.focus());
          }}
        >
          <title>{lightLabel({ id, light })}</title>
          <circle class="reach" r={REACH_PX} />
          <circle class="mark" r={6} />
        </g>
      )}
    </g>
  );
}

/** Room that a name needs from the right and lower edges of the stage, pixels. */
const TAG = { width: 150, height: 14 };

/** The light's name at its source; that of a light that somebody holds stays in sight, with the holder's. */
function NameTag({ entry, view, at, size }: OverlayProps & { entry: DocumentLight }) {
  const { id, light } = entry;
  const { session } = usePage();
  const holder = session.gestures.value.find((gesture) => gesture.light === id)?.client;
  const name = clipMiddle(lightLabel(entry), LONGEST_TAG);
  const source = project(view, light.transform.translation);
  const wanted: Pixel =
    source === null ? { x: 0, y: 0 } : { x: at.x + source.x + 12, y: at.y + source.y - 10 };
  if (holder === undefined) {
    return source === null ? null : (
      <text class="light-name" {...wanted}>
        {name}
      </text>
    );
  }
  const x = Math.min(Math.max(wanted.x, 10), size.width - TAG.width);
  const y = Math.min(Math.max(wanted.y, 10 + TAG.height), size.height - TAG.height);
  return (
    <text class="light-name" x={x} y={y} style={{ fill: colorOf(holder) }}>
      {name} is held by {clipMiddle(nameOf(session.people.value, holder), LONGEST_TAG)}
    </text>
  );
}

/** The curve, its control polygon, the tube's silhouette, and rings where segments meet; of an omni light its sphere. */
function TubeLines({ tube, view, light }: Drawn) {
  if (light.type === "omni") {
    const [x = [], y = [], z = []] = sphereOf(tube, light.transform.rotation);
    return (
      <>
        <Line view={view} points={x} kind="ring" />
        <Line view={view} points={y} kind="ring" />
        <Line view={view} points={z} kind="ring" />
      </>
    );
  }
  const { right, left } = silhouette(tube, view.camera);
  const joints = Array.from({ length: segmentCount(tube.points.length) + 1 }, (_, t) => t);
  return (
    <>
      {joints.map((t) => (
        <Line key={t} view={view} points={ringAt(tube, t)} kind="ring" />
      ))}
      <Line view={view} points={right} kind="edge" />
      <Line view={view} points={left} kind="edge" />
      <Line view={view} points={centreLine(tube)} kind="centre" />
      {light.type === "bendy" && <Line view={view} points={tube.points} kind="polygon" />}
      {light.type === "directional" && <Line view={view} points={arrowHead(tube, view.camera)} kind="edge" />}
    </>
  );
}
