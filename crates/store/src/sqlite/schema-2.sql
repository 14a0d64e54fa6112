-- From version 1 to version 2: proofs, long values held once, checkpoints, rejections.

-- Of all records up to this one; noted with the hash.
ALTER TABLE record ADD COLUMN proof TEXT CHECK (length(proof) = 64);

DROP TRIGGER record_stays;

-- Hash and proof may be noted once.
CREATE TRIGGER record_stays BEFORE UPDATE ON record
WHEN OLD.proof IS NOT NULL
    OR (OLD.hash IS NOT NULL AND NEW.hash IS NOT OLD.hash)
    OR (OLD.session, OLD.seq, OLD.actor, OLD.op_id, OLD.json)
        IS NOT (NEW.session, NEW.seq, NEW.actor, NEW.op_id, NEW.json)
BEGIN SELECT raise(ABORT, 'a log only grows'); END;

-- Which record was the first to hold a long value, by the SHA-256 of its JSON, and at which byte of its line.
CREATE TABLE held_value (
    session INTEGER NOT NULL REFERENCES session (id),
    hash TEXT NOT NULL CHECK (length(hash) = 64),
    record INTEGER NOT NULL,
    at INTEGER NOT NULL,
    PRIMARY KEY (session, hash)
) STRICT, WITHOUT ROWID;

-- A session after one of its records, so that opening it replays only what follows. The log has all that it says.
CREATE TABLE checkpoint (
    session INTEGER PRIMARY KEY REFERENCES session (id),
    seq INTEGER NOT NULL,
    json TEXT NOT NULL,
    -- SHA-256 of json, in hexadecimal.
    digest TEXT NOT NULL CHECK (length(digest) = 64)
) STRICT;

-- Operations that were refused, so that one that comes again gets the same answer. Later ones have larger numbers.
CREATE TABLE rejection (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    session INTEGER NOT NULL REFERENCES session (id),
    actor TEXT NOT NULL,
    op_id TEXT NOT NULL,
    code TEXT NOT NULL,
    message TEXT NOT NULL,
    UNIQUE (session, actor, op_id)
) STRICT;

CREATE INDEX rejection_by_actor ON rejection (session, actor, id);

PRAGMA user_version = 2;
