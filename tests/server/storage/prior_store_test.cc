// Every store passes the conformance suite.
#include <cstdlib>

#include "server/storage/memory_prior_store.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/storage/audit_conformance.h"
#include "tests/server/storage/prior_store_conformance.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

// Keeps its directory as long as the store.
class TemporarySqliteStore final : public PriorStore {
 public:
  absl::Status Commit(std::span<const SourceUpdate> updates) override {
    return store_->Commit(updates);
  }
  uint64_t lost_audit_row_count() const override { return store_->lost_audit_row_count(); }
  absl::StatusOr<priors::PriorSums> LoadPriors(std::span<const EvidenceKey> keys) override {
    return store_->LoadPriors(keys);
  }
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override {
    return store_->LoadSource(source_id);
  }
  absl::StatusOr<std::vector<priors::SceneEvidence>> List(const priors::SceneFilter& filter,
                                                          const std::optional<SceneKey>& after,
                                                          uint32_t limit) override {
    return store_->List(filter, after, limit);
  }
  absl::StatusOr<std::optional<priors::SceneEvidence>> LoadScene(const SceneKey& key) override {
    return store_->LoadScene(key);
  }
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override {
    return store_->CountScenes(project);
  }
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return store_->Export(filter, after, limit);
  }
  absl::StatusOr<priors::ImportResult> Import(std::span<const PriorRecord> records) override {
    return store_->Import(records);
  }
  absl::StatusOr<uint64_t> Revoke(const std::string& source_id) override {
    return store_->Revoke(source_id);
  }
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override {
    return store_->ListAudit(filter, after, limit);
  }
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override {
    return store_->LoadAudit(segment_id, first_row, limit, max_bytes);
  }

 private:
  test_support::TemporaryDirectory directory_;
  std::unique_ptr<PriorStore> store_ =
      *OpenSqlitePriorStore(directory_.path() / "priors.db", kConformanceAuditLimits);
};

const auto kStores = ::testing::Values(
    std::pair<std::string, MakeStore>(
        "Memory", [] { return std::make_unique<MemoryPriorStore>(kConformanceAuditLimits); }),
    std::pair<std::string, MakeStore>("Sqlite",
                                      [] { return std::make_unique<TemporarySqliteStore>(); }));

std::string NameOf(const ::testing::TestParamInfo<std::pair<std::string, MakeStore>>& instance) {
  return instance.param.first;
}

INSTANTIATE_TEST_SUITE_P(Stores, PriorStoreConformance, kStores, NameOf);
INSTANTIATE_TEST_SUITE_P(Stores, AuditConformance, kStores, NameOf);

}  // namespace
}  // namespace sweepstake::storage
