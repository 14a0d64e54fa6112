// Texts of a probed pixel, light by light.

import { nodeName } from "../core/node_tree";
import type { Light, ProbedLight, ProbeDisabledBy } from "../core/protocol";
import { formatNumber } from "./format";

const DISABLED: { [W in ProbeDisabledBy]: string } = {
  muted: "left out of this view",
  off: "switched off",
  dark: "gives no light",
};
/** Volume of each type of light, which a surface can be outside of. */
const VOLUMES: { [T in Light["type"]]: string } = {
  bendy: "its tube",
  spot: "its cone",
  omni: "its range",
  directional: "its window",
};

/** Says that the light arrives, or why not; `type` is the light's, if it is known. */
export function stateText(probed: ProbedLight, type: Light["type"] | undefined): string {
  switch (probed.state) {
    case "lit":
      return "lit";
    case "shadowed":
      return `shadowed by ${nodeName(probed.shadowedBy?.node ?? "something")}`;
    case "outside":
      return `outside ${type === undefined ? "its light" : VOLUMES[type]}`;
    case "facingAway":
      return "faces away from it";
    case "faded":
      return "faded out here";
    case "unlinked":
      return "not linked to it";
    case "disabled":
      return probed.disabledBy === null ? "disabled" : DISABLED[probed.disabledBy];
  }
}

/** Coordinates along the light; empty outside of it. */
export function placeText({ place }: ProbedLight): string {
  if (place === null) return "";
  const way = place.pathLength === null ? [] : [`${formatNumber(place.pathLength, 2)} along it`];
  return [...way, `t ${formatNumber(place.t, 2)}`].join(", ");
}

/** The light's share of what all lights give; a little is not none, and not quite all is not all. */
export function shareText({ share }: ProbedLight): string {
  if (share <= 0) return "–";
  if (share < 0.01) return "< 1 %";
  return share > 0.99 && share < 1 ? "> 99 %" : `${Math.round(share * 100)} %`;
}
