#include "server/storage/postgres/postgres_audit_log.h"

#include <algorithm>

#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

using priors::AuditRow;
using priors::AuditRows;

// One daemon writes at a time, so that the rows of a chunk have consecutive ids.
constexpr const char* kLockLog = "SELECT pg_advisory_xact_lock(7743300016)";
constexpr const char* kFindSegment = R"sql(
    SELECT id, (SELECT coalesce(max(number), 0) FROM audit_row WHERE segment_id = s.id)
    FROM audit_segment s WHERE session = $1 AND segment = $2::bigint)sql";
constexpr const char* kAddSegment = R"sql(
    INSERT INTO audit_segment (session, segment, project, scene, unix_start_ms)
    VALUES ($1, $2::bigint, $3, $4, $5::bigint) RETURNING id)sql";
constexpr const char* kAddRows = R"sql(
    INSERT INTO audit_row (segment_id, number, text)
    SELECT $1::bigint, number, text
    FROM unnest($2::bigint[], $3::bytea[]) AS given(number, text) ORDER BY number)sql";
constexpr const char* kLatestChunk = R"sql(
    SELECT first_row_id, unix_start_s, byte_count
    FROM audit_chunk ORDER BY first_row_id DESC LIMIT 1)sql";
constexpr const char* kAddChunk = R"sql(
    INSERT INTO audit_chunk
    SELECT coalesce(max(id), 0) + 1, $1::bigint, $2::bigint FROM audit_row)sql";
constexpr const char* kGrowChunk = R"sql(
    UPDATE audit_chunk SET byte_count = byte_count + $2::bigint
    WHERE first_row_id = $1::bigint)sql";
constexpr const char* kOldestChunk = R"sql(
    SELECT first_row_id, unix_start_s, byte_count,
           (SELECT sum(byte_count)::bigint FROM audit_chunk)
    FROM audit_chunk ORDER BY first_row_id LIMIT 1)sql";
constexpr const char* kDeleteRows = R"sql(
    DELETE FROM audit_row
    WHERE id >= $1::bigint
      AND id < coalesce((SELECT min(first_row_id) FROM audit_chunk
                         WHERE first_row_id > $1::bigint), 9223372036854775807)
      AND segment_id NOT IN (SELECT id FROM audit_segment WHERE session = $2)
    RETURNING segment_id)sql";
constexpr const char* kDeleteAdminRows = R"sql(
    DELETE FROM audit_row WHERE id IN (
      SELECT r.id FROM audit_segment s JOIN audit_row r ON r.segment_id = s.id
      WHERE s.session = $1 ORDER BY s.segment DESC, r.number DESC OFFSET $2::bigint)
    RETURNING segment_id)sql";
constexpr const char* kDeleteChunk = "DELETE FROM audit_chunk WHERE first_row_id = $1::bigint";
constexpr const char* kDeleteEmpty = R"sql(
    DELETE FROM audit_segment s
    WHERE id = ANY($1::bigint[])
      AND NOT EXISTS (SELECT 1 FROM audit_row WHERE segment_id = s.id))sql";

bool EndsTransaction(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsAborted(status);
}

}  // namespace

absl::StatusOr<uint64_t> PostgresAuditLog::Append(
    std::span<const priors::SourceUpdate* const> updates) {
  absl::Status status = connection_.Execute("SAVEPOINT audit");
  if (!status.ok()) return status;
  uint64_t lost = 0;
  const absl::Status appended = AppendAll(updates, lost);
  if (EndsTransaction(appended)) return appended;
  status =
      connection_.Execute(appended.ok() ? "RELEASE audit" : "ROLLBACK TO audit; RELEASE audit");
  if (!status.ok()) return status;
  if (appended.ok()) return lost;
  uint64_t all = 0;
  for (const priors::SourceUpdate* update : updates) all += update->audit.rows.size();
  return all;
}

absl::Status PostgresAuditLog::AppendAll(std::span<const priors::SourceUpdate* const> updates,
                                         uint64_t& lost) {
  uint64_t unix_now_s = 0;
  for (const priors::SourceUpdate* update : updates)
    unix_now_s = std::max(unix_now_s, update->unix_time_s);
  absl::Status status = connection_.Run(kLockLog);
  for (size_t i = 0; i < updates.size() && status.ok(); ++i) status = AppendOne(*updates[i], lost);
  return status.ok() ? Trim(unix_now_s) : status;
}

absl::Status PostgresAuditLog::AppendOne(const priors::SourceUpdate& update, uint64_t& lost) {
  auto segment = Find(update.progress.source_id, update.audit.segment);
  if (!segment.ok()) return segment.status();
  PostgresArray numbers;
  PostgresArray texts;
  uint64_t bytes = 0;
  for (const AuditRow& row : update.audit.rows) {
    if (!IsStorable(update.audit, row)) {
      ++lost;
    } else if (row.number > segment->last_row) {
      numbers.Add(row.number);
      texts.AddBytes(row.text);
      bytes += row.text.size();
    }
  }
  if (bytes == 0) return absl::OkStatus();
  absl::StatusOr<int64_t> id = segment->id;
  if (*id == 0) id = Add(update.progress.source_id, update.audit);
  absl::Status status = id.status();
  const bool is_admin = update.progress.source_id == decision::kAdminSession;
  if (status.ok() && !is_admin) status = GrowChunk(bytes, update.unix_time_s);
  if (status.ok()) status = connection_.Run(kAddRows, *id, numbers, texts);
  if (!status.ok() || !is_admin) return status;
  PostgresArray emptied;
  status = connection_.ForEachRow(
      kDeleteAdminRows, [&](const PostgresRow& row) { emptied.Add(row.Integer(0)); },
      decision::kAdminSession, limits_.admin_row_count);
  return status.ok() ? RemoveEmpty(emptied) : status;
}

absl::StatusOr<PostgresAuditLog::Segment> PostgresAuditLog::Find(const std::string& session_id,
                                                                 uint32_t segment) {
  Segment found;
  absl::Status status = connection_.ForEachRow(
      kFindSegment,
      [&](const PostgresRow& row) { found = {.id = row.Integer(0), .last_row = row.Unsigned(1)}; },
      session_id, segment);
  if (!status.ok()) return status;
  return found;
}

absl::StatusOr<int64_t> PostgresAuditLog::Add(const std::string& session_id,
                                              const AuditRows& rows) {
  int64_t id = 0;
  absl::Status status = connection_.ForEachRow(
      kAddSegment, [&](const PostgresRow& row) { id = row.Integer(0); }, session_id, rows.segment,
      rows.project, rows.scene, rows.unix_start_ms);
  if (!status.ok()) return status;
  return id;
}

absl::Status PostgresAuditLog::GrowChunk(uint64_t bytes, uint64_t unix_now_s) {
  int64_t first_row_id = 0;
  absl::Status status = connection_.ForEachRow(kLatestChunk, [&](const PostgresRow& row) {
    const AuditChunk chunk{.unix_start_s = row.Unsigned(1), .byte_count = row.Unsigned(2)};
    if (!IsFull(chunk, limits_, unix_now_s)) first_row_id = row.Integer(0);
  });
  if (!status.ok()) return status;
  return first_row_id == 0 ? connection_.Run(kAddChunk, unix_now_s, bytes)
                           : connection_.Run(kGrowChunk, first_row_id, bytes);
}

absl::Status PostgresAuditLog::Trim(uint64_t unix_now_s) {
  while (true) {
    int64_t first_row_id = 0;
    absl::Status status = connection_.ForEachRow(kOldestChunk, [&](const PostgresRow& row) {
      const AuditChunk chunk{.unix_start_s = row.Unsigned(1), .byte_count = row.Unsigned(2)};
      if (IsBeyond(chunk, row.Unsigned(3), limits_, unix_now_s)) first_row_id = row.Integer(0);
    });
    if (!status.ok() || first_row_id == 0) return status;
    PostgresArray emptied;
    status = connection_.ForEachRow(
        kDeleteRows, [&](const PostgresRow& row) { emptied.Add(row.Integer(0)); }, first_row_id,
        decision::kAdminSession);
    if (status.ok()) status = connection_.Run(kDeleteChunk, first_row_id);
    if (status.ok()) status = RemoveEmpty(emptied);
    if (!status.ok()) return status;
  }
}

absl::Status PostgresAuditLog::RemoveEmpty(const PostgresArray& segments) {
  return connection_.Run(kDeleteEmpty, segments);
}

}  // namespace sweepstake::storage
