// The document's cameras: places to look from that everybody shares.

import { seeTheSame } from "../core/camera";
import { freeName, isBlank } from "../core/document";
import type { Camera, DocumentCamera } from "../core/protocol";
import { CameraFormat } from "./camera_format";
import { Icon } from "./icons";
import { focusBeside } from "./list_focus";
import { Name } from "./name";
import { canEdit, usePage } from "./page";
import { QuietButton } from "./quiet_button";

export function CameraList() {
  const page = usePage();
  const { session } = page;
  const { cameras } = session.document.value;
  const disabled = !canEdit(page);
  const present = session.viewer.own.value?.camera;
  const add = (camera: Camera) => {
    const names = cameras.map((entry) => entry.camera.name);
    const name = freeName("camera", names);
    session.edit({ type: "addCamera", camera: { ...camera, name } });
  };
  return (
    <section class="panel" aria-label="Cameras">
      <header class="panel-head">
        <h2>Cameras</h2>
        <QuietButton
          title="Add a camera from this view"
          disabled={disabled || present === undefined}
          press={() => present !== undefined && add(present)}
        >
          <Icon name="plus" />
          <Icon name="camera" />
        </QuietButton>
      </header>
      <ul class="list">
        {cameras.map((entry) => (
          <CameraRow key={entry.id} entry={entry} disabled={disabled} />
        ))}
        {cameras.length === 0 && <li class="empty">None. Add one from this view.</li>}
      </ul>
      <CameraFormat />
    </section>
  );
}

function CameraRow({ entry: { id, camera }, disabled }: { entry: DocumentCamera; disabled: boolean }) {
  const { session } = usePage();
  const name = isBlank(camera.name) ? `camera ${id}` : camera.name;
  const { own, following } = session.viewer;
  const isSeen = own.value !== null && following.value === null && seeTheSame(own.value.camera, camera);
  return (
    <li class="item" data-camera={id} aria-current={isSeen}>
      <button class="item-name" onClick={() => session.viewer.jump(camera)}>
        <Icon name="camera" />
        <Name name={name} title={`${name}: look from here`} />
      </button>
      <QuietButton
        class="item-action"
        title="Remove this camera"
        label={`Remove ${name}`}
        disabled={disabled}
        press={(button) => {
          focusBeside(button);
          session.edit({ type: "removeCamera", camera: id });
        }}
      >
        <Icon name="trash" />
      </QuietButton>
    </li>
  );
}
