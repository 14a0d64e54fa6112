-- From version 3 to version 4: what a list of sessions says of each, and sessions that go.

-- What people call it; null where that is its name.
ALTER TABLE session ADD COLUMN title TEXT;

ALTER TABLE session ADD COLUMN archived INTEGER NOT NULL DEFAULT 0 CHECK (archived IN (0, 1));

-- When it was made in this folder, in milliseconds since 1970; null where that is not known.
ALTER TABLE session ADD COLUMN made_ms INTEGER;

-- Of the latest record, when it was made and its actor's name, so that a list reads no log; null before the first.
ALTER TABLE session ADD COLUMN changed_ms INTEGER;
ALTER TABLE session ADD COLUMN changed_by TEXT;

UPDATE session SET
    made_ms = (
        SELECT CAST(json ->> '$.timeMs' AS INTEGER) FROM record
        WHERE session = session.id AND seq = 1 AND json_valid(json)
    ),
    (changed_ms, changed_by) = (
        SELECT CAST(json ->> '$.timeMs' AS INTEGER), CAST(json ->> '$.actor.name' AS TEXT) FROM record
        WHERE session = session.id AND json_valid(json)
            AND seq = (SELECT max(seq) FROM record WHERE session = session.id)
    );

CREATE TRIGGER session_is_kept BEFORE DELETE ON session WHEN NOT OLD.archived
BEGIN SELECT raise(ABORT, 'only an archived session goes'); END;

DROP TRIGGER record_is_kept;

-- Records go after their session's row, and with all others of it: what is left of them refers to nothing, and is not committed.
CREATE TRIGGER record_is_kept BEFORE DELETE ON record
WHEN EXISTS (SELECT 1 FROM session WHERE id = OLD.session)
BEGIN SELECT raise(ABORT, 'a log only grows'); END;

PRAGMA user_version = 4;
