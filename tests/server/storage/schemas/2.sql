-- What makes a file of schema 2 of one of schema 1.
CREATE TABLE audit_segment (
  id INTEGER PRIMARY KEY,
  session TEXT NOT NULL CHECK (length(CAST(session AS BLOB)) BETWEEN 1 AND 128),
  segment INTEGER NOT NULL CHECK (segment BETWEEN 1 AND 4294967295),
  project TEXT NOT NULL CHECK (length(CAST(project AS BLOB)) BETWEEN 1 AND 128),
  scene TEXT NOT NULL CHECK (length(CAST(scene AS BLOB)) BETWEEN 1 AND 128),
  unix_start_ms INTEGER NOT NULL,
  row_count INTEGER NOT NULL CHECK (row_count BETWEEN 1 AND 9223372036854775807),
  UNIQUE (session, segment)
) STRICT;

CREATE TABLE audit_row (
  segment_id INTEGER NOT NULL REFERENCES audit_segment (id),
  number INTEGER NOT NULL CHECK (number BETWEEN 1 AND 9223372036854775807),
  text TEXT NOT NULL CHECK (length(CAST(text AS BLOB)) BETWEEN 1 AND 65536),
  UNIQUE (segment_id, number)
) STRICT;

INSERT INTO audit_segment VALUES (1, 'a', 1, 'game', 'harbour', 1800000000000, 2);
INSERT INTO audit_row VALUES (1, 1, 'row 1'), (1, 2, 'row 2');
PRAGMA user_version = 2;
