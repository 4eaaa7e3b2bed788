-- What makes a file of schema 10 of one of schema 9.
CREATE TABLE quarantined_evidence (
  key_id INTEGER NOT NULL REFERENCES evidence_key (id),
  source_id INTEGER NOT NULL REFERENCES source (id),
  sequence INTEGER NOT NULL CHECK (sequence BETWEEN 1 AND 9223372036854775807),
  alpha REAL NOT NULL CHECK (alpha >= 0 AND alpha < 1e15),
  beta REAL NOT NULL CHECK (beta >= 0 AND beta < 1e15),
  window_count INTEGER NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
  bail_out_count INTEGER NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
  hash INTEGER NOT NULL,
  content_hash INTEGER GENERATED ALWAYS AS (
    row_hash(key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)) VIRTUAL,
  PRIMARY KEY (key_id, source_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX quarantined_evidence_by_source ON quarantined_evidence (source_id);
PRAGMA user_version = 10;
