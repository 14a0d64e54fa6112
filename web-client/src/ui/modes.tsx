// Messages over the picture: while a click aims a light or links an object, while the view looks through a light, and for a light that
// another actor drags.

import type { ComponentChildren } from "preact";

import { seeTheSame } from "../core/camera";
import { lightName } from "../core/document";
import { lookBack } from "./directing";
import type { Aiming as AimingState } from "./page_state";
import { isLabelled } from "./hand_labels";
import { isLinking, linkingText } from "./linking";
import { holderOf, usePage } from "./page";
import { nameOf } from "./person";

export function Modes() {
  return (
    <>
      <LookingThrough />
      <Aiming />
      <Linking />
      <ToolSays />
      <Held />
    </>
  );
}

function LookingThrough() {
  const page = usePage();
  const { session, excursion } = page;
  const { value } = excursion;
  if (value === null) return null;
  const own = session.viewer.own.value;
  const isThere = own !== null && seeTheSame(own.camera, value.camera);
  return (
    <Mode>
      {isThere ? `Looking through ${value.name}` : "Away from your view"}
      <button class="quiet" onClick={() => lookBack(page)}>
        Back
      </button>
    </Mode>
  );
}

function Aiming() {
  const { session, selectedLight, aiming } = usePage();
  const id = selectedLight.value;
  if (aiming.value === "off" || id === null) return null;
  const name = lightName(session.document.value, id);
  const said: { [S in AimingState]: string } = {
    off: "",
    on: `Pick what ${name} is to shine at; Enter takes the middle`,
    missed: "Nothing is seen there: pick a surface",
  };
  return (
    <Mode>
      <span>{said[aiming.value]}</span>
      <button class="quiet" onClick={() => (aiming.value = "off")}>
        Stop
      </button>
    </Mode>
  );
}

function Linking() {
  const page = usePage();
  const { linking } = page;
  const { value } = linking;
  if (value === null || !isLinking(page)) return null;
  return (
    <Mode>
      <span>{linkingText(page, value)}</span>
      <button class="quiet" onClick={() => (linking.value = null)}>
        Stop
      </button>
    </Mode>
  );
}

/** Why the last press of a tool came to nothing. */
function ToolSays() {
  const page = usePage();
  const { said } = page.toolbox;
  // The label at the pointer says it too.
  return said.value === null || isLabelled(page) ? null : <Mode>{said.value}</Mode>;
}

/** Name of the client that drags the light. */
function Held() {
  const page = usePage();
  const { session, reachedFor } = page;
  const light = reachedFor.value;
  const holder = light === null ? null : holderOf(page, light);
  if (light === null || holder === null) return null;
  const who = nameOf(session.people.value, holder);
  return (
    <Mode>
      {who} holds {lightName(session.document.value, light)}: take it once {who} lets go
    </Mode>
  );
}

/** A press on it is none on the picture, which would keep the pointer to itself. */
function Mode({ children }: { children: ComponentChildren }) {
  return (
    <div class="banner mode" role="status" onPointerDown={(event) => event.stopPropagation()}>
      {children}
    </div>
  );
}
