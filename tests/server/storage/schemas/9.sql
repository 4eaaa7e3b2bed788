-- What makes a file of schema 9 of one of schema 8.
UPDATE source
  SET hash = next_hash(hash, content_hash,
                       row_hash(name, is_session, revoked, commit_sequence, message_sequence,
                                explored_arm_count, decision_count, frame_count, seed,
                                created_unix_s, last_seen_unix_s, '', 0));
ALTER TABLE source DROP COLUMN content_hash;
ALTER TABLE source ADD COLUMN build TEXT NOT NULL DEFAULT ''
  CHECK (length(CAST(build AS BLOB)) BETWEEN 0 AND 128);
ALTER TABLE source ADD COLUMN token_id INTEGER NOT NULL DEFAULT 0
  CHECK (token_id BETWEEN 0 AND 9223372036854775807);
ALTER TABLE source ADD COLUMN content_hash INTEGER GENERATED ALWAYS AS (
  row_hash(name, is_session, revoked, commit_sequence, message_sequence, explored_arm_count,
           decision_count, frame_count, seed, created_unix_s, last_seen_unix_s, build,
           token_id)) VIRTUAL;
PRAGMA user_version = 9;
