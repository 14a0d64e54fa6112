-- Version 1. What a log must never be is refused here too, whatever program writes.

CREATE TABLE session (
    id INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE CHECK (
        length(name) BETWEEN 1 AND 64
        AND name GLOB '[a-zA-Z0-9]*'
        AND name NOT GLOB '*[^a-zA-Z0-9._-]*'
    ),
    -- 128 random bits that name this history.
    epoch TEXT NOT NULL DEFAULT (lower(hex(randomblob(16)))) CHECK (length(epoch) = 32)
) STRICT;

CREATE TABLE record (
    session INTEGER NOT NULL REFERENCES session (id),
    seq INTEGER NOT NULL,
    actor TEXT NOT NULL,
    op_id TEXT NOT NULL,
    -- As in a log file.
    json TEXT NOT NULL,
    -- Of the document after this record; null where it was not noted. The last record has one.
    hash TEXT CHECK (length(hash) = 64),
    PRIMARY KEY (session, seq),
    UNIQUE (session, actor, op_id)
) STRICT;

CREATE TRIGGER record_follows BEFORE INSERT ON record
WHEN NEW.seq <> 1 + (SELECT coalesce(max(seq), 0) FROM record WHERE session = NEW.session)
BEGIN SELECT raise(ABORT, 'a log has no gaps'); END;

CREATE TRIGGER record_stays BEFORE UPDATE ON record
WHEN OLD.hash IS NOT NULL
    OR (OLD.session, OLD.seq, OLD.actor, OLD.op_id, OLD.json)
        IS NOT (NEW.session, NEW.seq, NEW.actor, NEW.op_id, NEW.json)
BEGIN SELECT raise(ABORT, 'a log only grows'); END;

CREATE TRIGGER record_is_kept BEFORE DELETE ON record
BEGIN SELECT raise(ABORT, 'a log only grows'); END;

PRAGMA user_version = 1;
