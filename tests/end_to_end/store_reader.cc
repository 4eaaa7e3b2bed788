#include "tests/end_to_end/store_reader.h"

#include <cstdio>
#include <cstdlib>

#include "server/audit/audit_log.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::test_support {
namespace {

[[noreturn]] void Die(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::abort();
}

}  // namespace

priors::SourceState ReadSource(const std::filesystem::path& data, const std::string& source_id) {
  auto store = storage::OpenSqlitePriorStore(data / "priors.db");
  if (!store.ok()) Die(store.status().ToString());
  auto source = (*store)->LoadSource(source_id);
  if (!source.ok()) Die(source.status().ToString());
  if (!source->has_value()) Die("The store does not know session " + source_id);
  return **source;
}

std::string ReadAuditLog(const std::filesystem::path& data) {
  auto store = storage::OpenSqlitePriorStore(data / "priors.db");
  if (!store.ok()) Die(store.status().ToString());
  std::string csv = decision::AuditHeader() + "\n";
  const auto segments = (*store)->ListAudit({}, 0, 1000);
  if (!segments.ok()) Die(segments.status().ToString());
  for (const priors::AuditSegment& segment : *segments) {
    const auto rows = (*store)->LoadAudit(segment.id, 1, 1'000'000, size_t{1} << 30);
    if (!rows.ok()) Die(rows.status().ToString());
    for (const priors::AuditRow& row : *rows) csv += row.text + "\n";
  }
  return csv;
}

priors::Evidence TotalEvidence(const priors::SourceState& source) {
  priors::Evidence total;
  for (const priors::KeyedEvidence& entry : source.evidence) total += entry.evidence;
  return total;
}

}  // namespace sweepstake::test_support
