#include "server/storage/sqlite_audit_log.h"

#include <algorithm>
#include <utility>

#include "server/storage/record_limits.h"

namespace sweepstake::storage {

using priors::AuditRows;
using priors::AuditSegment;

const SqliteAuditLog::StatementText SqliteAuditLog::kStatements[] = {
    {&Statements::session_rows, R"sql(
        SELECT CAST(total(row_count) AS INTEGER) FROM audit_segment WHERE session = ?1)sql"},
    {&Statements::last_segment, R"sql(
        SELECT coalesce(max(segment), 0) FROM audit_segment WHERE session = ?1)sql"},
    {&Statements::add_segment, R"sql(
        INSERT INTO audit_segment (session, segment, project, scene, unix_start_ms, row_count)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6)
        ON CONFLICT DO NOTHING
        RETURNING id)sql"},
    {&Statements::advance_segment, R"sql(
        UPDATE audit_segment SET row_count = row_count + ?4
        WHERE session = ?1 AND segment = ?2 AND row_count = ?3 - 1
        RETURNING id)sql"},
    {&Statements::add_row, R"sql(
        INSERT INTO audit_row (segment_id, number, text) VALUES (?1, ?2, ?3))sql"},
    {&Statements::oldest_segment, R"sql(
        SELECT id, row_count FROM audit_segment ORDER BY id LIMIT 1)sql"},
    {&Statements::delete_rows, "DELETE FROM audit_row WHERE segment_id = ?1"},
    {&Statements::delete_segment, "DELETE FROM audit_segment WHERE id = ?1"},
    {&Statements::list_segments, R"sql(
        SELECT id, session, segment, project, scene, unix_start_ms, row_count
        FROM audit_segment
        WHERE id > ?4 AND (?1 = '' OR session = ?1) AND (?2 = '' OR project = ?2)
          AND (?3 = '' OR scene = ?3)
        ORDER BY id LIMIT ?5)sql"},
    {&Statements::load_rows, R"sql(
        SELECT text FROM audit_row
        WHERE segment_id = ?1 AND number >= ?2
        ORDER BY number LIMIT ?3)sql"},
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
  auto count = database.QueryInteger("SELECT CAST(total(row_count) AS INTEGER) FROM audit_segment");
  if (!count.ok()) return count.status();
  row_count_ = static_cast<uint64_t>(*count);
  return absl::OkStatus();
}

absl::Status SqliteAuditLog::Append(SqliteDatabase& database,
                                    std::span<const priors::SourceUpdate* const> updates) {
  new_row_count_ = row_count_;
  absl::Status status = database.Execute("SAVEPOINT audit");
  if (!status.ok()) return status;
  status = AppendAll(updates);
  if (!status.ok()) new_row_count_ = row_count_;
  const absl::Status ended =
      database.Execute(status.ok() ? "RELEASE audit" : "ROLLBACK TO audit; RELEASE audit");
  return status.ok() ? ended : status;
}

absl::Status SqliteAuditLog::AppendAll(std::span<const priors::SourceUpdate* const> updates) {
  for (const priors::SourceUpdate* update : updates) {
    absl::Status status = AppendOne(update->progress.source_id, update->audit);
    if (!status.ok()) return status;
  }
  return Trim();
}

absl::Status SqliteAuditLog::AppendOne(const std::string& session_id, const AuditRows& rows) {
  if (rows.rows.empty()) return absl::OkStatus();
  uint64_t stored = 0;
  absl::Status status = statements_.session_rows.ForEachRow(
      [&](const SqliteRow& row) { stored = row.Unsigned(0); }, session_id);
  if (!status.ok()) return status;
  const size_t count = StorableAuditRows(rows, AuditRoom(limits_, stored));
  if (count == 0) return absl::OkStatus();
  const auto segment = Enter(session_id, rows, count);
  if (!segment.ok() || *segment == 0) return segment.status();
  for (size_t i = 0; i < count && status.ok(); ++i)
    status = statements_.add_row.Run(*segment, rows.first_row + i, rows.rows[i]);
  new_row_count_ += count;
  return status;
}

absl::StatusOr<int64_t> SqliteAuditLog::Enter(const std::string& session_id, const AuditRows& rows,
                                              uint64_t count) {
  int64_t id = 0;
  const auto take_id = [&](const SqliteRow& row) { id = row.Integer(0); };
  absl::Status status =
      rows.first_row == 1
          ? statements_.add_segment.ForEachRow(take_id, session_id, rows.segment, rows.project,
                                               rows.scene, rows.unix_start_ms, count)
          : statements_.advance_segment.ForEachRow(take_id, session_id, rows.segment,
                                                   rows.first_row, count);
  if (!status.ok()) return status;
  return id;
}

absl::Status SqliteAuditLog::Trim() {
  while (new_row_count_ > limits_.rows) {
    int64_t id = 0;
    uint64_t count = 0;
    absl::Status status = statements_.oldest_segment.ForEachRow([&](const SqliteRow& row) {
      id = row.Integer(0);
      count = row.Unsigned(1);
    });
    if (status.ok() && id == 0) return absl::OkStatus();
    if (status.ok()) status = statements_.delete_rows.Run(id);
    if (status.ok()) status = statements_.delete_segment.Run(id);
    if (!status.ok()) return status;
    new_row_count_ -= std::min(count, new_row_count_);
  }
  return absl::OkStatus();
}

absl::StatusOr<uint32_t> SqliteAuditLog::LastSegment(const std::string& session_id) {
  uint32_t last = 0;
  absl::Status status = statements_.last_segment.ForEachRow(
      [&](const SqliteRow& row) { last = static_cast<uint32_t>(row.Integer(0)); }, session_id);
  if (!status.ok()) return status;
  return last;
}

absl::StatusOr<std::vector<AuditSegment>> SqliteAuditLog::List(const priors::AuditFilter& filter,
                                                               uint64_t after, uint32_t limit) {
  std::vector<AuditSegment> segments;
  absl::Status status = statements_.list_segments.ForEachRow(
      [&](const SqliteRow& row) {
        segments.push_back({.id = row.Unsigned(0),
                            .session_id = row.Text(1),
                            .segment = static_cast<uint32_t>(row.Integer(2)),
                            .project = row.Text(3),
                            .scene = row.Text(4),
                            .unix_start_ms = row.Integer(5),
                            .row_count = row.Unsigned(6)});
      },
      filter.session_id, filter.project, filter.scene, after, limit);
  if (!status.ok()) return status;
  return segments;
}

absl::StatusOr<std::vector<std::string>> SqliteAuditLog::Load(uint64_t segment_id,
                                                              uint64_t first_row, uint32_t limit,
                                                              size_t max_bytes) {
  std::vector<std::string> rows;
  size_t bytes = 0;
  absl::Status status = statements_.load_rows.ForEachRow(
      [&](const SqliteRow& row) {
        if (bytes < max_bytes) bytes += rows.emplace_back(row.Text(0)).size();
      },
      segment_id, first_row, limit);
  if (!status.ok()) return status;
  return rows;
}

}  // namespace sweepstake::storage
