-- What makes a file of schema 4 of one of schema 3.
ALTER TABLE source ADD COLUMN created_unix_s INTEGER NOT NULL DEFAULT 0
  CHECK (created_unix_s BETWEEN 0 AND 9223372036854775807);
ALTER TABLE source ADD COLUMN last_seen_unix_s INTEGER NOT NULL DEFAULT 0
  CHECK (last_seen_unix_s BETWEEN 0 AND 9223372036854775807);
PRAGMA user_version = 4;
