// The tools that a press on the picture can be for, and what the one that is taken up asks to know.

import type { ComponentChildren } from "preact";

import { lightOf } from "../core/document";
import type { DragRadii } from "../core/protocol";
import { dragsFeatures, type Following, PIN_KINDS, PIN_TEXTS, TOOLS, type Tool } from "../core/tools";
import { Icon, type IconName } from "./icons";
import { bendLight, isFree } from "./light_actions";
import { type Page, usePage } from "./page";
import { QuietButton } from "./quiet_button";
import { takeTool } from "./tools";

const NAMES: { [T in Tool]: { name: string; icon: IconName; what: string } } = {
  select: { name: "Select", icon: "select", what: "Handles and the view" },
  shadow: { name: "Shadow", icon: "shadow", what: "Take a shadow and put it elsewhere" },
  hotspot: { name: "Hotspot", icon: "hotspot", what: "Take what a light shines on and put it elsewhere" },
  highlight: { name: "Highlight", icon: "highlight", what: "Take a highlight and put it elsewhere" },
  diffuse: { name: "Diffuse", icon: "diffuse", what: "Turn the light to the surface under the pointer" },
  pin: {
    name: "Pin",
    icon: "pin",
    what: "Say what stays as it is while shadows, hotspots and highlights are dragged",
  },
};

export function ToolBar() {
  const page = usePage();
  const { tool } = page.toolbox;
  return (
    <div class="view-tools tools" role="toolbar" aria-label="Tools">
      {TOOLS.map((kind, k) => (
        <QuietButton
          key={kind}
          title={`${NAMES[kind].what} (${k + 1})`}
          label={`${NAMES[kind].name} tool`}
          pressed={tool.value === kind}
          press={() => takeTool(page, kind)}
        >
          <Icon name={NAMES[kind].icon} /> {NAMES[kind].name}
        </QuietButton>
      ))}
    </div>
  );
}

/** Options of the active tool, over the picture, which stays where it is. */
export function ToolChoices() {
  const { tool } = usePage().toolbox;
  if (dragsFeatures(tool.value)) return <FollowingChoices />;
  return tool.value === "pin" ? <PinChoices /> : null;
}

const RADII: { [R in DragRadii]: string } = {
  keep: "Radii: keep width",
  follow: "Radii: narrow where it would fold",
  solve: "Radii: free",
};

/** Choice of the light's motion: as a whole, or by some control points. */
function FollowingChoices() {
  const page = usePage();
  const { toolbox, session, selectedLight } = page;
  const { following } = toolbox;
  const { bends, sourceOutside } = following.value;
  const id = selectedLight.value;
  const light = lightOf(session.document.value, id);
  return (
    <Choices label="How the light follows">
      <QuietButton
        title="The light moves as a whole (B)"
        label="Whole light"
        pressed={!bends}
        press={() => follow(page, { bends: false })}
      >
        Whole light
      </QuietButton>
      <QuietButton
        title="The light bends, its source stays (B)"
        label="Control points"
        pressed={bends}
        press={() => follow(page, { bends: true })}
      >
        Control points
      </QuietButton>
      {!bends && (
        <QuietButton
          title="The source goes through no surface"
          label="Keep lamp out of geometry"
          pressed={sourceOutside}
          press={() => follow(page, { sourceOutside: !sourceOutside })}
        >
          Keep lamp out of geometry
        </QuietButton>
      )}
      {bends && light?.type === "bendy" && <PointChoices count={light.points.length} />}
      {bends && id !== null && light !== undefined && light.type !== "bendy" && (
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

/** Choice of the control points that move, and of the treatment of radii. */
function PointChoices({ count }: { count: number }) {
  const page = usePage();
  const { resting, radii } = page.toolbox.following.value;
  const points = Array.from({ length: count - 1 }, (_, k) => k + 1);
  const toggle = (point: number) => {
    const others = new Set(resting);
    if (!others.delete(point)) others.add(point);
    follow(page, { resting: others });
  };
  return (
    <>
      {points.map((point) => (
        <QuietButton
          key={point}
          class="point-choice"
          title={`Whether control point ${point} takes part`}
          label={`Control point ${point} takes part`}
          pressed={!resting.has(point)}
          press={() => toggle(point)}
        >
          {point}
        </QuietButton>
      ))}
      <select
        aria-label="Radii while dragging"
        value={radii}
        onChange={({ currentTarget }) => follow(page, { radii: currentTarget.value as DragRadii })}
      >
        {(Object.keys(RADII) as DragRadii[]).map((choice) => (
          <option key={choice} value={choice}>
            {RADII[choice]}
          </option>
        ))}
      </select>
    </>
  );
}

/** Choice of the next pin's constraint. */
function PinChoices() {
  const { nextPin } = usePage().toolbox;
  const { hard, ofObject } = nextPin.value;
  return (
    <Choices label="What is pinned">
      {PIN_KINDS.map((kind) => (
        <QuietButton
          key={kind}
          title={`The next pin keeps: ${PIN_TEXTS[kind]}`}
          label={`Pin: ${PIN_TEXTS[kind]}`}
          pressed={nextPin.value.kind === kind}
          press={() => (nextPin.value = { ...nextPin.value, kind })}
        >
          {PIN_TEXTS[kind]}
        </QuietButton>
      ))}
      <QuietButton
        title="The next pin is of the whole object, not of a point"
        label="Whole object"
        pressed={ofObject}
        press={() => (nextPin.value = { ...nextPin.value, ofObject: !ofObject })}
      >
        Whole object
      </QuietButton>
      <QuietButton
        title="A hard pin holds whatever is asked, a soft one as far as that lets it"
        label="Hard"
        pressed={hard}
        press={() => (nextPin.value = { ...nextPin.value, hard: !hard })}
      >
        Hard
      </QuietButton>
    </Choices>
  );
}

function Choices({ label, children }: { label: string; children: ComponentChildren }) {
  return (
    <div class="choices" role="group" aria-label={label}>
      {children}
    </div>
  );
}
