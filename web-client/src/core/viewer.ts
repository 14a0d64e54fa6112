// View of this page: its own camera, or the view of another client. Never logged (SPEC, SOCK-7).

import { computed, type ReadonlySignal, signal } from "@preact/signals-core";

import type { Size } from "./camera";
import type { Host } from "./connection";
import type { FrameHeader } from "./frame";
import type { ClientId } from "./ids";
import type { LatencyMeter } from "./latency";
import { type Orbit, orbitFrom } from "./navigation";
import type {
  Bounds,
  Camera,
  ClientMessage,
  Interaction,
  Presence,
  ViewSettings,
  ViewSource,
} from "./protocol";

/** Cameras of frames that may still arrive. */
const REMEMBERED_CAMERAS = 256;

export interface Viewer {
  /** One's own camera; `null` before the first welcome. */
  own: ReadonlySignal<Orbit | null>;
  following: ReadonlySignal<ClientId | null>;
  /** Own settings besides the camera. */
  settings: ReadonlySignal<ViewSettings>;
  /** The same of the view that is shown: one's own, or of who is followed. */
  shownSettings: ReadonlySignal<ViewSettings>;
  /** Reductions of own pictures that are allowed while something moves. */
  interaction: ReadonlySignal<Interaction>;
  /** True if the server sends statistics of each picture. */
  stats: ReadonlySignal<boolean>;
  /** Size of own pictures; `null` before the stage has one. */
  size: ReadonlySignal<Size | null>;
  /** Numbers one's own cameras; pictures from the latest carry it. */
  revision: ReadonlySignal<number>;
  /** Moves one's own view, from where the page looks now; ends following. */
  move(change: (from: Orbit) => Orbit): void;
  /** Looks from `camera`: all of its shot is in sight, however the picture's size changes. */
  jump(camera: Camera): void;
  /** Changes what is one's own besides the camera. */
  set(changed: Partial<ViewSettings>): void;
  /** Says what of one's own pictures may be reduced while something moves. */
  allow(interaction: Interaction): void;
  /** Asks for what each picture came to, or no longer. */
  askStats(asked: boolean): void;
  /** Shows another client's view, or with `null` one's own. */
  follow(client: ClientId | null): void;
  /** Asks for pictures of this size, in pixels. */
  resize(width: number, height: number): void;
  /** The camera that the picture with this header was taken from. */
  cameraOf(header: FrameHeader | null): Camera | null;
  /** Before the first welcome: looks from where the page looked when it was last left. */
  restore(view: Orbit, settings: ViewSettings): void;
  /** After each welcome: asks for frames, as soon as their size is known. */
  open(camera: Camera): void;
  /** After each presence: a view whose owner has left is followed no longer. */
  people(present: readonly Presence[]): void;
}

export interface ViewerParts {
  host: Host;
  send(message: ClientMessage): boolean;
  bounds(): Bounds;
  latency: LatencyMeter;
}

/** Settings of a new view. */
const UNCHANGED: ViewSettings = { exposure: 0, solo: [] };

/** Pictures come quickly enough, however many pixels and texels they have for that. */
export const REDUCED: Interaction = { shadowMap: "auto", resolution: "auto" };
/** Pictures are as at rest, however long each takes. */
export const UNREDUCED: Interaction = { shadowMap: "full", resolution: "full" };

export function viewing({ host, send, bounds, latency }: ViewerParts): Viewer {
  const own = signal<Orbit | null>(null);
  const following = signal<ClientId | null>(null);
  const present = signal<readonly Presence[]>([]);
  const sentCameras = new Map<number, Camera>();
  const revision = signal(0);
  const size = signal<Size | null>(null);
  const settings = signal<ViewSettings>(UNCHANGED);
  const interaction = signal<Interaction>(REDUCED);
  const stats = signal(false);
  /** True if the statistics were requested from the server. */
  let isAsked = false;
  /** Changes to send before the next repaint; each has a revision of its own, that of the settings after the camera's. */
  let [moved, isSet] = [false, false];

  function remember(camera: Camera, number: number): void {
    sentCameras.set(number, camera);
    sentCameras.delete(number - REMEMBERED_CAMERAS);
  }

  function openView(): void {
    const orbit = own.value;
    if (orbit === null || size.value === null) return;
    const source: ViewSource = following.value === null ? { own: orbit.camera } : { follow: following.value };
    revision.value += 1;
    remember(orbit.camera, revision.value);
    [moved, isSet, isAsked] = [false, false, stats.value];
    const asked = { ...size.value, cameraRevision: revision.value, settings: settings.value };
    send({ type: "openView", source, interaction: interaction.value, stats: stats.value, ...asked });
  }

  /** Sends `what`, which differs from what the server knows, before the next repaint. */
  function schedule(what: "camera" | "settings"): void {
    if (what === "camera" ? moved : isSet) return;
    if (!(moved || isSet)) host.beforeRepaint(sendChanges);
    if (what === "camera") moved = true;
    else isSet = true;
    revision.value += 1;
  }

  function sendChanges(): void {
    const [camera, was] = [own.value?.camera, { moved, isSet }];
    [moved, isSet] = [false, false];
    if (camera === undefined || size.value === null || following.value !== null) return;
    if (was.moved) {
      const cameraRevision = was.isSet ? revision.value - 1 : revision.value;
      sendRevision({ type: "setCamera", camera, cameraRevision }, camera);
    }
    if (was.isSet) {
      const asked = stats.value === isAsked ? {} : { stats: stats.value };
      isAsked = stats.value;
      const changed = { settings: settings.value, ...asked, cameraRevision: revision.value };
      sendRevision({ type: "setView", ...changed }, camera);
    }
  }

  function sendRevision(message: ClientMessage & { cameraRevision: number }, camera: Camera): void {
    remember(camera, message.cameraRevision);
    if (send(message)) latency.expect("cameraRevision", message.cameraRevision, host.nowMs());
  }

  function move(change: (from: Orbit) => Orbit): void {
    const followed = following.value !== null;
    if (followed) leave();
    if (own.value === null) return;
    own.value = change(own.value);
    if (followed) openView();
    else schedule("camera");
  }

  /** Whose view it is that is followed; who is followed may follow another. */
  function leading(): Presence | null {
    let leader = following.value;
    for (const _ of present.value) {
      const person = present.value.find(({ client }) => client === leader);
      if (person === undefined || person.following === null) return person ?? null;
      leader = person.following;
    }
    return null;
  }

  const cameraOfFollowed = (): Camera | null => leading()?.camera ?? null;

  /** From now on one's own view, from where the followed one was. */
  function leave(): void {
    const seen = cameraOfFollowed();
    if (seen !== null) own.value = orbitFrom(seen, bounds());
    following.value = null;
  }

  return {
    own,
    following,
    size,
    revision,
    settings,
    interaction,
    stats,
    shownSettings: computed(() =>
      following.value === null ? settings.value : (leading()?.settings ?? UNCHANGED),
    ),
    move,
    set(changed) {
      settings.value = { ...settings.value, ...changed };
      // A follower has the settings of the followed view; its own are sent with its own view.
      if (own.value !== null && size.value !== null && following.value === null) schedule("settings");
    },
    allow(allowed) {
      interaction.value = allowed;
      if (following.value === null) openView();
    },
    askStats(asked) {
      stats.value = asked;
      // A view of one's own goes on as it is; who follows has none to change.
      if (following.value !== null) openView();
      else if (own.value !== null && size.value !== null) schedule("settings");
    },
    jump: (camera) => move(() => orbitFrom(camera, bounds())),
    follow(client) {
      if (client === null) leave();
      following.value = client;
      latency.restart();
      openView();
    },
    resize(width, height) {
      const before = size.value;
      if (width === before?.width && height === before.height) return;
      size.value = { width, height };
      if (before === null) openView();
      else send({ type: "viewport", width, height });
    },
    cameraOf(header) {
      if (following.value !== null) return cameraOfFollowed();
      return sentCameras.get(header?.cameraRevision ?? -1) ?? own.value?.camera ?? null;
    },
    restore(view, kept) {
      own.value ??= view;
      settings.value = kept;
    },
    open(camera) {
      own.value ??= orbitFrom(camera, bounds());
      openView();
    },
    people(everybody) {
      // A server that has started again gives out its numbers again, so the person counts too.
      const leader = present.value.find(({ client }) => client === following.value);
      const stays = everybody.some((p) => p.client === leader?.client && p.actor.id === leader.actor.id);
      const left = following.value !== null && !stays;
      if (left) leave();
      present.value = everybody;
      if (left) openView();
    },
  };
}
