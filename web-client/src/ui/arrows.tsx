// Arrows at what is selected, that pull it along one way alone. Keys move the handle itself, in depth too.

import { type Arrow, arrowName, arrowsOf, type ArrowSpan, grabArrow, spanOf } from "../core/arrows";
import type { Drawn } from "../core/handles";
import { dragHandle } from "./handle_drag";
import { type Page, usePage } from "./page";

/** The head's length and half its width, and half the shaft's; a depth arrow comes towards the eye, and grows to its head. */
const HEAD = { length: 11, half: 5.5 };
const SHAFT_HALF = 1.2;
const DEPTH_HALF = 3;

/** So far past its tip an arrow is still grabbed, pixels. */
const BEYOND = 6;

export function Arrows({ drawn }: { drawn: Drawn }) {
  const page = usePage();
  return (
    <>
      {arrowsOf(drawn.light, page.selectedPoint.value).map((arrow) => {
        const span = spanOf(arrow, drawn);
        return (
          span !== null && (
            <g
              key={arrowName(arrow)}
              class={`arrow ${arrow.way === "depth" ? "depth" : `axis-${arrow.way}`}`}
              data-handle={arrowName(arrow)}
              aria-hidden
              onPointerDown={(event) => startPulling(event, page, arrow, drawn)}
            >
              <title>{titleOf(arrow)}</title>
              <Shape span={span} isDepth={arrow.way === "depth"} />
            </g>
          )
        );
      })}
    </>
  );
}

function Shape({ span: { tail, tip }, isDepth }: { span: ArrowSpan; isDepth: boolean }) {
  const length = Math.hypot(tip.x - tail.x, tip.y - tail.y);
  const degrees = (Math.atan2(tip.y - tail.y, tip.x - tail.x) * 180) / Math.PI;
  const neck = length - HEAD.length;
  const half = isDepth ? DEPTH_HALF : SHAFT_HALF;
  const shaft = isDepth ? `M0 0L${neck} ${-half}` : `M0 ${-half}L${neck} ${-half}`;
  const back = isDepth ? `L${neck} ${half}Z` : `L${neck} ${half}L0 ${half}Z`;
  const head = `L${neck} ${-HEAD.half}L${length} 0L${neck} ${HEAD.half}`;
  return (
    <g transform={`translate(${tail.x.toFixed(2)} ${tail.y.toFixed(2)}) rotate(${degrees.toFixed(2)})`}>
      <path class="arrow-reach" d={`M0 0L${length + BEYOND} 0`} />
      <path class="mark" d={`${shaft}${head}${back}`} />
    </g>
  );
}

function titleOf({ moves, way }: Arrow): string {
  const what = moves.kind === "source" ? "the light" : `control point ${moves.point}`;
  return way === "depth" ? `Move ${what} towards you, or back away` : `Move ${what} along ${"xyz"[way]}`;
}

function startPulling(down: PointerEvent, page: Page, arrow: Arrow, drawn: Drawn): void {
  if (down.button !== 0 || down.altKey) return;
  down.stopPropagation();
  down.preventDefault();
  // Keys go on from where the pointer leaves it.
  const { moves } = arrow;
  const name = moves.kind === "source" ? moves.kind : `point-${moves.point}`;
  const overlay = (down.currentTarget as Element).closest(".overlay");
  overlay?.querySelector<SVGElement>(`[data-handle="${name}"]`)?.focus({ preventScroll: true });
  dragHandle(down, page, { drawn, grab: (from) => grabArrow(arrow, drawn, from), movable: null });
}
