// The store in PostgreSQL passes the conformance suite.
#include <gtest/gtest.h>

#include "tests/server/storage/audit_conformance.h"
#include "tests/server/storage/postgres/temporary_postgres_store.h"
#include "tests/server/storage/prior_store_conformance.h"
#include "tests/server/storage/quarantine_conformance.h"
#include "tests/server/storage/source_conformance.h"

namespace sweepstake::storage {
namespace {

const auto kPostgres = ::testing::Values(std::pair<std::string, MakeStore>(
    "Postgres", [] { return OpenStore(Server().NewDatabase(), kConformanceAuditLimits); }));

std::string NameOf(const ::testing::TestParamInfo<std::pair<std::string, MakeStore>>& instance) {
  return instance.param.first;
}

INSTANTIATE_TEST_SUITE_P(Stores, PriorStoreConformance, kPostgres, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, SourceConformance, kPostgres, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, QuarantineConformance, kPostgres, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, AuditConformance, kPostgres, NameOf);

}  // namespace
}  // namespace sweepstake::storage
