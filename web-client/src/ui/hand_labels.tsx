// Labels at the pointer: the feature that a press would take, and the numbers of a drag that goes on.

import type { ComponentChildren } from "preact";

import type { Pixel, Size, View } from "../core/camera";
import { lightLabel, lightName, lightOf } from "../core/document";
import type { LightId } from "../core/ids";
import { dragLines } from "../core/outcome_texts";
import { passesPins } from "../core/ignored_pins";
import type { DragKind } from "../core/protocol";
import { dragsFeatures, featureText, nothingTaken, takenLight } from "../core/tools";
import { takenNow } from "./feature_drag";
import { handLines } from "./hand_texts";
import { canEdit, holderOf, type Page, usePage } from "./page";
import { nameOf } from "./person";
import { pinNameOf } from "./pin_facts";
import { clickOf } from "./picture_press";
import { isProbing, Way } from "./probe_view";
import { useProbed } from "./use_probed";

interface LabelsProps {
  view: View;
  /** The picture's upper left corner in the stage. */
  at: Pixel;
  /** Size of the stage. */
  size: Size;
}

/** True if a label at the pointer says what a press would take. A finger does not hover. */
export const isLabelled = ({ toolbox, probe, ...page }: Page): boolean =>
  dragsFeatures(toolbox.tool.value) &&
  probe.at.value !== null &&
  !probe.byFinger.value &&
  !isProbing({ probe, toolbox, ...page });

export function HandLabels(props: LabelsProps) {
  const page = usePage();
  const { toolbox, probe, session } = page;
  const tool = toolbox.tool.value;
  if (toolbox.dragged.value !== null) return <FeatureLabel {...props} />;
  if (toolbox.hand.value !== null) return <HandleLabel {...props} />;
  const hovers = dragsFeatures(tool) && clickOf(page) === null && session.ownDrag.value === null;
  if (!hovers || probe.at.value === null) return null;
  return <Takeable {...props} pixel={probe.at.value} kind={tool} />;
}

/** The way of the light that a press would take, what stands in it, and a label that says so. */
function Takeable({ view, at, size, pixel, kind }: LabelsProps & { pixel: Pixel; kind: DragKind }) {
  const page = usePage();
  const found = useProbed("hover", view, pixel);
  if (found === null) return null;
  const taken = takenLight(kind, found, page.selectedLight.value);
  const why = taken === null ? nothingTaken(kind, found) : hindrance(page, taken.light);
  return (
    <>
      {taken !== null && (
        <svg class="overlay tool-view" width={size.width} height={size.height} aria-hidden="true">
          <g transform={`translate(${at.x} ${at.y})`}>
            <Way view={view} probed={taken} />
          </g>
        </svg>
      )}
      {/* The probe's panel lies at the pointer too, and says more. */}
      {isLabelled(page) && (
        <Label at={at} pixel={pixel} size={size} state={why === null ? "free" : "held"}>
          {taken !== null && <strong>{labelOf(page, taken.light)}</strong>}
          {taken !== null && <span>{featureText(kind, taken)}</span>}
          {why !== null && <span class="label-why">{why}</span>}
        </Label>
      )}
    </>
  );
}

/** Reason why the light cannot be moved now; `null` if it can. */
function hindrance(page: Page, light: LightId): string | null {
  const holder = holderOf(page, light);
  if (holder !== null) return `held by ${nameOf(page.session.people.value, holder)}`;
  return canEdit(page) ? null : "not connected: nothing can be moved";
}

function labelOf({ session }: Page, id: LightId): string {
  const light = lightOf(session.document.value, id);
  return light === undefined ? lightName(session.document.value, id) : lightLabel({ id, light });
}

/** Numbers of the drag of a feature. */
function FeatureLabel({ view, at, size }: LabelsProps) {
  const page = usePage();
  const { toolbox, session } = page;
  const dragged = toolbox.dragged.value;
  const drag = session.ownDrag.value;
  if (dragged === null) return null;
  const scale = view.width / dragged.seen.size.width;
  const pixel: Pixel = { x: scale * dragged.to.x, y: scale * dragged.to.y };
  const { outcome = null, refusal = null } = drag ?? {};
  const lines = outcome === null ? [] : dragLines(outcome, takenNow(page), pinNameOf(page, outcome.pin));
  const state = refusal !== null ? "refused" : (outcome?.status ?? "asked");
  const said = lines.length > 0 ? lines : [refusal === null ? labelOf(page, dragged.id) : "Nothing moves"];
  return (
    <Label at={at} pixel={pixel} size={size} state={state} above={dragged.byFinger} role="status">
      {said.map((line) => (
        <span key={line}>{line}</span>
      ))}
    </Label>
  );
}

/** The value that a handle or an arrow changes. */
function HandleLabel({ at, size }: LabelsProps) {
  const page = usePage();
  const { toolbox, session } = page;
  const hand = toolbox.hand.value;
  const drag = session.ownDrag.value;
  if (hand === null || drag === null || drag.light !== hand.id) return null;
  const now = lightOf(session.document.value, hand.id);
  const lines = now === undefined ? [] : handLines(drag.command, hand.before, now);
  const passed = passesPins(drag.command) ? ["pins passed over"] : [];
  const said = [...lines, ...passed];
  if (said.length === 0) return null;
  return (
    <Label
      at={at}
      pixel={hand.at}
      size={size}
      state={drag.refusal === null ? "free" : "refused"}
      above={hand.byFinger}
    >
      {said.map((line) => (
        <span key={line}>{line}</span>
      ))}
    </Label>
  );
}

/** From the pointer, which has its own shape there; from a finger, which is wider. */
const BESIDE_PX = 18;
const ABOVE_FINGER_PX = 44;
/** Room that a label takes at most. */
const WIDEST_PX = 240;
const TALLEST_PX = 84;

interface LabelProps extends Omit<LabelsProps, "view"> {
  /** Pixel of the picture that it belongs to. */
  pixel: Pixel;
  state: string;
  above?: boolean;
  /** Role of a label that is read out. */
  role?: "status";
  children: ComponentChildren;
}

/** Beside the pointer, on the side that has room. */
function Label({ at, pixel, size, state, above = false, role, children }: LabelProps) {
  const x = Math.min(Math.max(at.x + pixel.x, 0), size.width);
  const y = Math.min(Math.max(at.y + pixel.y, 0), size.height);
  const px = (length: number) => `${length.toFixed(0)}px`;
  const horizontal =
    x + BESIDE_PX + WIDEST_PX <= size.width || x < size.width / 2
      ? { left: px(x + (above ? -BESIDE_PX : BESIDE_PX)) }
      : { right: px(size.width - x + BESIDE_PX) };
  const up = above ? ABOVE_FINGER_PX : BESIDE_PX;
  const isUp = above ? y > TALLEST_PX : y + TALLEST_PX > size.height;
  const vertical = isUp ? { bottom: px(size.height - y + up) } : { top: px(y + up) };
  return (
    <div class="hand-label" role={role} data-state={state} style={{ ...horizontal, ...vertical }}>
      {children}
    </div>
  );
}
