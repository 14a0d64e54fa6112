// The format of what one looks through: a camera of the document, or one's own view.

import { useState } from "preact/hooks";

import { seeTheSame, shotAspect, withAspect } from "../core/camera";
import { FORMATS, formatOf } from "../core/formats";
import type { Camera, DocumentCamera } from "../core/protocol";
import type { Binding } from "./binding";
import { Choice, NumberField } from "./fields";
import { canEdit, type Page, usePage } from "./page";
import { Row } from "./row";

/** Range of typed numbers; film is never wider or narrower. */
const NARROWEST = 0.1;
const WIDEST = 10;

const OWN = "own";

export function CameraFormat() {
  const page = usePage();
  const { viewer } = page.session;
  const { own, following } = viewer;
  const [typed, setTyped] = useState(false);
  if (own.value === null) return null;
  const aspect = shotAspect(own.value.camera);
  const format = typed ? undefined : formatOf(aspect);
  const seen = seenCamera(page, own.value.camera);
  const props = {
    label: "Format",
    doc: `Width over height of what ${seen === undefined ? "your view" : "this camera"} frames: the gate shows it. Pictures of it have this shape.`,
    disabled: following.value !== null || (seen !== undefined && !canEdit(page)),
  };
  const show = (ratio: number) =>
    viewer.move((from) => ({ ...from, camera: withAspect(from.camera, ratio) }));
  const set = (ratio: number) => {
    show(ratio);
    if (seen !== undefined) keepFormat(page, seen, ratio);
  };
  const choose = (label: string) => {
    const chosen = FORMATS.find((format) => format.label === label);
    setTyped(chosen === undefined);
    if (chosen !== undefined) set(chosen.aspect);
  };
  const binding: Binding<number> = {
    set,
    drag() {
      let latest = aspect;
      return {
        update(ratio) {
          latest = ratio;
          show(ratio);
        },
        commit: () => seen !== undefined && keepFormat(page, seen, latest),
        cancel: () => show(aspect),
      };
    },
  };
  return (
    <div class="camera-format">
      <Choice
        {...props}
        value={format?.label ?? OWN}
        choices={[...FORMATS.map(({ label }) => ({ name: label, label })), { name: OWN, label: "Own" }]}
        binding={{ set: choose, drag: () => ({ update: choose, commit() {}, cancel() {} }) }}
      />
      {format === undefined && (
        <Row {...props} label="Ratio">
          <NumberField
            {...props}
            label="Ratio"
            value={aspect}
            binding={binding}
            step={0.01}
            clamp={(ratio) => Math.min(Math.max(ratio, NARROWEST), WIDEST)}
          />
        </Row>
      )}
    </div>
  );
}

/** The document's camera that one looks through, if it is one of its. */
function seenCamera({ session }: Page, view: Camera) {
  return session.document.value.cameras.find(({ camera }) => seeTheSame(view, camera));
}

/** Gives the document's camera this format, for everybody. */
function keepFormat({ session }: Page, { id, camera }: DocumentCamera, aspect: number): void {
  const { projection } = withAspect(camera, aspect);
  session.edit({ type: "setCamera", camera: id, parameter: { projection } });
}
