// Reads a prior store in PostgreSQL over one connection. A call sees one state of the store, and so
// do several calls in the scope of one PostgresSnapshot.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/read_thread.h"

namespace sweepstake::storage {

class PostgresReader : public priors::PriorReader {
 public:
  // `connection` must outlive it. Each call connects if necessary.
  explicit PostgresReader(PostgresConnection& connection) : connection_(connection) {}

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
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override;
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override;

  // Returns the scenes whose evidence was changed by transactions from `since` on. Sets `since` to
  // the first transaction that was not finished yet, so that no change is left out.
  absl::StatusOr<std::vector<priors::SceneKey>> LoadChangedScenes(std::string& since);

 private:
  struct ExportKey {
    priors::EvidenceKey key;
    int64_t id = 0;  // 0: missing
  };

  // Appends the evidence of up to `limit` sources about each arm of a scene, ordered by source.
  absl::Status AppendSources(int64_t scene_id, const priors::SceneKey& scene, uint32_t limit,
                             std::vector<priors::SceneSource>& sources);
  absl::Status LoadArms(const std::map<int64_t, priors::SceneEvidence*>& scenes);
  absl::StatusOr<priors::ExportPage> ExportAll(const priors::SceneFilter& filter,
                                               const priors::ExportPlace& after, uint32_t limit,
                                               bool quarantined);
  // Returns the first key from `first` on that has evidence, or evidence in quarantine.
  absl::StatusOr<ExportKey> NextKey(const priors::SceneFilter& filter,
                                    const priors::EvidenceKey& first, int64_t first_reward_version,
                                    bool quarantined);
  // Appends the key's records until the page has `limit` of them.
  absl::Status AppendEvidence(const ExportKey& key, uint32_t limit, bool quarantined,
                              priors::ExportPage& page);

  PostgresConnection& connection_;
};

// Opens a connection for a ReadThread. If the server does not answer, reads return UNAVAILABLE.
std::unique_ptr<ReadConnection> OpenPostgresReadConnection(const std::string& url);

}  // namespace sweepstake::storage
