// A prior store in memory, for tests: the reference the others must equal. Not thread-safe. Memory
// grows with the number of sources; nothing is evicted.
#pragma once

#include <map>
#include <string>

#include "server/decision/prior_store.h"

namespace sweepstake::storage {

class MemoryPriorStore final : public decision::PriorStore {
 public:
  absl::Status Commit(std::span<const decision::SourceUpdate> updates) override;
  absl::StatusOr<decision::PriorSums> LoadPriors(
      std::span<const decision::EvidenceKey> keys) override;
  absl::StatusOr<std::optional<decision::SourceState>> LoadSource(
      const std::string& source_id) override;
  absl::StatusOr<std::vector<decision::SceneEvidence>> List(
      const decision::SceneFilter& filter, const std::optional<decision::SceneKey>& after,
      uint32_t limit) override;
  absl::StatusOr<std::optional<decision::SceneEvidence>> LoadScene(
      const decision::SceneKey& key) override;
  absl::StatusOr<std::vector<decision::PriorRecord>> Export(
      const decision::SceneFilter& filter, const std::optional<decision::PriorRecord>& after,
      uint32_t limit) override;
  absl::StatusOr<decision::ImportResult> Import(
      std::span<const decision::PriorRecord> records) override;
  absl::StatusOr<uint64_t> Revoke(const std::string& source_id) override;

 private:
  struct Source {
    decision::SourceProgress progress;
    bool is_session = false;
    bool revoked = false;
  };
  struct Entry {
    uint64_t sequence = 0;
    decision::Evidence evidence;
  };
  using EntriesBySource = std::map<std::string, Entry>;

  void Apply(const decision::SourceUpdate& update);
  bool ImportOne(const decision::PriorRecord& record);
  decision::SceneEvidence Sum(const decision::SceneKey& key) const;

  std::map<std::string, Source> sources_;
  std::map<decision::EvidenceKey, EntriesBySource> evidence_;
};

}  // namespace sweepstake::storage
