// The tables of the prior store, as SqlDatabase reads them.
//
// evidence_key holds the sums of its rows of evidence, and scene the number of its sources, so that
// readers need not visit the sources. A row of scene_source says that the source has evidence about
// the scene. Names are compared byte by byte. Every bound of an amount has two sides: `alpha >= 0`
// alone would accept +Inf in SQLite, and NaN in PostgreSQL.
//
// In SQLite each row of the evidence has a hash of its values (row_hash of sqlite_database.h),
// because SQLite's own checks miss a value that was changed on the disk. `content_hash` is computed
// from the values at each use. A row whose `hash` differs is damaged.
//
// In PostgreSQL amounts and counts of windows are numeric, whose sums are exact in any order;
// amounts are whole units of 2⁻²⁰. Evidence refers to keys and sources without REFERENCES: neither
// is ever deleted, and the checks would take longer than writing the row. A scene holds the last
// transaction that changed its evidence, without an index, which each commit would have to update.
// A commit changes many rows of a page. A page that is less than half full has room for their new
// versions, so that no index is updated. The next commit uses the room of the old versions.
#pragma once

#include <cstdint>
#include <string>

namespace sweepstake::storage {

inline constexpr int64_t kSchemaVersion = 1;

// The statements that make the tables.
std::string SqliteSchema();
std::string PostgresSchema();

}  // namespace sweepstake::storage
