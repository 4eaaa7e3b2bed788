// A prior store in memory for tests, which is also the reference for the other stores. Not
// thread-safe. The memory grows with the number of sources; nothing is evicted.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"
#include "server/storage/memory/memory_audit_log.h"

namespace sweepstake::storage {

class MemoryPriorStore : public priors::PriorStore {
 public:
  explicit MemoryPriorStore(const priors::AuditLimits& audit_limits = {}) : audit_(audit_limits) {}

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override;
  uint64_t lost_audit_row_count() const override { return lost_audit_row_count_; }
  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(
      const priors::SceneKey& scene) override;
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override;
  absl::StatusOr<std::vector<priors::SceneEvidence>> List(
      const priors::SceneFilter& filter, const std::optional<priors::SceneKey>& after,
      uint32_t limit) override;
  absl::StatusOr<std::optional<priors::SceneEvidence>> LoadScene(
      const priors::SceneKey& key) override;
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override;
  absl::StatusOr<uint64_t> CountProjects() override;
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override;
  absl::StatusOr<priors::ExportPage> ExportQuarantined(const priors::SceneFilter& filter,
                                                       const priors::ExportPlace& after,
                                                       uint32_t limit) override;
  absl::StatusOr<priors::ImportResult> Import(
      std::span<const priors::PriorRecord> records) override;
  absl::StatusOr<priors::ImportResult> Quarantine(std::span<const priors::PriorRecord> records,
                                                  uint64_t max_records) override;
  absl::StatusOr<priors::PromoteResult> Promote(const priors::SourceFilter& filter,
                                                const priors::Preview& preview) override;
  absl::StatusOr<priors::RevokeResult> Revoke(const priors::SourceFilter& filter,
                                              const priors::Preview& preview) override;
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override;
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override;

 private:
  struct Source {
    uint64_t number = 0;
    priors::SourceProgress progress;
    priors::SourceOrigin origin;
    uint64_t created_unix_s = 0;
    uint64_t last_seen_unix_s = 0;
    bool is_session = false;
    bool revoked = false;
  };
  struct Entry {
    uint64_t sequence = 0;
    priors::Evidence evidence;
  };
  using EntriesBySource = std::map<std::string, Entry>;
  using EntriesByKey = std::map<priors::EvidenceKey, EntriesBySource>;

  // Returns the result of the change of a copy, which the preview is shown.
  template <typename Change>
  auto Shown(const priors::Preview& preview, Change change) const {
    MemoryPriorStore copy = *this;
    auto result = change(copy);
    if (result.ok()) preview.Show(copy);
    return result;
  }
  // Adds the source if there is none.
  Source& FindSource(const std::string& id);
  // Returns whether the update is one of a session and newer than what is stored of it.
  bool Applies(const priors::SourceUpdate& update) const;
  // Error: INVALID_ARGUMENT (the evidence of a source would grow beyond what a record may hold).
  absl::Status CheckSums(std::span<const priors::SourceUpdate> updates) const;
  void Apply(const priors::SourceUpdate& update);
  std::vector<std::pair<std::string, Entry>> NewestFirst(const EntriesBySource& entries) const;
  // Returns those that speak for a scene, of the entries of one of its keys.
  std::vector<std::pair<std::string, Entry>> Choose(const EntriesBySource& entries,
                                                    size_t limit) const;
  bool HasEvidence(const std::string& source_id, const std::string& project) const;
  // Whether or not it is revoked.
  bool Matches(const std::string& source_id, const priors::SourceFilter& filter) const;
  // Returns whether the record's source has imports, which it is added for.
  bool TakesImports(const priors::PriorRecord& record);
  bool ImportOne(const priors::PriorRecord& record);
  bool QuarantineOne(const priors::PriorRecord& record);
  // Puts the entry where it counts, and drops what waits and is no newer. Returns whether it is
  // newer than what counted.
  bool Take(const priors::EvidenceKey& key, const std::string& source_id, const Entry& entry);
  priors::ExportPage ExportOf(const EntriesByKey& all, const priors::SceneFilter& filter,
                              const priors::ExportPlace& after, uint32_t limit) const;
  priors::SceneEvidence Sum(const priors::SceneKey& key) const;

  std::map<std::string, Source> sources_;
  EntriesByKey evidence_;
  EntriesByKey quarantine_;
  MemoryAuditLog audit_;
  uint64_t lost_audit_row_count_ = 0;
};

}  // namespace sweepstake::storage
