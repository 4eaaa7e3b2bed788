-- What makes a file of schema 8 of one of schema 7.
ALTER TABLE evidence_key RENAME COLUMN context_bucket TO measured_by;
PRAGMA user_version = 8;
