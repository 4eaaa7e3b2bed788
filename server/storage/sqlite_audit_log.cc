#include "server/storage/sqlite_audit_log.h"

#include <algorithm>
#include <set>
#include <utility>

#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {

using priors::AuditRow;
using priors::AuditRows;
using priors::AuditSegment;

namespace {

constexpr const char* kLastSegment = R"sql(
        SELECT coalesce(max(segment), 0) FROM audit_segment WHERE session = ?1)sql";
constexpr const char* kListSegments = R"sql(
        SELECT id, session, segment, project, scene, unix_start_ms,
               (SELECT min(number) FROM audit_row WHERE segment_id = s.id),
               (SELECT max(number) FROM audit_row WHERE segment_id = s.id),
               (SELECT count(*) FROM audit_row WHERE segment_id = s.id)
        FROM audit_segment s
        WHERE id > ?4 AND (?1 = '' OR session = ?1) AND (?2 = '' OR project = ?2)
          AND (?3 = '' OR scene = ?3)
          AND (?6 = '' OR instr(?6, char(10) || project || char(10)))
        ORDER BY id LIMIT ?5)sql";
constexpr const char* kLoadRows = R"sql(
        SELECT number, text FROM audit_row
        WHERE segment_id = ?1 AND number >= ?2
        ORDER BY number LIMIT ?3)sql";

}  // namespace

const SqliteAuditLog::StatementText SqliteAuditLog::kStatements[] = {
    {&Statements::find_segment, R"sql(
        SELECT id, (SELECT max(number) FROM audit_row WHERE segment_id = s.id)
        FROM audit_segment s WHERE session = ?1 AND segment = ?2)sql"},
    {&Statements::add_segment, R"sql(
        INSERT INTO audit_segment (session, segment, project, scene, unix_start_ms)
        VALUES (?1, ?2, ?3, ?4, ?5)
        RETURNING id)sql"},
    {&Statements::add_row, R"sql(
        INSERT INTO audit_row (segment_id, number, text) VALUES (?1, ?2, ?3))sql"},
    {&Statements::latest_chunk, R"sql(
        SELECT first_row_id, unix_start_s, byte_count
        FROM audit_chunk ORDER BY first_row_id DESC LIMIT 1)sql"},
    {&Statements::add_chunk, R"sql(
        INSERT INTO audit_chunk SELECT coalesce(max(id), 0) + 1, ?1, ?2 FROM audit_row)sql"},
    {&Statements::grow_chunk, R"sql(
        UPDATE audit_chunk SET byte_count = byte_count + ?2 WHERE first_row_id = ?1)sql"},
    {&Statements::oldest_chunk, R"sql(
        SELECT first_row_id, unix_start_s, byte_count,
               (SELECT CAST(total(byte_count) AS INTEGER) FROM audit_chunk)
        FROM audit_chunk ORDER BY first_row_id LIMIT 1)sql"},
    {&Statements::delete_rows, R"sql(
        DELETE FROM audit_row
        WHERE id >= ?1
          AND id < coalesce((SELECT min(first_row_id) FROM audit_chunk WHERE first_row_id > ?1),
                            9223372036854775807)
          AND segment_id NOT IN (SELECT id FROM audit_segment WHERE session = ?2)
        RETURNING segment_id)sql"},
    // The unary plus keeps SQLite from reading all rows by id.
    {&Statements::delete_admin_rows, R"sql(
        DELETE FROM audit_row
        WHERE segment_id IN (SELECT id FROM audit_segment WHERE session = ?1)
          AND +id <= (SELECT r.id FROM audit_segment s CROSS JOIN audit_row r ON r.segment_id = s.id
                      WHERE s.session = ?1
                      ORDER BY s.segment DESC, r.number DESC LIMIT 1 OFFSET ?2)
        RETURNING segment_id)sql"},
    {&Statements::delete_chunk, "DELETE FROM audit_chunk WHERE first_row_id = ?1"},
    {&Statements::delete_empty_segment, R"sql(
        DELETE FROM audit_segment
        WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM audit_row WHERE segment_id = ?1))sql"},
};

absl::StatusOr<SqliteAuditLog> SqliteAuditLog::Open(SqliteDatabase& database,
                                                    const priors::AuditLimits& limits) {
  SqliteAuditLog log(limits);
  if (absl::Status status = log.Prepare(database); !status.ok()) return status;
  return log;
}

absl::Status SqliteAuditLog::Prepare(SqliteDatabase& database) {
  for (const StatementText& text : kStatements) {
    auto statement = database.Prepare(text.sql);
    if (!statement.ok()) return statement.status();
    statements_.*text.statement = *std::move(statement);
  }
  // The limits may be lower than before, and a file that may not grow needs the room. If the disk
  // cannot remove the rows now, a later commit does.
  SqliteTransaction transaction(database);
  if (transaction.begun().ok() && Trim(/*unix_now_s=*/0).ok()) transaction.Commit().IgnoreError();
  return absl::OkStatus();
}

uint64_t SqliteAuditLog::Append(SqliteDatabase& database,
                                std::span<const priors::SourceUpdate* const> updates) {
  uint64_t lost = 0;
  absl::Status status = database.Execute("SAVEPOINT audit");
  if (status.ok()) {
    status = AppendAll(updates, lost);
    const absl::Status ended =
        database.Execute(status.ok() ? "RELEASE audit" : "ROLLBACK TO audit; RELEASE audit");
    if (status.ok()) status = ended;
  }
  if (status.ok()) return lost;
  uint64_t all = 0;
  for (const priors::SourceUpdate* update : updates) all += update->audit.rows.size();
  return all;
}

absl::Status SqliteAuditLog::AppendAll(std::span<const priors::SourceUpdate* const> updates,
                                       uint64_t& lost) {
  uint64_t unix_now_s = 0;
  for (const priors::SourceUpdate* update : updates)
    unix_now_s = std::max(unix_now_s, update->unix_time_s);
  // A database that may not grow reuses the space of removed rows.
  absl::Status status = Trim(unix_now_s);
  for (size_t i = 0; i < updates.size() && status.ok(); ++i) status = AppendOne(*updates[i], lost);
  return status.ok() ? Trim(unix_now_s) : status;
}

absl::Status SqliteAuditLog::AppendOne(const priors::SourceUpdate& update, uint64_t& lost) {
  auto segment = Find(update.progress.source_id, update.audit.segment);
  if (!segment.ok()) return segment.status();
  std::vector<const AuditRow*> rows;
  uint64_t bytes = 0;
  for (const AuditRow& row : update.audit.rows) {
    if (!IsStorable(update.audit, row)) {
      ++lost;
    } else if (row.number > segment->last_row) {
      rows.push_back(&row);
      bytes += row.text.size();
    }
  }
  if (rows.empty()) return absl::OkStatus();
  absl::StatusOr<int64_t> id = segment->id;
  if (*id == 0) id = Add(update.progress.source_id, update.audit);
  absl::Status status = id.status();
  const bool is_admin = update.progress.source_id == decision::kAdminSession;
  if (status.ok() && !is_admin) status = GrowChunk(bytes, update.unix_time_s);
  for (size_t i = 0; i < rows.size() && status.ok(); ++i)
    status = statements_.add_row.Run(*id, rows[i]->number, rows[i]->text);
  return status.ok() && is_admin ? TrimAdmin() : status;
}

absl::StatusOr<SqliteAuditLog::Segment> SqliteAuditLog::Find(const std::string& session_id,
                                                             uint32_t segment) {
  Segment found;
  absl::Status status = statements_.find_segment.ForEachRow(
      [&](const SqliteRow& row) { found = {.id = row.Integer(0), .last_row = row.Unsigned(1)}; },
      session_id, segment);
  if (!status.ok()) return status;
  return found;
}

absl::StatusOr<int64_t> SqliteAuditLog::Add(const std::string& session_id, const AuditRows& rows) {
  int64_t id = 0;
  absl::Status status = statements_.add_segment.ForEachRow(
      [&](const SqliteRow& row) { id = row.Integer(0); }, session_id, rows.segment, rows.project,
      rows.scene, rows.unix_start_ms);
  if (!status.ok()) return status;
  return id;
}

absl::Status SqliteAuditLog::GrowChunk(uint64_t bytes, uint64_t unix_now_s) {
  int64_t first_row_id = 0;
  absl::Status status = statements_.latest_chunk.ForEachRow([&](const SqliteRow& row) {
    const AuditChunk chunk{.unix_start_s = row.Unsigned(1), .byte_count = row.Unsigned(2)};
    if (!IsFull(chunk, limits_, unix_now_s)) first_row_id = row.Integer(0);
  });
  if (!status.ok()) return status;
  return first_row_id == 0 ? statements_.add_chunk.Run(unix_now_s, bytes)
                           : statements_.grow_chunk.Run(first_row_id, bytes);
}

absl::Status SqliteAuditLog::Trim(uint64_t unix_now_s) {
  while (true) {
    int64_t first_row_id = 0;
    absl::Status status = statements_.oldest_chunk.ForEachRow([&](const SqliteRow& row) {
      const AuditChunk chunk{.unix_start_s = row.Unsigned(1), .byte_count = row.Unsigned(2)};
      if (IsBeyond(chunk, row.Unsigned(3), limits_, unix_now_s)) first_row_id = row.Integer(0);
    });
    if (!status.ok() || first_row_id == 0) return status;
    if (status = RemoveChunk(first_row_id); !status.ok()) return status;
  }
}

absl::Status SqliteAuditLog::TrimAdmin() {
  return RemoveRows(statements_.delete_admin_rows, decision::kAdminSession,
                    limits_.admin_row_count);
}

absl::Status SqliteAuditLog::RemoveChunk(int64_t first_row_id) {
  absl::Status status = RemoveRows(statements_.delete_rows, first_row_id, decision::kAdminSession);
  return status.ok() ? statements_.delete_chunk.Run(first_row_id) : status;
}

template <typename... Args>
absl::Status SqliteAuditLog::RemoveRows(SqliteStatement& statement, const Args&... args) {
  std::set<int64_t> segments;
  absl::Status status =
      statement.ForEachRow([&](const SqliteRow& row) { segments.insert(row.Integer(0)); }, args...);
  for (const int64_t segment : segments) {
    if (status.ok()) status = statements_.delete_empty_segment.Run(segment);
  }
  return status;
}

absl::StatusOr<SqliteAuditReader> SqliteAuditReader::Open(SqliteDatabase& database) {
  SqliteAuditReader reader;
  const std::pair<SqliteStatement*, const char*> texts[] = {{&reader.last_segment_, kLastSegment},
                                                            {&reader.list_segments_, kListSegments},
                                                            {&reader.load_rows_, kLoadRows}};
  for (const auto& [statement, sql] : texts) {
    auto prepared = database.Prepare(sql);
    if (!prepared.ok()) return prepared.status();
    *statement = *std::move(prepared);
  }
  return reader;
}

absl::StatusOr<uint32_t> SqliteAuditReader::LastSegment(const std::string& session_id) {
  uint32_t last = 0;
  absl::Status status = last_segment_.ForEachRow(
      [&](const SqliteRow& row) { last = static_cast<uint32_t>(row.Integer(0)); }, session_id);
  if (!status.ok()) return status;
  return last;
}

absl::StatusOr<std::vector<AuditSegment>> SqliteAuditReader::List(const priors::AuditFilter& filter,
                                                                  uint64_t after, uint32_t limit) {
  std::vector<AuditSegment> segments;
  absl::Status status = list_segments_.ForEachRow(
      [&](const SqliteRow& row) {
        const uint64_t first = row.Unsigned(6);
        const uint64_t count = row.Unsigned(8);
        segments.push_back({.id = row.Unsigned(0),
                            .session_id = row.Text(1),
                            .segment = static_cast<uint32_t>(row.Integer(2)),
                            .project = row.Text(3),
                            .scene = row.Text(4),
                            .unix_start_ms = row.Integer(5),
                            .first_row = first,
                            .row_count = count,
                            .lost_row_count = row.Unsigned(7) - first + 1 - count});
      },
      filter.session_id, filter.project, filter.scene, after, limit, LineList(filter.projects));
  if (!status.ok()) return status;
  return segments;
}

absl::StatusOr<std::vector<AuditRow>> SqliteAuditReader::Load(uint64_t segment_id,
                                                              uint64_t first_row, uint32_t limit,
                                                              size_t max_bytes) {
  std::vector<AuditRow> rows;
  size_t bytes = 0;
  absl::Status status = load_rows_.ForEachRow(
      [&](const SqliteRow& row) {
        if (bytes >= max_bytes) return;
        rows.push_back({.number = row.Unsigned(0), .text = row.Text(1)});
        bytes += rows.back().text.size();
      },
      segment_id, first_row, limit);
  if (!status.ok()) return status;
  return rows;
}

}  // namespace sweepstake::storage
