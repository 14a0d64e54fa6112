// Choices for the tools that drag features: the way in which the light follows.

import type { ComponentChildren } from "preact";

import { lightOf } from "../core/document";
import type { FollowMode, Following } from "../core/following";
import type { DragRadii, Light } from "../core/protocol";
import { Icon } from "./icons";
import { bendLight, isFree } from "./light_actions";
import { type Page, usePage } from "./page";
import { QuietButton } from "./quiet_button";

const MODES: { [M in FollowMode]: { name: string; title: string } } = {
  best: { name: "Best", title: "Take the answer that lands and changes least of what is lit (B)" },
  whole: { name: "Whole light", title: "Move the light as a whole (B)" },
  points: { name: "Control points", title: "Bend the light, keep its source (B)" },
};

const RADII: { [R in DragRadii]: string } = {
  keep: "Radii: keep width",
  follow: "Radii: narrow where it would fold",
  solve: "Radii: free",
};

export function FollowingChoices() {
  const page = usePage();
  const { toolbox, session, selectedLight } = page;
  const { mode, sourceOutside } = toolbox.following.value;
  const id = selectedLight.value;
  const light = lightOf(session.document.value, id);
  return (
    <Choices label="How the light follows">
      {(Object.keys(MODES) as FollowMode[]).map((choice) => (
        <QuietButton
          key={choice}
          title={MODES[choice].title}
          label={MODES[choice].name}
          pressed={mode === choice}
          press={() => follow(page, { mode: choice })}
        >
          {MODES[choice].name}
        </QuietButton>
      ))}
      {/* Control points leave the source where it is. */}
      {mode !== "points" && (
        <QuietButton
          title="The source goes through no surface"
          label="Keep lamp out of geometry"
          pressed={sourceOutside}
          press={() => follow(page, { sourceOutside: !sourceOutside })}
        >
          Keep lamp out of geometry
        </QuietButton>
      )}
      {mode !== "whole" && light?.type === "bendy" && <PointChoices light={light} />}
      {mode === "points" && <RadiiChoice light={light} />}
      {mode === "points" && id !== null && light !== undefined && light.type !== "bendy" && (
        <QuietButton
          title="A straight light moves as a whole: give it control points, and what it lights stays as it is"
          label="Give it control points"
          disabled={!isFree(page, id)}
          press={() => void bendLight(page, id)}
        >
          <Icon name="bendy" /> Give it control points
        </QuietButton>
      )}
    </Choices>
  );
}

function follow({ toolbox: { following } }: Page, values: Partial<Following>): void {
  following.value = { ...following.value, ...values };
}

/** Choice of the control points that may move. */
function PointChoices({ light }: { light: Light & { type: "bendy" } }) {
  const page = usePage();
  const { resting, mode } = page.toolbox.following.value;
  const points = light.points.slice(1).map((_, k) => k + 1);
  const toggle = (point: number) => {
    const others = new Set(resting);
    if (!others.delete(point)) others.add(point);
    follow(page, { resting: others });
  };
  return (
    <span
      class="point-choices"
      data-optional={mode === "best" && !points.some((point) => resting.has(point))}
    >
      {points.map((point) => (
        <QuietButton
          key={point}
          class="point-choice"
          title={`${resting.has(point) ? "Let control point" : "Keep control point"} ${point} ${resting.has(point) ? "move" : "where it is"}`}
          label={`Control point ${point} takes part`}
          pressed={!resting.has(point)}
          press={() => toggle(point)}
        >
          {point}
        </QuietButton>
      ))}
    </span>
  );
}

function RadiiChoice({ light }: { light: Light | undefined }) {
  const page = usePage();
  if (light?.type !== "bendy") return null;
  return (
    <select
      aria-label="Radii while dragging"
      value={page.toolbox.following.value.radii}
      onChange={({ currentTarget }) => follow(page, { radii: currentTarget.value as DragRadii })}
    >
      {(Object.keys(RADII) as DragRadii[]).map((choice) => (
        <option key={choice} value={choice}>
          {RADII[choice]}
        </option>
      ))}
    </select>
  );
}

export function Choices({ label, children }: { label: string; children: ComponentChildren }) {
  return (
    <div class="choices" role="group" aria-label={label}>
      {children}
    </div>
  );
}
