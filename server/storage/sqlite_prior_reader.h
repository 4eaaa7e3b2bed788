// The reads of the prior store on SQLite, for the store itself and for a second connection, which
// sees what the store has committed and does not block it. Used by one thread at a time.
//
// LoadScene and List read stored sums, and LoadSources reads some of the latest sources, so that
// their cost does not depend on the number of sources.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"
#include "server/storage/sqlite_audit_log.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_statements.h"

namespace sweepstake::storage {

// The row of a key.
struct StoredKey {
  int64_t id = 0;
  int64_t scene_id = 0;
};

// The database must outlive it.
class SqlitePriorReader final : public priors::PriorReader {
 public:
  static absl::StatusOr<SqlitePriorReader> Prepare(SqliteDatabase& database);

  // Returns whether the project's scene of that name has evidence in another row than `scene_id`,
  // such as of another machine class.
  absl::StatusOr<bool> HasOtherKeys(const std::string& project, const std::string& scene,
                                    int64_t scene_id);
  // Returns a key with id 0 if it is missing.
  absl::StatusOr<StoredKey> FindKey(const priors::EvidenceKey& key);

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
                                                              uint32_t limit) override {
    return audit_.List(filter, after, limit);
  }
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override {
    return audit_.Load(segment_id, first_row, limit, max_bytes);
  }

 private:
  struct ExportKey {
    priors::EvidenceKey key;
    int64_t id = 0;  // 0: missing
    bool damaged = false;
  };

  SqlitePriorReader(PriorReadStatements statements, SqliteAuditReader audit)
      : statements_(std::move(statements)), audit_(std::move(audit)) {}

  absl::Status LoadArms(int64_t scene_id, priors::SceneEvidence& scene);
  using SourceNumbers = std::vector<int64_t>;
  // Returns the sources to use for the key. Most keys of a scene have the same latest sources;
  // `known` holds the choice for the other keys.
  absl::StatusOr<SourceNumbers> ChooseSources(int64_t key_id, uint32_t limit,
                                              std::map<SourceNumbers, SourceNumbers>& known);
  // Appends the evidence of up to `limit` sources about each key of the scene.
  absl::Status AppendSources(int64_t scene_id, const priors::SceneKey& scene, uint32_t limit,
                             std::vector<priors::SceneSource>& sources);
  // Exports the evidence that counts, or that in quarantine.
  absl::StatusOr<priors::ExportPage> ExportAll(const priors::SceneFilter& filter,
                                               const priors::ExportPlace& after, uint32_t limit,
                                               bool quarantined);
  // Returns the first matching key from `first` on, but with the given reward version.
  absl::StatusOr<ExportKey> NextKey(const priors::SceneFilter& filter,
                                    const priors::EvidenceKey& first, int64_t first_reward_version,
                                    bool quarantined);
  // Appends the key's records behind the page's place until the page has `limit` of them.
  absl::Status AppendEvidence(const ExportKey& key, uint32_t limit, bool quarantined,
                              priors::ExportPage& page);

  PriorReadStatements statements_;
  SqliteAuditReader audit_;
};

// Opens a connection that only reads, beside the store of that file. It must end before the store,
// and be opened again with it. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<ReadConnection>> OpenSqliteReadConnection(
    const std::filesystem::path& path);

}  // namespace sweepstake::storage
