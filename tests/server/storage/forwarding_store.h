// A store that forwards every call to another one. Tests derive from it to change some calls.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::storage {

class ForwardingStore : public priors::PriorStore {
 public:
  // The default is a store in memory.
  explicit ForwardingStore(
      std::unique_ptr<priors::PriorStore> store = *storage::OpenMemoryPriorStore())
      : store_(std::move(store)) {}

  // Returns the store to which the calls are forwarded.
  priors::PriorStore& behind() { return *store_; }

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override {
    return store_->Commit(updates);
  }
  absl::Status CheckPlace() override { return store_->CheckPlace(); }
  priors::StoreLosses losses() const override { return store_->losses(); }
  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(
      const priors::SceneKey& scene) override {
    return store_->LoadSources(scene);
  }
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override {
    return store_->LoadSource(source_id);
  }
  absl::StatusOr<std::vector<priors::SceneEvidence>> List(
      const priors::SceneFilter& filter, const std::optional<priors::SceneKey>& after,
      uint32_t limit) override {
    return store_->List(filter, after, limit);
  }
  absl::StatusOr<std::optional<priors::SceneEvidence>> LoadScene(
      const priors::SceneKey& key) override {
    return store_->LoadScene(key);
  }
  absl::StatusOr<std::set<std::pair<std::string, uint32_t>>> LoadKnownArms(
      const std::string& project, const std::string& scene) override {
    return store_->LoadKnownArms(project, scene);
  }
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override {
    return store_->CountScenes(project);
  }
  absl::StatusOr<uint64_t> CountProjects() override { return store_->CountProjects(); }
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return store_->Export(filter, after, limit);
  }
  absl::StatusOr<priors::ExportPage> ExportQuarantined(const priors::SceneFilter& filter,
                                                       const priors::ExportPlace& after,
                                                       uint32_t limit) override {
    return store_->ExportQuarantined(filter, after, limit);
  }
  void StopChangesWhen(const std::atomic<bool>& flag) override { store_->StopChangesWhen(flag); }
  absl::StatusOr<priors::ImportResult> Import(
      std::span<const priors::PriorRecord> records) override {
    return store_->Import(records);
  }
  absl::StatusOr<priors::ImportResult> Quarantine(std::span<const priors::PriorRecord> records,
                                                  uint64_t max_records) override {
    return store_->Quarantine(records, max_records);
  }
  absl::StatusOr<priors::ChangeResult> Promote(const priors::SourceFilter& filter,
                                               const priors::Preview& preview) override {
    return store_->Promote(filter, preview);
  }
  absl::StatusOr<priors::ChangeResult> Revoke(const priors::SourceFilter& filter,
                                              const priors::Preview& preview) override {
    return store_->Revoke(filter, preview);
  }
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override {
    return store_->ListAudit(filter, after, limit);
  }
  absl::StatusOr<std::vector<priors::StoredAuditRow>> LoadAudit(uint64_t segment_id,
                                                                uint64_t first_row, uint32_t limit,
                                                                size_t max_bytes) override {
    return store_->LoadAudit(segment_id, first_row, limit, max_bytes);
  }
  absl::StatusOr<priors::AuditScan> ScanAudit(const priors::AuditFilter& filter,
                                              priors::AuditOrder order, uint64_t start,
                                              uint32_t limit) override {
    return store_->ScanAudit(filter, order, start, limit);
  }

 private:
  const std::unique_ptr<priors::PriorStore> store_;
};

}  // namespace sweepstake::storage
