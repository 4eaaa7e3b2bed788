-- A file of schema 1, with evidence. Session "b" was revoked; "i" was imported.
PRAGMA application_id = 1398231089;

CREATE TABLE source (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE CHECK (length(CAST(name AS BLOB)) BETWEEN 1 AND 128),
  is_session INTEGER NOT NULL CHECK (is_session IN (0, 1)),
  revoked INTEGER NOT NULL CHECK (revoked IN (0, 1)),
  commit_sequence INTEGER NOT NULL CHECK (commit_sequence BETWEEN 0 AND 9223372036854775807),
  message_sequence INTEGER NOT NULL CHECK (message_sequence BETWEEN 0 AND 9223372036854775807),
  explored_arm_count INTEGER NOT NULL CHECK (explored_arm_count BETWEEN 0 AND 4294967295),
  decision_count INTEGER NOT NULL CHECK (decision_count BETWEEN 0 AND 9223372036854775807),
  frame_count INTEGER NOT NULL CHECK (frame_count BETWEEN 0 AND 9223372036854775807),
  seed INTEGER NOT NULL
) STRICT;

CREATE TABLE evidence_key (
  id INTEGER PRIMARY KEY,
  project TEXT NOT NULL CHECK (length(CAST(project AS BLOB)) BETWEEN 1 AND 128),
  scene TEXT NOT NULL CHECK (length(CAST(scene AS BLOB)) BETWEEN 1 AND 128),
  context_bucket TEXT NOT NULL CHECK (length(CAST(context_bucket AS BLOB)) BETWEEN 0 AND 128),
  arm TEXT NOT NULL CHECK (length(CAST(arm AS BLOB)) BETWEEN 1 AND 128),
  backend_version INTEGER NOT NULL CHECK (backend_version BETWEEN 1 AND 4294967295),
  machine_class TEXT NOT NULL CHECK (length(CAST(machine_class AS BLOB)) BETWEEN 0 AND 128),
  reward_version INTEGER NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
  UNIQUE (project, scene, context_bucket, arm, backend_version, machine_class, reward_version)
) STRICT;

CREATE TABLE evidence (
  key_id INTEGER NOT NULL REFERENCES evidence_key (id),
  source_id INTEGER NOT NULL REFERENCES source (id),
  sequence INTEGER NOT NULL CHECK (sequence BETWEEN 1 AND 9223372036854775807),
  alpha REAL NOT NULL CHECK (alpha >= 0 AND alpha < 1e15),
  beta REAL NOT NULL CHECK (beta >= 0 AND beta < 1e15),
  window_count INTEGER NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
  bail_out_count INTEGER NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
  PRIMARY KEY (key_id, source_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX evidence_by_source ON evidence (source_id);

INSERT INTO source VALUES
  (1, 'a', 1, 0, 3, 30, 2, 300, 3000, -1),
  (2, 'b', 1, 1, 2, 20, 1, 200, 2000, 7),
  (3, 'c', 1, 0, 1, 10, 1, 100, 1000, 8),
  (4, 'i', 0, 0, 9, 0, 0, 0, 0, 0);
INSERT INTO evidence_key VALUES
  (1, 'game', 'harbour', '', 'Grid', 1, 'desktop', 1),
  (2, 'game', 'harbour', '', 'SAP', 1, 'desktop', 1),
  (3, 'game', 'desert', '', 'Grid', 1, 'desktop', 1),
  (4, 'game', 'desert', '', 'KDTree', 1, 'desktop', 1);
INSERT INTO evidence VALUES
  (1, 1, 3, 2.25, 0.75, 3, 6),
  (1, 3, 1, 0.75, 0.25, 1, 2),
  (1, 4, 9, 4.0, 0.5, 3, 0),
  (2, 1, 2, 0.75, 0.25, 1, 0),
  (3, 4, 9, 100.125, 7.5, 9223372036854775807, 1),
  (3, 3, 1, 0.75, 0.25, 9223372036854775807, 1);
PRAGMA user_version = 1;
