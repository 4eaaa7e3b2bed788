#include "server/storage/sql/sql_audit_log.h"

#include <algorithm>
#include <set>

#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

using priors::AuditRows;
using priors::StoredAuditRow;

// In a shared database only one daemon at a time appends to the audit log, so that the rows of a
// chunk have consecutive ids. The lock ends with the transaction; its number is arbitrary.
constexpr const char* kLockLog = "{SELECT pg_advisory_xact_lock(7743300016)}";
constexpr const char* kFindSegment = R"sql(
    SELECT id, (SELECT coalesce(max(number), 0) FROM audit_row WHERE segment_id = s.id)
    FROM audit_segment s WHERE session = ?1 AND segment = ?2)sql";
constexpr const char* kAddSegment = R"sql(
    INSERT INTO audit_segment (session, segment, project, scene, unix_start_ms)
    VALUES (?1, ?2, ?3, ?4, ?5) RETURNING id)sql";
constexpr const char* kAddRows = R"sql(
    INSERT INTO audit_row (segment_id, number, bytes) SELECT ?1, ?2, ?3 {FROM @given ORDER BY 2}
    )sql";
constexpr const char* kLatestChunk = R"sql(
    SELECT first_row_id, unix_start_s, byte_count
    FROM audit_chunk ORDER BY first_row_id DESC LIMIT 1)sql";
constexpr const char* kAddChunk =
    "INSERT INTO audit_chunk SELECT coalesce(max(id), 0) + 1, ?1, ?2 FROM audit_row";
constexpr const char* kGrowChunk =
    "UPDATE audit_chunk SET byte_count = byte_count + ?2 WHERE first_row_id = ?1";
constexpr const char* kOldestChunk = R"sql(
    SELECT first_row_id, unix_start_s, byte_count,
           (SELECT CAST([total]{sum}(byte_count) AS [INTEGER]{bigint}) FROM audit_chunk)
    FROM audit_chunk ORDER BY first_row_id LIMIT 1)sql";
constexpr const char* kDeleteRows = R"sql(
    DELETE FROM audit_row
    WHERE id >= ?1
      AND id < coalesce((SELECT min(first_row_id) FROM audit_chunk WHERE first_row_id > ?1),
                        9223372036854775807)
      AND segment_id NOT IN (SELECT id FROM audit_segment WHERE session = ?2)
    RETURNING segment_id)sql";
// The unary plus keeps SQLite from using the index of ids, with which it would read the rows of all
// sessions.
constexpr const char* kDeleteAdminRows = R"sql(
    DELETE FROM audit_row
    WHERE segment_id IN (SELECT id FROM audit_segment WHERE session = ?1)
      AND +id <= (SELECT r.id FROM audit_segment s [CROSS] JOIN audit_row r ON r.segment_id = s.id
                  WHERE s.session = ?1
                  ORDER BY s.segment DESC, r.number DESC LIMIT 1 OFFSET ?2)
    RETURNING segment_id)sql";
constexpr const char* kDeleteChunk = "DELETE FROM audit_chunk WHERE first_row_id = ?1";
constexpr const char* kDeleteEmptySegments = R"sql(
    DELETE FROM audit_segment {USING @given}
    WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM audit_row WHERE segment_id = ?1))sql";

AuditChunk ChunkOf(const SqlRow& row) {
  return {.unix_start_s = row.Unsigned(1), .byte_count = row.Unsigned(2)};
}

}  // namespace

absl::StatusOr<uint64_t> SqlAuditLog::Append(std::span<const priors::SourceUpdate* const> updates) {
  uint64_t lost = 0;
  absl::Status status = database_.Execute("SAVEPOINT audit");
  if (status.ok()) {
    status = AppendAll(updates, lost);
    if (database_.shared() && (absl::IsUnavailable(status) || absl::IsAborted(status)))
      return status;
    const absl::Status ended =
        database_.Execute(status.ok() ? "RELEASE audit" : "ROLLBACK TO audit; RELEASE audit");
    if (status.ok()) status = ended;
  }
  if (status.ok()) return lost;
  uint64_t all = 0;
  for (const priors::SourceUpdate* update : updates) all += update->audit.rows.size();
  return all;
}

absl::Status SqlAuditLog::AppendAll(std::span<const priors::SourceUpdate* const> updates,
                                    uint64_t& lost) {
  uint64_t unix_now_s = 0;
  for (const priors::SourceUpdate* update : updates)
    unix_now_s = std::max(unix_now_s, update->unix_time_s);
  absl::Status status = database_.Run(kLockLog);
  if (!status.ok()) return status;
  const auto now_s = RetentionTime(unix_now_s);
  if (!now_s.ok()) return now_s.status();
  // If the file has reached its maximum size, the new rows need the space of the rows removed here.
  if (!database_.shared()) status = Trim(*now_s);
  for (size_t i = 0; i < updates.size() && status.ok(); ++i)
    status = AppendOne(*updates[i], *now_s, lost);
  return status.ok() ? Trim(*now_s) : status;
}

absl::StatusOr<uint64_t> SqlAuditLog::RetentionTime(uint64_t unix_now_s) {
  if (!clock_) {
    uint64_t start_s = 0;
    absl::Status status =
        database_.ForEachRow(kLatestChunk, [&](const SqlRow& row) { start_s = row.Unsigned(1); });
    if (!status.ok()) return status;
    clock_.emplace(start_s);
  }
  return clock_->Follow(unix_now_s, limits_.steady_ns());
}

absl::Status SqlAuditLog::AppendOne(const priors::SourceUpdate& update, uint64_t now_s,
                                    uint64_t& lost) {
  const auto segment = Find(update.progress.source_id, update.audit.segment);
  if (!segment.ok()) return segment.status();
  std::vector<const StoredAuditRow*> rows;
  uint64_t bytes = 0;
  for (const StoredAuditRow& row : update.audit.rows) {
    if (!IsStorable(update.audit, row)) {
      ++lost;
    } else if (row.number > segment->last_row) {
      rows.push_back(&row);
      bytes += row.bytes.size();
    }
  }
  if (rows.empty()) return absl::OkStatus();
  absl::StatusOr<int64_t> id = segment->id;
  if (*id == 0) {
    const AuditRows& added = update.audit;
    id = database_.ReadInteger(kAddSegment, update.progress.source_id, added.segment, added.project,
                               added.scene, added.unix_start_ms);
  }
  absl::Status status = id.status();
  const bool is_admin = update.progress.source_id == decision::kAdminSession;
  if (status.ok() && !is_admin) status = GrowChunk(bytes, now_s);
  if (!status.ok()) return status;
  SqlBatch batch;
  for (const StoredAuditRow* row : rows) batch.Add(*id, row->number, SqlBytes{row->bytes});
  status = database_.Run(kAddRows, batch);
  if (!status.ok() || !is_admin) return status;
  return RemoveRows(kDeleteAdminRows, decision::kAdminSession, limits_.admin_row_count);
}

absl::StatusOr<SqlAuditLog::Segment> SqlAuditLog::Find(const std::string& session_id,
                                                       uint32_t segment) {
  return database_.Collect<Segment>(
      kFindSegment,
      [](const SqlRow& row, Segment& found) {
        found = {.id = row.Integer(0), .last_row = row.Unsigned(1)};
      },
      session_id, segment);
}

absl::Status SqlAuditLog::GrowChunk(uint64_t bytes, uint64_t now_s) {
  int64_t first_row_id = 0;
  absl::Status status = database_.ForEachRow(kLatestChunk, [&](const SqlRow& row) {
    if (!IsFull(ChunkOf(row), limits_, now_s)) first_row_id = row.Integer(0);
  });
  if (!status.ok()) return status;
  return first_row_id == 0 ? database_.Run(kAddChunk, now_s, bytes)
                           : database_.Run(kGrowChunk, first_row_id, bytes);
}

absl::Status SqlAuditLog::Trim(uint64_t now_s) {
  while (true) {
    int64_t first_row_id = 0;
    absl::Status status = database_.ForEachRow(kOldestChunk, [&](const SqlRow& row) {
      if (IsBeyond(ChunkOf(row), row.Unsigned(3), limits_, now_s)) first_row_id = row.Integer(0);
    });
    if (!status.ok() || first_row_id == 0) return status;
    status = RemoveRows(kDeleteRows, first_row_id, decision::kAdminSession);
    if (status.ok()) status = database_.Run(kDeleteChunk, first_row_id);
    if (!status.ok()) return status;
  }
}

template <typename... Args>
absl::Status SqlAuditLog::RemoveRows(const char* sql, const Args&... args) {
  std::set<int64_t> segments;
  absl::Status status = database_.ForEachRow(
      sql, [&](const SqlRow& row) { segments.insert(row.Integer(0)); }, args...);
  SqlBatch batch;
  for (const int64_t segment : segments) batch.Add(segment);
  return status.ok() ? database_.Run(kDeleteEmptySegments, batch) : status;
}

}  // namespace sweepstake::storage
