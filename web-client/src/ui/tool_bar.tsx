// The tools that a press on the picture can be for, and what the one that is taken up asks to know.

import { PIN_KINDS, PIN_TEXTS } from "../core/pins";
import { dragsFeatures, TOOLS, type Tool } from "../core/tools";
import { Choices, FollowingChoices } from "./following_choices";
import { Icon, type IconName } from "./icons";
import { usePage } from "./page";
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
