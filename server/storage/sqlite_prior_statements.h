// Every statement of the prior store on SQLite, prepared once. The database must outlive them.
#pragma once

#include "absl/status/statusor.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

struct PriorStatements {
  static absl::StatusOr<PriorStatements> Prepare(SqliteDatabase& database);

  SqliteStatement advance_source, find_key, add_scene, add_key, advance_evidence, add_evidence,
      add_to_sums, recount_sums, join_scene, count_source, load_source, source_evidence,
      list_scenes, count_scenes, find_scene, scene_arms, export_records, import_source,
      import_evidence, revoke_source, leave_scenes, forget_scenes, delete_evidence;
};

}  // namespace sweepstake::storage
