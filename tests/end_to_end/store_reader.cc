#include "tests/end_to_end/store_reader.h"

#include <cstdio>
#include <cstdlib>

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

priors::Evidence TotalEvidence(const priors::SourceState& source) {
  priors::Evidence total;
  for (const priors::KeyedEvidence& entry : source.evidence) total += entry.evidence;
  return total;
}

}  // namespace sweepstake::test_support
