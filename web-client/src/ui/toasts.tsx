// Messages to the user, visible for a while.

import type { Signal } from "@preact/signals";

import type { Toast } from "./page";
import { sentence } from "./sentence";

export function Toasts({ toasts }: { toasts: Signal<readonly Toast[]> }) {
  const close = (key: number) => (toasts.value = toasts.value.filter((toast) => toast.key !== key));
  return (
    <div class="toasts" role="log" aria-label="Messages">
      {toasts.value.map(({ key, message }) => (
        <button key={key} class="toast" title="Dismiss" onClick={() => close(key)}>
          {sentence(message)}
        </button>
      ))}
    </div>
  );
}
