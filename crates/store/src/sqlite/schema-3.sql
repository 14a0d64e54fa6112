-- From version 2 to version 3: the format in which a session began, which says what its proof begins with (SPEC, LOG-4).

ALTER TABLE session ADD COLUMN format INTEGER NOT NULL DEFAULT 3;

PRAGMA user_version = 3;
