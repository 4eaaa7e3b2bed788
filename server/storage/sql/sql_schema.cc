#include "server/storage/sql/sql_schema.h"

#include "absl/strings/str_replace.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {
namespace {

constexpr const char* kSchema = R"sql(
  CREATE TABLE store (id TEXT NOT NULL{, resume_key bytea}) [STRICT];
  INSERT INTO store VALUES ([lower(hex(randomblob(16)))]{gen_random_uuid()});
  {CREATE SEQUENCE source_number;}

  CREATE TABLE source (
    id INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE CHECK (octet_length(name) BETWEEN 1 AND 128),
    is_session BOOLEAN NOT NULL DEFAULT FALSE [CHECK (is_session IN (0, 1))],
    revoked BOOLEAN NOT NULL DEFAULT FALSE [CHECK (revoked IN (0, 1))],
    commit_sequence INTEGER NOT NULL DEFAULT 0 CHECK (commit_sequence >= 0),
    message_sequence INTEGER NOT NULL DEFAULT 0 CHECK (message_sequence >= 0),
    explored_arm_count INTEGER NOT NULL DEFAULT 0
      CHECK (explored_arm_count BETWEEN 0 AND 4294967295),
    decision_count INTEGER NOT NULL DEFAULT 0 CHECK (decision_count >= 0),
    frame_count INTEGER NOT NULL DEFAULT 0 CHECK (frame_count >= 0),
    seed INTEGER NOT NULL DEFAULT 0,
    created_unix_s INTEGER NOT NULL DEFAULT 0 CHECK (created_unix_s >= 0),
    last_seen_unix_s INTEGER NOT NULL DEFAULT 0 CHECK (last_seen_unix_s >= 0),
    build TEXT NOT NULL DEFAULT '' CHECK (octet_length(build) <= 128),
    token_id INTEGER NOT NULL DEFAULT 0 CHECK (token_id >= 0),
    player TEXT NOT NULL DEFAULT '' CHECK (octet_length(player) <= 64),
    network TEXT NOT NULL DEFAULT '' CHECK (octet_length(network) <= 64)
    {, writer INTEGER NOT NULL DEFAULT 0}
    [, hash INTEGER NOT NULL,
    content_hash INTEGER GENERATED ALWAYS AS (
      row_hash(name, is_session, revoked, commit_sequence, message_sequence, explored_arm_count,
               decision_count, frame_count, seed, created_unix_s, last_seen_unix_s, build,
               token_id, player, network)) VIRTUAL]
  ) OPTIONS;

  CREATE TABLE scene (
    id ROW_ID PRIMARY KEY,
    project TEXT NOT NULL CHECK (octet_length(project) BETWEEN 1 AND 128),
    scene TEXT NOT NULL CHECK (octet_length(scene) BETWEEN 1 AND 128),
    machine_class TEXT NOT NULL CHECK (octet_length(machine_class) <= 128),
    reward_version INTEGER NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
    source_count INTEGER NOT NULL DEFAULT 0 CHECK (source_count >= 0),
    is_known BOOLEAN NOT NULL DEFAULT FALSE [CHECK (is_known IN (0, 1))],
    added_by_token INTEGER NOT NULL DEFAULT 0,
    added_by_party TEXT NOT NULL DEFAULT '',
    {changed_in xid8 NOT NULL DEFAULT pg_current_xact_id(),}
    [hash INTEGER NOT NULL,
    content_hash INTEGER GENERATED ALWAYS AS (
      row_hash(project, scene, machine_class, reward_version, source_count, is_known,
               added_by_token, added_by_party)) VIRTUAL,]
    UNIQUE (project, scene, machine_class, reward_version)
  ) OPTIONS;

  CREATE TABLE scene_source (
    source_id INTEGER NOT NULL REFERENCES source,
    scene_id INTEGER NOT NULL REFERENCES scene,
    token_id INTEGER NOT NULL,
    party TEXT NOT NULL,
    PRIMARY KEY (source_id, scene_id)
  ) [STRICT, WITHOUT ROWID];
  CREATE INDEX scene_source_by_party ON scene_source (scene_id, token_id, party, source_id);

  CREATE TABLE scene_party (
    scene_id INTEGER NOT NULL REFERENCES scene,
    token_id INTEGER NOT NULL,
    party TEXT NOT NULL,
    latest_source_id INTEGER NOT NULL,
    PRIMARY KEY (scene_id, token_id, party)
  ) [STRICT, WITHOUT ROWID];
  CREATE INDEX scene_party_by_latest ON scene_party (scene_id, latest_source_id);
  CREATE INDEX scene_party_of_token ON scene_party (scene_id, token_id, latest_source_id);

  CREATE TABLE evidence_key (
    id ROW_ID PRIMARY KEY,
    project TEXT NOT NULL CHECK (octet_length(project) BETWEEN 1 AND 128),
    scene TEXT NOT NULL CHECK (octet_length(scene) BETWEEN 1 AND 128),
    measured_by TEXT NOT NULL CHECK (measured_by IN ('', 'lane')),
    arm TEXT NOT NULL CHECK (octet_length(arm) BETWEEN 1 AND 128),
    backend_version INTEGER NOT NULL CHECK (backend_version BETWEEN 1 AND 4294967295),
    machine_class TEXT NOT NULL CHECK (octet_length(machine_class) <= 128),
    reward_version INTEGER NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
    regime TEXT NOT NULL CHECK (octet_length(regime) <= 128),
    scene_id INTEGER NOT NULL REFERENCES scene,
    alpha_sum REAL NOT NULL DEFAULT 0 CHECK (alpha_sum >= 0 AND alpha_sum < 1e[300]{40}),
    beta_sum REAL NOT NULL DEFAULT 0 CHECK (beta_sum >= 0 AND beta_sum < 1e[300]{40}),
    window_sum COUNT NOT NULL DEFAULT 0 CHECK (window_sum >= 0 {AND window_sum < 1e40}),
    bail_out_sum COUNT NOT NULL DEFAULT 0 CHECK (bail_out_sum >= 0 {AND bail_out_sum < 1e40}),
    source_count INTEGER NOT NULL DEFAULT 0 CHECK (source_count >= 0),
    is_known BOOLEAN NOT NULL DEFAULT FALSE [CHECK (is_known IN (0, 1))],
    [hash INTEGER NOT NULL,
    content_hash INTEGER GENERATED ALWAYS AS (
      row_hash(project, scene, measured_by, arm, backend_version, machine_class, reward_version,
               regime, scene_id, alpha_sum, beta_sum, window_sum, bail_out_sum,
               source_count, is_known)) VIRTUAL,]
    UNIQUE (project, scene, regime, measured_by, arm, backend_version, machine_class,
            reward_version)
  ) OPTIONS;
  CREATE INDEX evidence_key_by_scene ON evidence_key (scene_id, arm, backend_version);
  CREATE INDEX known_arm ON evidence_key (project, scene, arm, backend_version) WHERE is_known;

  CREATE TABLE evidence (
    key_id INTEGER NOT NULL [REFERENCES evidence_key],
    source_id INTEGER NOT NULL [REFERENCES source],
    EVIDENCE_COLUMNS
  ) [STRICT, WITHOUT ROWID]{OPTIONS};
  CREATE INDEX evidence_by_source ON evidence (source_id{, key_id});

  CREATE TABLE quarantined_evidence (
    key_id INTEGER NOT NULL REFERENCES evidence_key,
    source_id INTEGER NOT NULL REFERENCES source,
    EVIDENCE_COLUMNS
  ) [STRICT, WITHOUT ROWID];
  CREATE INDEX quarantined_evidence_by_source ON quarantined_evidence (source_id);

  [CREATE TABLE kept_file (
    name TEXT PRIMARY KEY,
    content BLOB NOT NULL,
    hash INTEGER NOT NULL,
    content_hash INTEGER GENERATED ALWAYS AS (row_hash(name, content)) VIRTUAL
  ) STRICT;]

  CREATE TABLE audit_segment (
    id ROW_ID PRIMARY KEY,
    session TEXT NOT NULL CHECK (octet_length(session) BETWEEN 1 AND 128),
    segment INTEGER NOT NULL CHECK (segment BETWEEN 1 AND 4294967295),
    project TEXT NOT NULL CHECK (octet_length(project) BETWEEN 1 AND 128),
    scene TEXT NOT NULL CHECK (octet_length(scene) BETWEEN 1 AND 128),
    unix_start_ms INTEGER NOT NULL,
    UNIQUE (session, segment)
  ) [STRICT];

  CREATE TABLE audit_row (
    id ROW_ID PRIMARY KEY,
    segment_id INTEGER NOT NULL REFERENCES audit_segment,
    number INTEGER NOT NULL CHECK (number >= 1),
    bytes [BLOB]{bytea} NOT NULL CHECK (octet_length(bytes) BETWEEN 1 AND 65536),
    UNIQUE (segment_id, number)
  ) [STRICT];

  CREATE TABLE audit_chunk (
    first_row_id INTEGER PRIMARY KEY,
    unix_start_s INTEGER NOT NULL CHECK (unix_start_s >= 0),
    byte_count INTEGER NOT NULL CHECK (byte_count >= 0)
  ) [STRICT];
)sql";

constexpr const char* kEvidenceColumns = R"sql(
    sequence INTEGER NOT NULL CHECK (sequence >= 1),
    alpha REAL NOT NULL CHECK (alpha >= 0 AND alpha < [1]{1048576}e15),
    beta REAL NOT NULL CHECK (beta >= 0 AND beta < [1]{1048576}e15),
    window_count COUNT NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
    bail_out_count COUNT NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
    [hash INTEGER NOT NULL,
    content_hash INTEGER GENERATED ALWAYS AS (
      row_hash(key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)) VIRTUAL,]
    PRIMARY KEY (key_id, source_id)
)sql";

std::string Schema() {
  return absl::StrReplaceAll(kSchema, {{"EVIDENCE_COLUMNS", kEvidenceColumns}});
}

}  // namespace

std::string SqliteSchema() {
  return absl::StrReplaceAll(
      SqliteText(Schema()),
      {{"ROW_ID", "INTEGER"}, {"BOOLEAN", "INTEGER"}, {"COUNT", "INTEGER"}, {"OPTIONS", "STRICT"}});
}

std::string PostgresSchema() {
  return absl::StrReplaceAll(PostgresText(Schema(), {}),
                             {{"ROW_ID", "bigint GENERATED ALWAYS AS IDENTITY"},
                              {"INTEGER", "bigint"},
                              {"TEXT", "text COLLATE \"C\""},
                              {"REAL", "numeric"},
                              {"COUNT", "numeric"},
                              {"OPTIONS", "WITH (fillfactor = 45)"}});
}

}  // namespace sweepstake::storage
