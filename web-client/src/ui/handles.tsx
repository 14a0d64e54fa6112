// Handles of the selected light, for the pointer and for keys.

import type { JSX } from "preact";

import { depthOf, isInPicture, project, type View } from "../core/camera";
import {
  type Axis,
  type Drawn,
  grab,
  type Handle,
  handleName,
  handlesOf,
  isMovable,
  positionOf,
  turnAxis,
  turnRadius,
} from "../core/handles";
import { circle } from "../core/outline";
import type { Vec3 } from "../core/vector";
import { Arrows } from "./arrows";
import { dragHandle } from "./handle_drag";
import { pressHandle } from "./handle_keys";
import { described, titleOf } from "./handle_texts";
import { pathOf } from "./lines";
import { canEdit, type Page, reachFor, usePage } from "./page";

interface HandlesProps {
  drawn: Drawn;
  /** Somebody else is dragging the light. */
  locked: boolean;
}

const AXES: readonly Axis[] = [0, 1, 2];
/** Maximum distance in pixels from which the pointer grabs a handle. */
export const REACH_PX = 12;

export function Handles({ drawn, locked }: HandlesProps) {
  const page = usePage();
  const disabled = locked || !canEdit(page);
  const operate = (handle: Handle): GroupProps => ({
    tabindex: tabIndexAt(drawn.view, positionOf(handle, drawn)),
    role: "slider",
    "aria-disabled": disabled,
    ...described(handle, drawn),
    onFocus: () => select(page, handle),
    onBlur: page.presses.commit,
    onPointerDown: (event) => startDrag(event, page, handle, drawn),
    onKeyDown: (event) => pressHandle(event, page, handle, drawn),
  });
  return (
    <g data-disabled={disabled}>
      {AXES.map((axis) => (
        <TurnRing key={axis} axis={axis} drawn={drawn} props={operate({ kind: "turn", axis })} />
      ))}
      {!disabled && <Arrows drawn={drawn} />}
      {handlesOf(drawn.light).map((handle) => (
        <PointHandle key={handleName(handle)} handle={handle} drawn={drawn} props={operate(handle)} />
      ))}
      <PointHandle handle={{ kind: "source" }} drawn={drawn} props={operate({ kind: "source" })} />
    </g>
  );
}

/** Tab passes over what is out of sight. */
export function tabIndexAt(view: View, position: Vec3): 0 | -1 {
  const at = project(view, position);
  return at !== null && isInPicture(view, at) ? 0 : -1;
}

interface HandleProps<H extends Handle = Handle> {
  handle: H;
  drawn: Drawn;
  props: GroupProps;
}

/** Properties of a handle for the keyboard, the pointer and screen readers. */
type GroupProps = JSX.IntrinsicElements["g"];

function PointHandle({ handle, drawn, props }: HandleProps) {
  const { selectedPoint } = usePage();
  const at = project(drawn.view, positionOf(handle, drawn));
  if (at === null) return null;
  const point = "point" in handle ? handle.point : null;
  return (
    <g
      class={`handle ${handle.kind}`}
      data-handle={handleName(handle)}
      data-current={point !== null && point === selectedPoint.value}
      transform={`translate(${at.x.toFixed(2)} ${at.y.toFixed(2)})`}
      {...props}
    >
      <title>{titleOf(handle)}</title>
      <circle class="reach" r={REACH_PX} />
      <Mark handle={handle} />
    </g>
  );
}

function Mark({ handle }: { handle: Handle }) {
  switch (handle.kind) {
    case "source":
      return (
        <>
          <circle class="mark" r={7} />
          <circle class="pip" r={2} />
        </>
      );
    case "point":
      return (
        <>
          <circle class="mark" r={5} />
          <text x={9} y={-7}>
            {handle.point}
          </text>
        </>
      );
    default:
      return <rect class="mark" x={-3.5} y={-3.5} width={7} height={7} transform="rotate(45)" />;
  }
}

/** A ring around the source; the half behind it is faint. */
function TurnRing({ axis, drawn, props }: { axis: Axis; drawn: Drawn; props: GroupProps }) {
  const { light, view } = drawn;
  const centre = light.transform.translation;
  const ring = circle(centre, turnAxis(light, axis), turnRadius(drawn));
  if (project(view, centre) === null) return null;
  return (
    <g class={`turn axis-${axis}`} data-handle={handleName({ kind: "turn", axis })} {...props}>
      <title>{titleOf({ kind: "turn", axis })}</title>
      <path class="reach-line" d={pathOf(view, ring)} />
      <path class="turn-back" d={pathOf(view, ring)} />
      <path class="turn-front" d={nearHalf(view, ring, centre)} />
    </g>
  );
}

/** The path of those parts of `ring` that are nearer than `centre`. */
function nearHalf(view: View, ring: readonly Vec3[], centre: Vec3): string {
  const depth = depthOf(view.camera, centre) * (1 + 1e-9);
  const isNear = (point: Vec3 | undefined) => point !== undefined && depthOf(view.camera, point) <= depth;
  const pieces = ring.slice(1).flatMap((point, k) => {
    const before = ring[k];
    return before !== undefined && isNear(point) && isNear(before) ? [pathOf(view, [before, point])] : [];
  });
  return pieces.join("");
}

/** Selects what `handle` belongs to. */
function select({ selectedPoint }: Page, handle: Handle): void {
  if ("point" in handle) selectedPoint.value = handle.point;
  else if (handle.kind === "source") selectedPoint.value = null;
}

/** Selects what is grabbed, and drags it until the pointer is let go of. */
function startDrag(down: PointerEvent, page: Page, handle: Handle, drawn: Drawn): void {
  if (down.button !== 0 || down.altKey) return;
  down.stopPropagation();
  down.preventDefault();
  // Keys then go on from where the pointer leaves it.
  (down.currentTarget as SVGElement).focus({ preventScroll: true });
  select(page, handle);
  if (!reachFor(page, drawn.id)) return;
  const movable = isMovable(handle) ? handle : null;
  dragHandle(down, page, { drawn, grab: (from) => grab(handle, drawn, from), movable });
}
