// The document's cameras: places to look from that everybody shares.

import { seeTheSame } from "../core/camera";
import { freeName, isBlank } from "../core/document";
import type { Camera, DocumentCamera } from "../core/protocol";
import { Icon } from "./icons";
import { canEdit, usePage } from "./page";

export function CameraList() {
  const page = usePage();
  const { session } = page;
  const { cameras } = session.document.value;
  const disabled = !canEdit(page);
  const present = session.viewer.own.value?.camera;
  const add = (camera: Camera) => {
    const names = cameras.map((placed) => placed.camera.name);
    const name = freeName("camera", names);
    session.edit({ type: "addCamera", camera: { ...camera, name } });
  };
  return (
    <section class="panel" aria-label="Cameras">
      <header class="panel-head">
        <h2>Cameras</h2>
        <button
          class="quiet"
          title="Add a camera from this view"
          aria-label="Add a camera from this view"
          disabled={disabled || present === undefined}
          onClick={() => present !== undefined && add(present)}
        >
          <Icon name="plus" />
          <Icon name="camera" />
        </button>
      </header>
      <ul class="list">
        {cameras.map((placed) => (
          <CameraRow key={placed.id} placed={placed} disabled={disabled} />
        ))}
        {cameras.length === 0 && <li class="empty">None. Add one from this view.</li>}
      </ul>
    </section>
  );
}

function CameraRow({ placed: { id, camera }, disabled }: { placed: DocumentCamera; disabled: boolean }) {
  const { session } = usePage();
  const name = isBlank(camera.name) ? `camera ${id}` : camera.name;
  const { own, following } = session.viewer;
  const isSeen = own.value !== null && following.value === null && seeTheSame(own.value.camera, camera);
  return (
    <li class="item" data-camera={id} aria-current={isSeen}>
      <button class="item-name" title="Look from here" onClick={() => session.viewer.jump(camera)}>
        <Icon name="camera" />
        <span class="clipped">{name}</span>
      </button>
      <button
        class="quiet item-action"
        title="Remove this camera"
        aria-label={`Remove ${name}`}
        disabled={disabled}
        onClick={() => session.edit({ type: "removeCamera", camera: id })}
      >
        <Icon name="trash" />
      </button>
    </li>
  );
}
