// A store whose answers are lost at times, although the disk has what was asked for, and whose wall
// clock is the simulation's. Whatever becomes of its answers, the model learns of each commit.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/priors/prior_store.h"
#include "tests/server/simulation/evidence_model.h"

namespace sweepstake::simulation {

class TroubledStore final : public priors::PriorStore {
 public:
  struct Troubles {
    std::function<bool()> loses_answer;  // of a commit or import that has succeeded
    std::function<uint64_t()> unix_now_s;
  };

  TroubledStore(std::unique_ptr<priors::PriorStore> store, EvidenceModel& model, Troubles troubles)
      : store_(std::move(store)), model_(model), troubles_(std::move(troubles)) {}

  // The store of OpenSqlitePriorStore, which folding needs.
  priors::PriorStore& on_disk() { return *store_; }

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override {
    std::vector<priors::SourceUpdate> dated(updates.begin(), updates.end());
    for (priors::SourceUpdate& update : dated) update.unix_time_s = troubles_.unix_now_s();
    absl::Status status = store_->Commit(dated);
    model_.Commit(dated, status.ok());
    return status.ok() && troubles_.loses_answer() ? LostAnswer() : status;
  }
  absl::StatusOr<priors::ImportResult> Import(
      std::span<const priors::PriorRecord> records) override {
    auto result = store_->Import(records);
    if (result.ok() && troubles_.loses_answer()) return LostAnswer();
    return result;
  }
  uint64_t lost_audit_row_count() const override { return store_->lost_audit_row_count(); }
  absl::StatusOr<priors::PriorSums> LoadPriors(std::span<const priors::EvidenceKey> keys) override {
    return store_->LoadPriors(keys);
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
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override {
    return store_->CountScenes(project);
  }
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return store_->Export(filter, after, limit);
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
  static absl::Status LostAnswer() { return absl::UnavailableError("the answer was lost"); }

  const std::unique_ptr<priors::PriorStore> store_;
  EvidenceModel& model_;
  const Troubles troubles_;
};

}  // namespace sweepstake::simulation
