// What the socket carries, as protocol/SPEC.md has it. Every wire type is here and only here.

import type { CameraId, ClientId, LightId } from "./ids";
import type { Quat, Vec3 } from "./vector";

// 1. The document

export interface Transform {
  translation: Vec3;
  rotation: Quat;
  scale: number;
}

export type Decay = "none" | "linear" | "inverseSquare";
export type Frame = "rotationMinimizing" | "up";
export type Direction = "tube" | "path";
export type EndMode = "cut" | "extend";

export interface Bendy {
  type: "bendy";
  name: string;
  transform: Transform;
  /** Control points, light-local; the first is the source. */
  points: Vec3[];
  radii: number[];
  colors: Vec3[];
  intensities: number[];
  up: Vec3;
  coneAngle: number;
  coneSoftness: number;
  frame: Frame;
  direction: Direction;
  endMode: EndMode;
  decay: Decay;
}

export interface Spot {
  type: "spot";
  name: string;
  transform: Transform;
  color: Vec3;
  intensity: number;
  coneAngle: number;
  coneSoftness: number;
  /** Endless where absent. */
  range?: number;
  decay: Decay;
}

export type Light = Bendy | Spot;

export type Projection =
  | { perspective: { yfov: number; znear: number; zfar?: number } }
  | { orthographic: { ymag: number; znear: number; zfar: number } };

export interface Camera {
  name: string;
  translation: Vec3;
  rotation: Quat;
  projection: Projection;
}

export interface SceneRef {
  asset: string;
  name: string;
}

export interface DocumentLight {
  id: LightId;
  layout: number;
  light: Light;
}

export interface DocumentCamera {
  id: CameraId;
  camera: Camera;
}

export interface Document {
  scene: SceneRef | null;
  lights: DocumentLight[];
  cameras: DocumentCamera[];
}

// 2. Commands

export type LightParameter =
  | { name: string }
  | { translation: Vec3 }
  | { rotation: Quat }
  | { scale: number }
  | { coneAngle: number }
  | { coneSoftness: number }
  | { decay: Decay }
  | { up: Vec3 }
  | { frame: Frame }
  | { direction: Direction }
  | { endMode: EndMode }
  | { color: Vec3 }
  | { intensity: number }
  | { range: number | null };

export type PointParameter =
  { position: Vec3 } | { radius: number } | { color: Vec3 } | { intensity: number };

export type CameraParameter =
  { name: string } | { translation: Vec3 } | { rotation: Quat } | { projection: Projection };

export type Command =
  | { type: "loadScene"; scene: string }
  | { type: "addLight"; light: Light }
  | { type: "removeLight"; light: LightId }
  | { type: "placeLight"; light: LightId; translation?: Vec3; rotation?: Quat; scale?: number }
  | { type: "setLight"; light: LightId; parameter: LightParameter }
  | { type: "setPoint"; light: LightId; point: number; parameter: PointParameter }
  | {
      type: "insertPoint";
      light: LightId;
      point: number;
      position?: Vec3;
      radius?: number;
      color?: Vec3;
      intensity?: number;
    }
  | { type: "removePoint"; light: LightId; point: number }
  | { type: "addCamera"; camera: Camera }
  | { type: "removeCamera"; camera: CameraId }
  | { type: "placeCamera"; camera: CameraId; translation?: Vec3; rotation?: Quat }
  | { type: "setCamera"; camera: CameraId; parameter: { name: string } | { projection: Projection } };

// 3. Changes and records

export interface ControlPoints {
  layout: number;
  points: Vec3[];
  radii: number[];
  colors: Vec3[];
  intensities: number[];
}

export type Change =
  | { type: "scene"; old: SceneRef | null; new: SceneRef | null }
  | { type: "light"; light: LightId; old: PlacedLight | null; new: PlacedLight | null }
  | { type: "lightParameter"; light: LightId; old: LightParameter; new: LightParameter }
  | {
      type: "point";
      light: LightId;
      layout: number;
      point: number;
      old: PointParameter;
      new: PointParameter;
    }
  | { type: "controlPoints"; light: LightId; old: ControlPoints; new: ControlPoints }
  | { type: "camera"; camera: CameraId; old: Camera | null; new: Camera | null }
  | { type: "cameraParameter"; camera: CameraId; old: CameraParameter; new: CameraParameter };

export interface PlacedLight {
  layout: number;
  light: Light;
}

export interface Actor {
  id: string;
  name: string;
}

export type Scope = "mine" | "session";

export type Action =
  | { type: "edit"; command: Command }
  | { type: "gesture"; command: Command }
  | { type: "undo" | "redo"; scope: Scope; target: number; skipped?: string[] };

export interface Record {
  format: number;
  seq: number;
  timeMs: number;
  actor: Actor;
  opId: string;
  action: Action;
  changes: Change[];
}

// 6. The socket

export type ViewSource = { own: Camera } | { follow: ClientId };

export type ClientMessage =
  | {
      type: "hello";
      protocol: number;
      token: string;
      session: string;
      actor: Actor;
      epoch?: string;
      lastSeq?: number;
    }
  | { type: "openView"; source: ViewSource; width: number; height: number; cameraRevision: number }
  | { type: "setCamera"; camera: Camera; cameraRevision: number }
  | { type: "viewport"; width: number; height: number }
  | { type: "ack"; frame: number }
  | { type: "edit"; opId: string; baseSeq: number; command: Command }
  | { type: "gestureBegin"; gesture: string; light: LightId; baseSeq: number }
  | { type: "gestureUpdate"; gesture: string; update: number; command: Command }
  | { type: "gestureCommit"; gesture: string; opId: string }
  | { type: "gestureCancel"; gesture: string }
  | { type: "undo" | "redo"; opId: string; scope: Scope }
  | { type: "presence"; selection: LightId | null }
  | { type: "ping"; sent: number };

export interface Bounds {
  min: Vec3;
  max: Vec3;
}

export interface Presence {
  client: ClientId;
  actor: Actor;
  selection: LightId | null;
  following: ClientId | null;
  camera: Camera | null;
}

export type GestureEnd = "committed" | "cancelled" | "expired" | "rejected";

export interface GestureState {
  gesture: string;
  client: ClientId;
  light: LightId;
  update: number;
  liveRevision: number;
  changes: Change[];
  ended?: GestureEnd;
  code?: string;
  message?: string;
}

export type State = { tail: Record[] } | { snapshot: Document };

export interface Welcome {
  protocol: number;
  session: string;
  client: ClientId;
  epoch: string;
  seq: number;
  hash: string;
  state: State;
  bounds: Bounds;
  camera: Camera;
  clients: Presence[];
  gestures: GestureState[];
  settings: Settings;
}

export interface Settings {
  ackWindow: number;
  leaseMs: number;
  /** Largest width and height of a view. */
  maxViewSide: number;
}

export type EditStatus = "committed" | "rebased" | "rejected";

export interface EditResult {
  opId: string;
  status: EditStatus;
  seq?: number;
  skipped?: string[];
  code?: string;
  message?: string;
}

export type ServerMessage =
  | ({ type: "welcome" } & Welcome)
  | { type: "log"; record: Record; hash: string; bounds?: Bounds }
  | ({ type: "editResult" } & EditResult)
  | ({ type: "gestureState" } & GestureState)
  | { type: "presence"; clients: Presence[] }
  | { type: "viewConfig"; width: number; height: number; source: ViewSource }
  | { type: "pong"; sent: number; serverTimeUs: number }
  | { type: "draining"; retryAfterMs: number }
  | { type: "error"; code: string; message: string; fatal: boolean };
