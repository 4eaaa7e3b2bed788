#include "server/storage/postgres/postgres_schema.h"

#include <string>

namespace sweepstake::storage {
namespace {

// Keeps two daemons from making the tables at the same time, until the transaction's end.
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(7743300015)";

constexpr int64_t kSchemaVersion = 1;

// Names are compared byte by byte. Amounts of evidence are whole units of 2⁻²⁰. All amounts and
// counts of windows are numeric, whose sums are exact in any order. Their bounds have two sides,
// because PostgreSQL sorts NaN above every number. The store numbers the sources.
//
// Evidence refers to keys and sources without REFERENCES: neither is ever deleted, and the checks
// would take longer than writing the row. A scene holds the last transaction that changed its
// evidence, without an index, which each commit would have to update.
//
// A commit changes many rows of a page. A page that is less than half full has room for their new
// versions, so that no index is updated. The next commit uses the room of the old versions.
constexpr const char* kSchema = R"sql(
  CREATE TABLE store (id text NOT NULL, resume_key bytea);
  INSERT INTO store VALUES (gen_random_uuid()::text);
  CREATE SEQUENCE source_number;
  CREATE TABLE source (
    id bigint PRIMARY KEY,
    name text COLLATE "C" NOT NULL UNIQUE CHECK (octet_length(name) BETWEEN 1 AND 128),
    is_session boolean NOT NULL DEFAULT false,
    revoked boolean NOT NULL DEFAULT false,
    commit_sequence bigint NOT NULL DEFAULT 0 CHECK (commit_sequence >= 0),
    message_sequence bigint NOT NULL DEFAULT 0 CHECK (message_sequence >= 0),
    explored_arm_count bigint NOT NULL DEFAULT 0
      CHECK (explored_arm_count BETWEEN 0 AND 4294967295),
    decision_count bigint NOT NULL DEFAULT 0 CHECK (decision_count >= 0),
    frame_count bigint NOT NULL DEFAULT 0 CHECK (frame_count >= 0),
    seed bigint NOT NULL DEFAULT 0,
    created_unix_s bigint NOT NULL DEFAULT 0 CHECK (created_unix_s >= 0),
    last_seen_unix_s bigint NOT NULL DEFAULT 0 CHECK (last_seen_unix_s >= 0),
    build text COLLATE "C" NOT NULL DEFAULT '',
    token_id bigint NOT NULL DEFAULT 0 CHECK (token_id >= 0),
    writer bigint NOT NULL DEFAULT 0
  ) WITH (fillfactor = 45);

  CREATE TABLE scene (
    id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    project text COLLATE "C" NOT NULL CHECK (octet_length(project) BETWEEN 1 AND 128),
    scene text COLLATE "C" NOT NULL CHECK (octet_length(scene) BETWEEN 1 AND 128),
    machine_class text COLLATE "C" NOT NULL CHECK (octet_length(machine_class) <= 128),
    reward_version bigint NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
    source_count bigint NOT NULL DEFAULT 0 CHECK (source_count >= 0),
    changed_in xid8 NOT NULL DEFAULT pg_current_xact_id(),
    UNIQUE (project, scene, machine_class, reward_version)
  ) WITH (fillfactor = 45);

  CREATE TABLE evidence_key (
    id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    scene_id bigint NOT NULL REFERENCES scene,
    project text COLLATE "C" NOT NULL,
    scene text COLLATE "C" NOT NULL,
    measured_by text COLLATE "C" NOT NULL CHECK (measured_by IN ('', 'lane')),
    arm text COLLATE "C" NOT NULL CHECK (octet_length(arm) BETWEEN 1 AND 128),
    backend_version bigint NOT NULL CHECK (backend_version BETWEEN 1 AND 4294967295),
    machine_class text COLLATE "C" NOT NULL,
    reward_version bigint NOT NULL,
    alpha_sum numeric NOT NULL DEFAULT 0 CHECK (alpha_sum >= 0 AND alpha_sum < 1e40),
    beta_sum numeric NOT NULL DEFAULT 0 CHECK (beta_sum >= 0 AND beta_sum < 1e40),
    window_sum numeric NOT NULL DEFAULT 0 CHECK (window_sum >= 0 AND window_sum < 1e40),
    bail_out_sum numeric NOT NULL DEFAULT 0 CHECK (bail_out_sum >= 0 AND bail_out_sum < 1e40),
    source_count bigint NOT NULL DEFAULT 0 CHECK (source_count >= 0),
    UNIQUE (project, scene, measured_by, arm, backend_version, machine_class, reward_version)
  ) WITH (fillfactor = 45);
  CREATE INDEX evidence_key_of_scene ON evidence_key (scene_id);

  CREATE TABLE evidence (
    key_id bigint NOT NULL,
    source_id bigint NOT NULL,
    sequence bigint NOT NULL CHECK (sequence > 0),
    alpha numeric NOT NULL CHECK (alpha >= 0 AND alpha < 1048576e15),
    beta numeric NOT NULL CHECK (beta >= 0 AND beta < 1048576e15),
    window_count numeric NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
    bail_out_count numeric NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
    PRIMARY KEY (key_id, source_id)
  ) WITH (fillfactor = 45);
  CREATE INDEX evidence_of_source ON evidence (source_id, key_id);

  CREATE TABLE quarantined_evidence (
    key_id bigint NOT NULL REFERENCES evidence_key,
    source_id bigint NOT NULL REFERENCES source,
    sequence bigint NOT NULL CHECK (sequence > 0),
    alpha numeric NOT NULL CHECK (alpha >= 0 AND alpha < 1048576e15),
    beta numeric NOT NULL CHECK (beta >= 0 AND beta < 1048576e15),
    window_count numeric NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
    bail_out_count numeric NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
    PRIMARY KEY (key_id, source_id)
  );
  CREATE INDEX quarantined_evidence_of_source ON quarantined_evidence (source_id);

  CREATE TABLE scene_source (
    source_id bigint NOT NULL REFERENCES source,
    scene_id bigint NOT NULL REFERENCES scene,
    PRIMARY KEY (source_id, scene_id)
  );

  CREATE TABLE audit_segment (
    id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    session text COLLATE "C" NOT NULL,
    segment bigint NOT NULL CHECK (segment BETWEEN 1 AND 4294967295),
    project text COLLATE "C" NOT NULL,
    scene text COLLATE "C" NOT NULL,
    unix_start_ms bigint NOT NULL,
    UNIQUE (session, segment)
  );
  CREATE TABLE audit_row (
    id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    segment_id bigint NOT NULL REFERENCES audit_segment,
    number bigint NOT NULL CHECK (number > 0),
    text bytea NOT NULL,
    UNIQUE (segment_id, number)
  );
  CREATE TABLE audit_chunk (
    first_row_id bigint PRIMARY KEY,
    unix_start_s bigint NOT NULL,
    byte_count bigint NOT NULL
  );
)sql";

absl::Status MakeTables(PostgresConnection& connection) {
  absl::Status status = connection.Execute("BEGIN");
  if (status.ok()) status = connection.Run(kLock);
  if (status.ok())
    status = connection.Execute(
        "CREATE SCHEMA IF NOT EXISTS sweepstake; "
        "CREATE TABLE IF NOT EXISTS sweepstake.schema_version (version bigint NOT NULL)");
  int64_t version = 0;
  if (status.ok())
    status =
        connection.ForEachRow("SELECT coalesce(max(version), 0) FROM sweepstake.schema_version",
                              [&](const PostgresRow& row) { version = row.Integer(0); });
  if (status.ok() && version == 0) {
    status = connection.Execute(kSchema);
    if (status.ok())
      status = connection.Run("INSERT INTO schema_version VALUES ($1::bigint)", kSchemaVersion);
  } else if (status.ok() && version != kSchemaVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat("the tables in PostgreSQL have schema version ", version,
                     ", and this daemon reads version ", kSchemaVersion,
                     " alone; use the daemon that made them, or another database"));
  }
  return status.ok() ? connection.Execute("COMMIT") : status;
}

}  // namespace

absl::StatusOr<std::string> PreparePostgresSchema(PostgresConnection& connection) {
  std::string encoding;
  absl::Status status =
      connection.ForEachRow("SELECT current_setting('server_encoding')",
                            [&](const PostgresRow& row) { encoding = row.Text(0); });
  if (!status.ok()) return status;
  if (encoding != "UTF8") {
    return absl::FailedPreconditionError(
        absl::StrCat("the database keeps text as ", encoding,
                     "; make one with `createdb --encoding=UTF8 --template=template0`"));
  }
  status = MakeTables(connection);
  if (status.ok()) return PostgresStoreId(connection);
  connection.Execute("ROLLBACK").IgnoreError();
  return status;
}

absl::StatusOr<std::string> PostgresStoreId(PostgresConnection& connection) {
  std::string id;
  absl::Status status = connection.ForEachRow("SELECT id FROM store",
                                              [&](const PostgresRow& row) { id = row.Text(0); });
  if (!status.ok()) return status;
  return id;
}

}  // namespace sweepstake::storage
