// The tables of the prior store in SQLite and PostgreSQL.
//
// evidence_key holds the sums of its rows of evidence, and scene the number of its sources, so that
// readers need not visit the sources. A row of scene_source means that the source has evidence
// about the scene. Names are compared byte by byte. Every CHECK of an amount has a lower and an
// upper bound, because `alpha >= 0` alone would accept +Inf in SQLite, and NaN in PostgreSQL.
//
// In SQLite each row of the evidence has a hash of its values (row_hash of sqlite_database.h),
// because SQLite's own checks miss a value that was changed on the disk. `content_hash` is computed
// from the values at each use. A row whose `hash` differs is damaged.
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

inline constexpr int64_t kSchemaVersion = 1;

// Return the statements that create the tables.
std::string SqliteSchema();
std::string PostgresSchema();

}  // namespace sweepstake::storage
