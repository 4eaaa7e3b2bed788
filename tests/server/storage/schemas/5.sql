-- What makes a file of schema 5 of one of schema 4.
CREATE TABLE store (id TEXT NOT NULL CHECK (length(id) = 32)) STRICT;
INSERT INTO store VALUES (lower(hex(randomblob(16))));
PRAGMA user_version = 5;
