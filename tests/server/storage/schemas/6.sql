-- What makes a file of schema 6 of one of schema 5.
ALTER TABLE audit_segment DROP COLUMN row_count;
ALTER TABLE audit_row RENAME TO audit_row_5;

CREATE TABLE audit_row (
  id INTEGER PRIMARY KEY,
  segment_id INTEGER NOT NULL REFERENCES audit_segment (id),
  number INTEGER NOT NULL CHECK (number BETWEEN 1 AND 9223372036854775807),
  text TEXT NOT NULL CHECK (length(CAST(text AS BLOB)) BETWEEN 1 AND 65536),
  UNIQUE (segment_id, number)
) STRICT;

CREATE TABLE audit_chunk (
  first_row_id INTEGER PRIMARY KEY,
  unix_start_s INTEGER NOT NULL CHECK (unix_start_s BETWEEN 0 AND 9223372036854775807),
  byte_count INTEGER NOT NULL CHECK (byte_count BETWEEN 0 AND 9223372036854775807)
) STRICT;

INSERT INTO audit_row SELECT rowid, segment_id, number, text FROM audit_row_5 ORDER BY rowid;
DROP TABLE audit_row_5;
INSERT INTO audit_chunk
  SELECT min(r.id), max(0, max(s.unix_start_ms) / 1000), sum(length(CAST(text AS BLOB)))
  FROM audit_row r JOIN audit_segment s ON s.id = segment_id
  GROUP BY r.id / 5000;  -- some 5 MB each, to be removed one by one
PRAGMA user_version = 6;
