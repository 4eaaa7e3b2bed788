#include "tests/end_to_end/store_reader.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "server/storage/sqlite_prior_store.h"
#include "tests/engine_client/decider/audit/stored_audit.h"

namespace sweepstake::test_support {
namespace {

[[noreturn]] void Die(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::abort();
}

std::unique_ptr<priors::PriorStore> OpenStore(const std::filesystem::path& data) {
  auto store = storage::OpenSqlitePriorStore(data / "priors.db");
  if (!store.ok()) Die(store.status().ToString());
  return *std::move(store);
}

}  // namespace

priors::SourceState ReadSource(const std::filesystem::path& data, const std::string& source_id) {
  auto source = OpenStore(data)->LoadSource(source_id);
  if (!source.ok()) Die(source.status().ToString());
  if (!source->has_value()) Die("The store does not know session " + source_id);
  return **source;
}

std::vector<priors::SceneEvidence> ReadScenes(const std::filesystem::path& data) {
  auto scenes = OpenStore(data)->List({}, {}, 1000);
  if (!scenes.ok()) Die(scenes.status().ToString());
  return *std::move(scenes);
}

std::vector<decision::AuditRow> ReadAuditLog(const std::filesystem::path& data) {
  auto rows = StoredAudit(*OpenStore(data));
  if (!rows.ok()) Die(rows.status().ToString());
  return *std::move(rows);
}

priors::Evidence TotalEvidence(const priors::SourceState& source) {
  priors::Evidence total;
  for (const priors::KeyedEvidence& entry : source.evidence) total += entry.evidence;
  return total;
}

void ExpectConsistent(const priors::SourceState& source) {
  const priors::Evidence total = TotalEvidence(source);
  EXPECT_NEAR(total.alpha + total.beta,
              static_cast<double>(total.window_count + 10 * total.bail_out_count), 1e-6);
  EXPECT_LE(total.window_count, source.progress.decision_count);
}

}  // namespace sweepstake::test_support
