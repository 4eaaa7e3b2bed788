// The tables of the prior store in SQLite and PostgreSQL.
//
// A row of `evidence_key` is about one regime of a scene: a bucket (policy/regime_bucket.h), or an
// empty text for evidence without a scene descriptor. Its `is_known` makes its arm known
// (PriorReader::LoadKnownArms), that of `scene` shows that some of its arms are. `added_by_token`
// and `added_by_party` of a scene are those of the player whose evidence added it, or 0 and empty.
// It holds the sums of its rows of `evidence`, a row of `scene` the number of its sources. Readers
// therefore need not visit the sources. A row of `scene_source` means that the source has evidence
// about the scene; `token_id` and `party` are those of the source (SourceOrigin::party).
// `scene_party` has the latest source of each party in a scene, so that readers find the latest
// parties without visiting all of their sources. Names are compared byte by byte. Every CHECK of an
// amount has two bounds, because `alpha >= 0` alone would accept +Inf in SQLite, and NaN in
// PostgreSQL.
//
// In SQLite the rows of evidence, keys, scenes' sources and sources have two columns against
// changes on the disk, which SQLite's own checks miss. `hash` is stored; `content_hash` is computed
// (row_hash of sqlite_database.h) at each read. If they differ, the row is damaged.
//
// The table kept_file is for backups (backup/kept_files.h).
//
// In PostgreSQL:
// - Amounts and counts of windows are numeric columns, whose sums are exact in any order. Amounts
//   are whole units of 2⁻²⁰.
// - Evidence refers to keys and sources without REFERENCES. Keys and sources are never deleted, and
//   the checks would take longer than writing the row.
// - `changed_in` of a scene is the last transaction that changed its evidence. It has no index,
//   because each commit would have to update it.
// - Pages are filled to 45 % at first, because a commit changes many rows of a page. The page then
//   has room for their new versions, so that no index must be updated. The next commit reuses the
//   space of the old versions.
#pragma once

#include <cstdint>
#include <string>

namespace sweepstake::storage {

inline constexpr int64_t kSchemaVersion = 2;

// Fills the empty table scene_party.
inline constexpr const char* kMakeParties = R"sql(
    INSERT INTO scene_party (scene_id, token_id, party, latest_source_id)
    SELECT scene_id, token_id, party, max(source_id) FROM scene_source GROUP BY 1, 2, 3)sql";

// Return the statements that create the tables.
std::string SqliteSchema();
std::string PostgresSchema();

}  // namespace sweepstake::storage
