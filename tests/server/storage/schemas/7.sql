-- What makes a file of schema 7 of one of schema 6.
ALTER TABLE source ADD COLUMN hash INTEGER NOT NULL DEFAULT 0;
ALTER TABLE source ADD COLUMN content_hash INTEGER GENERATED ALWAYS AS (
  row_hash(name, is_session, revoked, commit_sequence, message_sequence, explored_arm_count,
           decision_count, frame_count, seed, created_unix_s, last_seen_unix_s)) VIRTUAL;
UPDATE source SET hash = content_hash;

ALTER TABLE scene ADD COLUMN hash INTEGER NOT NULL DEFAULT 0;
ALTER TABLE scene ADD COLUMN content_hash INTEGER GENERATED ALWAYS AS (
  row_hash(project, scene, machine_class, reward_version, source_count)) VIRTUAL;
UPDATE scene SET hash = content_hash;

ALTER TABLE evidence_key ADD COLUMN hash INTEGER NOT NULL DEFAULT 0;
ALTER TABLE evidence_key ADD COLUMN content_hash INTEGER GENERATED ALWAYS AS (
  row_hash(project, scene, context_bucket, arm, backend_version, machine_class, reward_version,
           scene_id, alpha_sum, beta_sum, window_sum, bail_out_sum, source_count)) VIRTUAL;
UPDATE evidence_key SET hash = content_hash;

ALTER TABLE evidence ADD COLUMN hash INTEGER NOT NULL DEFAULT 0;
ALTER TABLE evidence ADD COLUMN content_hash INTEGER GENERATED ALWAYS AS (
  row_hash(key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)) VIRTUAL;
UPDATE evidence SET hash = content_hash;
PRAGMA user_version = 7;
