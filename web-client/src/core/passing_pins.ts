// Edits that pass over pins, while their person asks for that.

import type { ReadonlySignal } from "@preact/signals-core";

import type { Drag } from "./drags";
import { isHeld, passingPins } from "./ignored_pins";
import type { Command } from "./protocol";
import type { Session } from "./session";

/** `session`, whose drags and edits pass over pins while `passes` is true. A drag changes with it, without a move. */
export function withPassing(session: Session, passes: ReadonlySignal<boolean>): Session {
  const asked = (command: Command) => (passes.value ? passingPins(command) : command);
  return {
    ...session,
    edit: (command, done) => session.edit(asked(command), done),
    drag(light): Drag {
      const drag = session.drag(light);
      let latest: Command | null = null;
      const stop = passes.subscribe(() => {
        if (latest !== null && isHeld(latest)) drag.update(asked(latest));
      });
      return {
        update(command) {
          latest = command;
          drag.update(asked(command));
        },
        commit(done) {
          stop();
          drag.commit(done);
        },
        cancel() {
          stop();
          drag.cancel();
        },
      };
    },
  };
}
