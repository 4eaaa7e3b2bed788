// All statements of the prior store on SQLite, prepared once. The database must outlive them.
#pragma once

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Statements that write, and reads of the writer.
struct PriorStatements {
  static absl::StatusOr<PriorStatements> Prepare(SqliteDatabase& database);

  SqliteStatement advance_source, add_scene, add_key, advance_evidence, add_evidence, add_to_sums,
      recount_sums, join_scene, count_source, import_source, import_evidence, revoke_source,
      matching_sources, leave_scenes, forget_scenes, delete_evidence, quarantine_evidence,
      drop_quarantined, forget_quarantined, quarantined_of_source, count_quarantined;
};

struct PriorReadStatements {
  static absl::StatusOr<PriorReadStatements> Prepare(SqliteDatabase& database);

  SqliteStatement find_key, scene_classes, scene_keys, latest_sources, token_of_source,
      evidence_of_source, load_source, source_evidence, list_scenes, count_scenes,
      other_keys_of_name, count_projects, find_scene, scene_arms, scene_ages, next_key,
      key_evidence, next_quarantined_key, quarantined_evidence;
};

}  // namespace sweepstake::storage
