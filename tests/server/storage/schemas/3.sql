-- What makes a file of schema 3 of one of schema 2.
CREATE TABLE scene (
  id INTEGER PRIMARY KEY,
  project TEXT NOT NULL CHECK (length(CAST(project AS BLOB)) BETWEEN 1 AND 128),
  scene TEXT NOT NULL CHECK (length(CAST(scene AS BLOB)) BETWEEN 1 AND 128),
  machine_class TEXT NOT NULL CHECK (length(CAST(machine_class AS BLOB)) BETWEEN 0 AND 128),
  reward_version INTEGER NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
  source_count INTEGER NOT NULL CHECK (source_count BETWEEN 0 AND 9223372036854775807),
  UNIQUE (project, scene, machine_class, reward_version)
) STRICT;

CREATE TABLE scene_source (
  source_id INTEGER NOT NULL REFERENCES source (id),
  scene_id INTEGER NOT NULL REFERENCES scene (id),
  PRIMARY KEY (source_id, scene_id)
) STRICT, WITHOUT ROWID;

ALTER TABLE evidence_key ADD COLUMN scene_id INTEGER REFERENCES scene (id);
ALTER TABLE evidence_key ADD COLUMN alpha_sum REAL NOT NULL DEFAULT 0
  CHECK (alpha_sum >= 0 AND alpha_sum < 1e300);
ALTER TABLE evidence_key ADD COLUMN beta_sum REAL NOT NULL DEFAULT 0
  CHECK (beta_sum >= 0 AND beta_sum < 1e300);
ALTER TABLE evidence_key ADD COLUMN window_sum INTEGER NOT NULL DEFAULT 0
  CHECK (window_sum BETWEEN 0 AND 9223372036854775807);
ALTER TABLE evidence_key ADD COLUMN bail_out_sum INTEGER NOT NULL DEFAULT 0
  CHECK (bail_out_sum BETWEEN 0 AND 9223372036854775807);
ALTER TABLE evidence_key ADD COLUMN source_count INTEGER NOT NULL DEFAULT 0
  CHECK (source_count BETWEEN 0 AND 9223372036854775807);

INSERT INTO scene (project, scene, machine_class, reward_version, source_count)
  SELECT DISTINCT project, scene, machine_class, reward_version, 0 FROM evidence_key;
UPDATE evidence_key AS k SET scene_id = s.id FROM scene s
  WHERE (s.project, s.scene, s.machine_class, s.reward_version) =
        (k.project, k.scene, k.machine_class, k.reward_version);
UPDATE evidence_key
  SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count) =
      (SELECT total(alpha), total(beta), CAST(total(window_count) AS INTEGER),
              CAST(total(bail_out_count) AS INTEGER), count(*)
       FROM evidence WHERE key_id = evidence_key.id);
INSERT INTO scene_source
  SELECT DISTINCT source_id, scene_id FROM evidence JOIN evidence_key k ON k.id = key_id;
UPDATE scene SET source_count = n
  FROM (SELECT scene_id, count(*) AS n FROM scene_source GROUP BY scene_id)
  WHERE scene_id = scene.id;
CREATE INDEX evidence_key_by_scene ON evidence_key (scene_id, arm, backend_version);
PRAGMA user_version = 3;
