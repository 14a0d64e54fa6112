// The picture, the lights drawn over it, and the viewer's own view.

import type { Signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import type { Box, Size, View } from "../core/camera";
import { isAtLimit } from "../core/document";
import { viewSizeOf } from "../core/frame";
import { pinch, zoomTo } from "../core/navigation";
import type { PixelQuestion } from "../core/probing";
import { AnswerStrip } from "./answer_strip";
import { middleOf } from "./directing";
import { twoFingers } from "./fingers";
import { fitLight, fitScene } from "./fitting";
import { FilmGate } from "./gate";
import { HandLabels } from "./hand_labels";
import { Hints } from "./hints";
import { Icon } from "./icons";
import { Modes } from "./modes";
import { Overlay } from "./overlay";
import { type Page, usePage } from "./page";
import { colorOf, nameOf } from "./person";
import { clickOf, hovering, inPicture, pressPicture, questionOn } from "./picture_press";
import { isProbing, ProbeView } from "./probe_view";
import { QuietButton } from "./quiet_button";
import { sentence } from "./sentence";
import { StatsPanel } from "./stats_panel";
import { ToolBar, ToolChoices } from "./tool_bar";
import { ToolView } from "./tool_view";
import { pressTool, toolKeys } from "./tools";
import { ViewExposure } from "./view_exposure";
import { pressView } from "./view_keys";

const LARGEST_SIDE = 1280;
const ZOOM_PER_WHEEL_PIXEL = 0.0012;

export function Viewport() {
  const page = usePage();
  const { session } = page;
  const { viewer } = session;
  const stage = useRef<HTMLDivElement>(null);
  const size = useSize(stage);
  useEffect(() => {
    const pixels = pictureSize(size, devicePixelRatio);
    if (pixels !== null) viewer.resize(pixels.width, pixels.height);
  }, [viewer, size]);

  const connected = session.connection.value.kind === "connected";
  const frame = session.frame.value;
  const picture = contain(size, frame === null ? size : viewSizeOf(frame));
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
  const { onPointerDown: point, ...hover } = hovering(page);
  const click = clickOf(page);
  const aims = click !== null;
  const tool = page.toolbox.tool.value;
  const keys = useMemo(() => toolKeys(page, () => hereOf(page, stage.current)), [page]);
  return (
    <main class="viewport">
      <ViewTools />
      <ToolBar />
      <div class="picture">
        <div
          class="stage"
          ref={stage}
          data-stale={!connected && frame !== null}
          data-pointing={isProbing(page) || aims}
          data-aiming={aims}
          data-tool={aims || tool === "select" ? undefined : tool === "pin" ? "pin" : "feature"}
          // biome-ignore lint/a11y/noNoninteractiveTabindex: as an application it takes keys
          tabIndex={0}
          role="application"
          aria-label="View: arrow keys orbit, with Shift they pan, plus and minus zoom"
          onKeyDown={(event) => {
            if (click !== null && event.key === "Enter") click(page, middleOf(page));
            else if (click === null && keys(event)) event.preventDefault();
            else pressView(event, page, view);
          }}
          onPointerDown={(event) => {
            point(event);
            if (!pressTool(event, page)) pressPicture(event, page, size);
          }}
          {...hover}
          {...fingers}
          onContextMenu={(event) => event.preventDefault()}
          onWheel={(event) => {
            event.preventDefault();
            const factor = Math.exp(wheelPixels(event) * ZOOM_PER_WHEEL_PIXEL);
            const pixel = inPicture(event.currentTarget, event);
            session.viewer.move((from) => zoomTo(from, factor, session.bounds.value, picture, pixel));
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
          {view !== null && <ToolView view={view} at={picture} size={size} />}
          {view !== null && <HandLabels view={view} at={picture} size={size} />}
          {view !== null && <ProbeView view={view} at={picture} size={size} />}
          <Following />
          <Staleness />
          <Modes />
          <DragRefusal />
        </div>
        {view !== null && <Hints view={view} at={picture} size={size} />}
        <ToolChoices />
        <AnswerStrip />
        <StatsPanel />
      </div>
    </main>
  );
}

function ViewTools() {
  const page = usePage();
  const { showHandles, showGate, showKeys, snaps, probe } = page;
  return (
    <div class="view-tools" role="toolbar" aria-label="View">
      <QuietButton title="Frame the scene (A)" label="Frame the scene" press={() => fitScene(page)}>
        <Icon name="fit" /> Scene
      </QuietButton>
      <QuietButton
        title="Frame the selected light (F)"
        label="Frame the selected light"
        press={() => fitLight(page)}
      >
        <Icon name="fit" /> Light
      </QuietButton>
      <Toggle of={showHandles} title="Show handles (H)" label="Show handles">
        <Icon name="handles" /> Handles
      </Toggle>
      <Toggle of={showGate} title="Darken what render will not write (G)" label="Show the film gate">
        <Icon name="gate" /> Gate
      </Toggle>
      <Toggle
        of={snaps}
        title="Lay points and sources that are dragged on the surface under the pointer (Ctrl turns it around)"
        label="Snap to surfaces"
      >
        <Icon name="snap" /> Snap
      </Toggle>
      <Toggle of={probe.on} title="Say why the pixel under the pointer is lit or not (hold I)" label="Probe">
        <Icon name="probe" /> Probe
      </Toggle>
      <ViewExposure />
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

interface ToggleProps {
  of: Signal<boolean>;
  title: string;
  label: string;
  children: ComponentChildren;
}

function Toggle({ of, ...props }: ToggleProps) {
  return <QuietButton {...props} pressed={of.value} press={() => (of.value = !of.value)} />;
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

/** Why the server does not follow the hand; numbers of a drag are at the hand. */
function DragRefusal() {
  const { session, radiiFollow } = usePage();
  const drag = session.ownDrag.value;
  if (drag === null) return null;
  const { refusal, taken } = drag;
  if (refusal === null && isAtLimit(session.document.value, taken)) {
    return (
      <div class="banner limited-drag" role="status">
        As far as the tube can bend{radiiFollow.value ? "" : ". With Radii follow it becomes thinner instead"}
      </div>
    );
  }
  if (refusal === null) return null;
  return (
    <div class="banner refused-drag" role="alert">
      <span>{sentence(refusal)}</span>
    </div>
  );
}

/** Position of the pointer in the picture, for keys that use it; the middle if the pointer is elsewhere. */
function hereOf(page: Page, stage: Element | null): PixelQuestion | null {
  const { at } = page.probe;
  return (at.value === null || stage === null ? null : questionOn(stage, page, at.value)) ?? middleOf(page);
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

/** Size of the element now. */
function useSize(element: { current: HTMLElement | null }): Size {
  const [size, setSize] = useState<Size>({ width: 0, height: 0 });
  useEffect(() => {
    const { current } = element;
    if (current === null) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry !== undefined) setSize({ width: entry.contentRect.width, height: entry.contentRect.height });
    });
    observer.observe(current);
    return () => observer.disconnect();
  }, [element]);
  return size;
}
