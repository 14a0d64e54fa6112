// The picture, the lights drawn over it, and the viewer's own view.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import type { Box, Size, View } from "../core/camera";
import { orbit, pan, pinch, zoom } from "../core/navigation";
import { twoFingers } from "./fingers";
import { frameLight, frameScene } from "./framing";
import { FilmGate } from "./gate";
import { Icon } from "./icons";
import { Overlay } from "./overlay";
import { type Page, usePage } from "./page";
import { colorOf, nameOf } from "./person";
import { followPointer } from "./pointer";
import { sentence } from "./sentence";
import { pressView } from "./view_keys";

const LARGEST_SIDE = 1280;
const RADIANS_PER_PIXEL = 0.006;
const ZOOM_PER_WHEEL_PIXEL = 0.0012;
/** A press that moves less is a click. */
const CLICK_PX = 4;

export function Viewport() {
  const page = usePage();
  const { session } = page;
  const stage = useRef<HTMLDivElement>(null);
  const size = useSize(stage);
  useEffect(() => {
    const pixels = pictureSize(size, devicePixelRatio);
    if (pixels !== null) session.viewer.resize(pixels.width, pixels.height);
  }, [size.width, size.height]);

  const connected = session.connection.value.kind === "connected";
  const frame = session.frame.value;
  const picture = contain(size, frame ?? size);
  const camera = session.viewer.cameraOf(frame);
  const view: View | null =
    camera === null || size.width === 0 ? null : { camera, width: picture.width, height: picture.height };
  const fingers = useMemo(
    () =>
      twoFingers((before, after) =>
        session.viewer.move((from) => pinch(from, size, before, after, session.bounds.value)),
      ),
    [session, size],
  );
  return (
    <main class="viewport">
      <ViewTools />
      <div
        class="stage"
        ref={stage}
        data-stale={!connected && frame !== null}
        role="application"
        aria-label="View: arrow keys orbit, with Shift they pan, plus and minus zoom"
        tabIndex={0}
        onKeyDown={(event) => pressView(event, page, view)}
        onPointerDown={(event) => startNavigation(event, page, size)}
        {...fingers}
        onContextMenu={(event) => event.preventDefault()}
        onWheel={(event) => {
          event.preventDefault();
          const factor = Math.exp(wheelPixels(event) * ZOOM_PER_WHEEL_PIXEL);
          session.viewer.move((from) => zoom(from, factor, session.bounds.value));
        }}
      >
        <canvas
          ref={page.screen.attach}
          role="img"
          aria-label="Rendered picture"
          style={{
            left: `${picture.x}px`,
            top: `${picture.y}px`,
            width: `${picture.width}px`,
            height: `${picture.height}px`,
          }}
        />
        {view !== null && page.showGate.value && <FilmGate view={view} at={picture} />}
        {view !== null && page.showHandles.value && <Overlay view={view} at={picture} size={size} />}
        <Following />
        <Staleness />
        <DragRefusal />
      </div>
    </main>
  );
}

function ViewTools() {
  const page = usePage();
  const { showHandles, showGate, showKeys } = page;
  return (
    <div class="view-tools" role="toolbar" aria-label="View">
      <button
        class="quiet"
        title="Frame the scene (A)"
        aria-label="Frame the scene"
        onClick={() => frameScene(page)}
      >
        <Icon name="frame" /> Scene
      </button>
      <button
        class="quiet"
        title="Frame the selected light (F)"
        aria-label="Frame the selected light"
        onClick={() => frameLight(page)}
      >
        <Icon name="frame" /> Light
      </button>
      <button
        class="quiet"
        title="Show handles (H)"
        aria-label="Show handles"
        aria-pressed={showHandles.value}
        onClick={() => (showHandles.value = !showHandles.value)}
      >
        <Icon name="handles" /> Handles
      </button>
      <button
        class="quiet"
        title="Darken what render will not write (G)"
        aria-label="Show the film gate"
        aria-pressed={showGate.value}
        onClick={() => (showGate.value = !showGate.value)}
      >
        <Icon name="gate" /> Gate
      </button>
      <span class="spring" />
      <button
        class="quiet"
        title="Keys (?)"
        aria-label="Keys"
        aria-haspopup="dialog"
        onClick={() => (showKeys.value = true)}
      >
        ?
      </button>
    </div>
  );
}

/** Whose view this is, where it is another's. */
function Following() {
  const { session } = usePage();
  const followed = session.viewer.following.value;
  if (followed === null) return null;
  return (
    // A press on it is none on the picture, which would keep the pointer to itself.
    <div
      class="banner"
      style={{ borderColor: colorOf(followed) }}
      onPointerDown={(event) => event.stopPropagation()}
    >
      <Icon name="view" /> {nameOf(session.people.value, followed)}'s view
      <button class="quiet" onClick={() => session.viewer.follow(null)}>
        Stop following
      </button>
    </div>
  );
}

/** Why the picture no longer changes. */
function Staleness() {
  const { session } = usePage();
  const { kind } = session.connection.value;
  if (kind === "connected" || kind === "refused") return null;
  const said = {
    connecting: "Connecting to the server",
    reconnecting: "Connection lost, trying again: this picture is old, and edits are off",
    draining: "The server is stopping: edits are off until it is back",
  }[kind];
  return (
    <div class="banner stale" role="alert">
      {said}
    </div>
  );
}

/** Why the server does not follow the hand. */
function DragRefusal() {
  const refusal = usePage().session.ownDrag.value?.refusal;
  if (refusal === null || refusal === undefined) return null;
  return (
    <div class="banner refused-drag" role="alert">
      <span>{sentence(refusal)}</span>
    </div>
  );
}

/** Alt with the left button or the left button on nothing orbits; shift or the middle button pans. */
function startNavigation(down: PointerEvent, page: Page, size: Size): void {
  if (down.button === 2) return;
  const { viewer } = page.session;
  const pans = down.button === 1 || down.shiftKey;
  let way = 0;
  down.preventDefault();
  (down.currentTarget as HTMLElement).focus({ preventScroll: true });
  followPointer(down, {
    move(_, by) {
      way += Math.hypot(by.x, by.y);
      if (way < CLICK_PX) return;
      viewer.move((from) =>
        pans ? pan(from, size, by) : orbit(from, -by.x * RADIANS_PER_PIXEL, -by.y * RADIANS_PER_PIXEL),
      );
    },
    end() {
      if (way < CLICK_PX && !pans) page.selectedPoint.value = null;
    },
  });
}

/** Wheels that count lines count 16 pixels each. */
const wheelPixels = (event: WheelEvent): number =>
  event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);

/** The picture's size for a stage: sharp on the screen, not too large, even; `null` for no stage. */
export function pictureSize(stage: Size, pixelRatio: number): Size | null {
  const longest = Math.max(stage.width, stage.height);
  if (Math.min(stage.width, stage.height) < 2) return null;
  const ratio = Math.min(pixelRatio, LARGEST_SIDE / longest);
  const even = (length: number) => Math.max(2, 2 * Math.round((length * ratio) / 2));
  return { width: even(stage.width), height: even(stage.height) };
}

/** The largest rectangle of `inner`'s shape in the middle of `outer`. */
function contain(outer: Size, inner: Size): Box {
  const scale = Math.min(outer.width / inner.width, outer.height / inner.height) || 0;
  const [width, height] = [inner.width * scale, inner.height * scale];
  return { width, height, x: (outer.width - width) / 2, y: (outer.height - height) / 2 };
}

/** How large the element is now. */
function useSize(element: { current: HTMLElement | null }): Size {
  const [size, setSize] = useState<Size>({ width: 0, height: 0 });
  useEffect(() => {
    if (element.current === null) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry !== undefined) setSize({ width: entry.contentRect.width, height: entry.contentRect.height });
    });
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return size;
}
