// The document as the log has it.

import { applyChange, changesPicture, EMPTY } from "./document";
import type { ParameterTable } from "./protocol";
import type { Document, Record } from "./protocol";

/** A document and where in the session's history it stands. */
export interface Mirror {
  document: Document;
  seq: number;
  /** The server's hash of the document. */
  hash: string;
  /** Names the history that `seq` counts in; empty before the first welcome. */
  epoch: string;
  /** The latest record that a picture can show (SPEC, FRAME-7). */
  pictureSeq: number;
}

export const NOTHING: Mirror = { document: EMPTY, seq: 0, hash: "", epoch: "", pictureSeq: 0 };

/** After `record`, which leaves a document with `hash`; `null` where it is not the next record. */
export function advance(table: ParameterTable, mirror: Mirror, record: Record, hash: string): Mirror | null {
  if (record.seq !== mirror.seq + 1) return null;
  const isSeen = record.changes.some((change) => changesPicture(table, mirror.document, change));
  return {
    document: record.changes.reduce(
      (document, change) => applyChange(table, document, change),
      mirror.document,
    ),
    seq: record.seq,
    hash,
    epoch: mirror.epoch,
    pictureSeq: isSeen ? record.seq : mirror.pictureSeq,
  };
}

/** From a snapshot, which holds all that a picture can show. */
export function snapshotOf(epoch: string, seq: number, hash: string, document: Document): Mirror {
  return { document, seq, hash, epoch, pictureSeq: seq };
}
