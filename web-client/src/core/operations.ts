// Operations of this page that the log does not contain yet.

import { type ReadonlySignal, signal } from "@preact/signals-core";

import type { Host } from "./connection";
import type { LatencyMeter } from "./latency";
import type { Change, ClientMessage, Command, EditResult, Record } from "./protocol";

/** A request that ends in a record. */
export type Request = Extract<ClientMessage, { type: "edit" | "undo" | "redo" }>;

/** Requested change, and the server's changes for it during a drag. */
export interface Underway {
  command: Command;
  changes: readonly Change[];
}

interface Operation {
  request: Request;
  changes: readonly Change[];
  sentMs: number;
  done(record: Record): void;
}

export interface Operations {
  /** Commands under way, in the order in which they were sent. */
  underway: ReadonlySignal<readonly Underway[]>;
  /**
   * Sends `request`, or on this connection what `standsFor` it, and remembers it until it is in the log.
   * Then `done` is told its record. Until then the page shows `changes`, and what is sure of the command.
   */
  start(
    request: Request,
    standsFor?: ClientMessage,
    done?: (record: Record) => void,
    changes?: readonly Change[],
  ): void;
  /** A record of the log, and whether a picture can show it. */
  logged(record: Record, isSeen: boolean): void;
  /** The server's answer, where the mirror stands at `seq`. */
  answered(result: EditResult, seq: number): void;
  /** After a reconnection: sends all again. Their opIds make that harmless (SPEC, REC-4). */
  resend(): void;
}

export interface OperationParts {
  host: Host;
  send(message: ClientMessage): boolean;
  notify(message: string): void;
  latency: LatencyMeter;
}

export function operations({ host, send, notify, latency }: OperationParts): Operations {
  let pending: readonly Operation[] = [];
  const underway = signal<readonly Underway[]>([]);

  function keep(operations: readonly Operation[]): void {
    pending = operations;
    underway.value = pending.flatMap(({ request, changes }) =>
      request.type === "edit" ? [{ command: request.command, changes }] : [],
    );
  }

  const forget = (opId: string) => keep(pending.filter(({ request }) => request.opId !== opId));

  return {
    underway,
    start(request, standsFor = request, done = () => {}, changes = []) {
      if (send(standsFor)) keep([...pending, { request, changes, sentMs: host.nowMs(), done }]);
      else notify("Not connected: nothing was changed. Do it again once the page is connected.");
    },
    logged(record, isSeen) {
      const own = pending.find(({ request }) => request.opId === record.opId);
      if (own === undefined) return;
      if (isSeen) latency.expect("logSeq", record.seq, own.sentMs);
      forget(record.opId);
      own.done(record);
    },
    answered(result, seq) {
      if (result.status === "rejected" || result.status === "unknown") {
        forget(result.opId);
        notify(result.message ?? "The server refused the change.");
        return;
      }
      result.skipped?.forEach(notify);
      // Usually the record itself ends the wait; one from before this connection's snapshot never comes.
      if ((result.seq ?? 0) <= seq) forget(result.opId);
    },
    resend() {
      for (const { request } of pending) send(request);
    },
  };
}
