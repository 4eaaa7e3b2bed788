// A store whose answers are sometimes lost although the disk has the change, and whose wall clock
// is the simulation's. The model receives every commit, whether its answer is lost or not.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tests/server/simulation/evidence_model.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::simulation {

class TroubledStore final : public storage::ForwardingStore {
 public:
  struct Troubles {
    // Returns whether to lose the answer of a successful commit or import.
    std::function<bool()> loses_answer;
    std::function<uint64_t()> unix_now_s;
  };

  TroubledStore(std::unique_ptr<priors::PriorStore> store, EvidenceModel& model, Troubles troubles)
      : ForwardingStore(std::move(store)), model_(model), troubles_(std::move(troubles)) {}

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override {
    std::vector<priors::SourceUpdate> dated(updates.begin(), updates.end());
    for (priors::SourceUpdate& update : dated) update.unix_time_s = troubles_.unix_now_s();
    absl::Status status = ForwardingStore::Commit(dated);
    model_.Commit(dated, status.ok());
    return status.ok() && troubles_.loses_answer() ? LostAnswer() : status;
  }
  absl::StatusOr<priors::ImportResult> Import(
      std::span<const priors::PriorRecord> records) override {
    auto result = ForwardingStore::Import(records);
    if (result.ok() && troubles_.loses_answer()) return LostAnswer();
    return result;
  }

 private:
  static absl::Status LostAnswer() { return absl::UnavailableError("the answer was lost"); }

  EvidenceModel& model_;
  const Troubles troubles_;
};

}  // namespace sweepstake::simulation
