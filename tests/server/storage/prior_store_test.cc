// Every store passes the conformance suite.
#include <cstdlib>

#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/audit_conformance.h"
#include "tests/server/storage/forwarding_store.h"
#include "tests/server/storage/prior_store_conformance.h"
#include "tests/server/storage/quarantine_conformance.h"
#include "tests/server/storage/source_conformance.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

// Keeps the directory while the store exists.
class TemporarySqliteStore final : private test_support::TemporaryDirectory,
                                   public ForwardingStore {
 public:
  TemporarySqliteStore()
      : ForwardingStore(*OpenSqlitePriorStore(path() / "priors.db", kConformanceAuditLimits)) {}
};

const auto kStores =
    ::testing::Values(std::pair<std::string, MakeStore>(
                          "Memory", [] { return *OpenMemoryPriorStore(kConformanceAuditLimits); }),
                      std::pair<std::string, MakeStore>(
                          "File", [] { return std::make_unique<TemporarySqliteStore>(); }));

std::string NameOf(const ::testing::TestParamInfo<std::pair<std::string, MakeStore>>& instance) {
  return instance.param.first;
}

INSTANTIATE_TEST_SUITE_P(Stores, PriorStoreConformance, kStores, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, SourceConformance, kStores, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, QuarantineConformance, kStores, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, AuditConformance, kStores, NameOf);

}  // namespace
}  // namespace sweepstake::storage
