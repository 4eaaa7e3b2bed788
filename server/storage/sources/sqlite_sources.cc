#include "server/storage/sources/sqlite_sources.h"

#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

// Removes the source's evidence, and inserts the keys whose sums change into `changed`.
absl::Status RemoveEvidence(PriorStatements& statements, int64_t source,
                            const priors::SourceFilter& filter, priors::RevokeResult& result,
                            KeyIds& changed) {
  absl::Status status = statements.leave_scenes.Run(source, filter.project);
  if (status.ok()) status = statements.forget_scenes.Run(source, filter.project);
  if (!status.ok()) return status;
  status = statements.forget_quarantined.ForEachRow(
      [&](const SqliteRow& row) {
        ++result.record_count;
        result.window_count += row.Unsigned(0);
      },
      source, filter.project);
  if (!status.ok()) return status;
  return statements.delete_evidence.ForEachRow(
      [&](const SqliteRow& row) {
        changed.insert(row.Integer(0));
        ++result.record_count;
        result.window_count += row.Unsigned(1);
      },
      source, filter.project);
}

}  // namespace

absl::StatusOr<std::map<int64_t, std::string>> MatchingSources(PriorStatements& statements,
                                                               const priors::SourceFilter& filter,
                                                               bool quarantined) {
  std::map<int64_t, std::string> sources;
  absl::Status status = statements.matching_sources.ForEachRow(
      [&](const SqliteRow& row) { sources.emplace(row.Integer(0), row.Text(1)); }, filter.id,
      filter.build, filter.token_id, filter.from_unix_s, filter.until_unix_s, filter.project,
      decision::kAdminSession, uint32_t{quarantined});
  if (!status.ok()) return status;
  return sources;
}

absl::Status RecountSums(PriorStatements& statements, const KeyIds& keys) {
  for (const int64_t key : keys) {
    if (absl::Status status = statements.recount_sums.Run(key); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<priors::RevokeResult> RevokeSources(PriorStatements& statements,
                                                   const priors::SourceFilter& filter) {
  auto sources = MatchingSources(statements, filter, /*quarantined=*/false);
  if (!sources.ok()) return sources.status();
  if (sources->empty() && BarsUnknown(filter)) sources->emplace(0, filter.id);
  priors::RevokeResult result;
  KeyIds changed;
  for (const auto& [id, name] : *sources) {
    absl::Status status = RemoveEvidence(statements, id, filter, result, changed);
    if (!status.ok()) return status;
    result.source_count += id == 0 ? 0 : 1;
    status = statements.revoke_source.ForEachRow([](const SqliteRow&) {}, name);
    if (!status.ok()) return status;
  }
  if (absl::Status status = RecountSums(statements, changed); !status.ok()) return status;
  return result;
}

absl::StatusOr<bool> SetAside(PriorStatements& statements, const QuarantinedRow& row) {
  bool applied = false;
  const auto& [source, key, sequence, evidence] = row;
  absl::Status status = statements.quarantine_evidence.ForEachRow(
      [&](const SqliteRow&) { applied = true; }, key.id, source, sequence, evidence.alpha,
      evidence.beta, evidence.window_count, evidence.bail_out_count);
  if (!status.ok()) return status;
  return applied;
}

absl::Status CheckQuarantineSize(PriorStatements& statements, uint64_t max_rows) {
  uint64_t count = 0;
  absl::Status status = statements.count_quarantined.ForEachRow(
      [&](const SqliteRow& row) { count = row.Unsigned(0); });
  return status.ok() ? QuarantineBound(count, max_rows) : status;
}

absl::StatusOr<std::vector<QuarantinedRow>> QuarantinedOf(PriorStatements& statements,
                                                          int64_t source,
                                                          const std::string& project) {
  std::vector<QuarantinedRow> rows;
  absl::Status status = statements.quarantined_of_source.ForEachRow(
      [&](const SqliteRow& row) {
        rows.push_back({.source = source,
                        .key = {.id = row.Integer(0), .scene_id = row.Integer(1)},
                        .sequence = row.Unsigned(2),
                        .evidence = {.alpha = row.Real(3),
                                     .beta = row.Real(4),
                                     .window_count = row.Unsigned(5),
                                     .bail_out_count = row.Unsigned(6)}});
      },
      source, project);
  if (!status.ok()) return status;
  return rows;
}

}  // namespace sweepstake::storage
