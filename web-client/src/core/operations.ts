// What this page has asked for and not yet seen in the log.

import { type ReadonlySignal, signal } from "@preact/signals-core";

import type { Host } from "./connection";
import type { LatencyMeter } from "./latency";
import type { ClientMessage, Command, EditResult, Record } from "./protocol";

/** A request that ends in a record. */
export type Request = Extract<ClientMessage, { type: "edit" | "undo" | "redo" }>;

interface Operation {
  request: Request;
  sentMs: number;
  done(record: Record): void;
}

export interface Operations {
  /** Commands under way, in the order in which they were sent. */
  commands: ReadonlySignal<readonly Command[]>;
  /**
   * Sends `request`, or on this connection what `standsFor` it, and remembers it until it is in the log.
   * Then `done` is told its record.
   */
  start(request: Request, standsFor?: ClientMessage, done?: (record: Record) => void): void;
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
  const commands = signal<readonly Command[]>([]);

  function keep(operations: readonly Operation[]): void {
    pending = operations;
    commands.value = pending.flatMap(({ request }) => (request.type === "edit" ? [request.command] : []));
  }

  const forget = (opId: string) => keep(pending.filter(({ request }) => request.opId !== opId));

  return {
    commands,
    start(request, standsFor = request, done = () => {}) {
      if (send(standsFor)) keep([...pending, { request, sentMs: host.nowMs(), done }]);
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
