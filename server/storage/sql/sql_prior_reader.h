// Reads of the prior store. The store uses them on its own connection. A ReadThread uses them on a
// second connection, which sees only committed data and does not block the store. Used by one
// thread at a time.
//
// LoadScene and List read stored sums, and LoadSources reads some of the latest sources, so that
// their cost does not depend on the number of sources.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "engine_client/decider/pooling/source_choice.h"
#include "server/sessions/prior_store.h"
#include "server/storage/read_thread.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

// Two versions of one SQL statement. ForBothTables replaces the word TABLE in `sql` by `evidence`
// in the first one, and by `quarantined_evidence` in the second one. Evidence in quarantine has no
// effect until an administrator promotes it.
using EvidenceStatements = std::array<std::string, 2>;
EvidenceStatements ForBothTables(const char* sql);

// Reads alpha, beta, window_count and bail_out_count, from column `first` on.
priors::Evidence EvidenceOf(const SqlRow& row, int first);

class SqlPriorReader : public virtual priors::PriorReader {
 public:
  // `database` must outlive this object.
  explicit SqlPriorReader(SqlDatabase& database) : database_(database) {}

  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(
      const priors::SceneKey& scene) override;
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override;
  absl::StatusOr<std::vector<priors::SceneEvidence>> List(
      const priors::SceneFilter& filter, const std::optional<priors::SceneKey>& after,
      uint32_t limit) override;
  absl::StatusOr<std::optional<priors::SceneEvidence>> LoadScene(
      const priors::SceneKey& key) override;
  absl::StatusOr<std::set<std::pair<std::string, uint32_t>>> LoadKnownArms(
      const std::string& project, const std::string& scene) override;
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override;
  absl::StatusOr<uint64_t> CountProjects() override;
  absl::StatusOr<priors::ExportPage> Export(const priors::SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return ExportAll(filter, after, limit, /*quarantined=*/false);
  }
  absl::StatusOr<priors::ExportPage> ExportQuarantined(const priors::SceneFilter& filter,
                                                       const priors::ExportPlace& after,
                                                       uint32_t limit) override {
    return ExportAll(filter, after, limit, /*quarantined=*/true);
  }
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override;
  absl::StatusOr<std::vector<priors::StoredAuditRow>> LoadAudit(uint64_t segment_id,
                                                                uint64_t first_row, uint32_t limit,
                                                                size_t max_bytes) override;
  absl::StatusOr<priors::AuditScan> ScanAudit(const priors::AuditFilter& filter,
                                              priors::AuditOrder order, uint64_t start,
                                              uint32_t limit) override;

  // Returns the scenes whose evidence was changed by transactions from the transaction id `since`
  // on. Sets `since` to the oldest transaction that is still running, so that the next call misses
  // no change. REQUIRES: the database is shared.
  absl::StatusOr<std::vector<priors::SceneKey>> LoadChangedScenes(std::string& since);

 private:
  struct ExportKey {
    priors::EvidenceKey key;
    int64_t id = 0;  // 0: there is no further key
    bool damaged = false;
  };
  // The key of an arm's evidence in a scene.
  struct ArmKey {
    size_t class_number = 0;
    int64_t scene_id = 0;
    std::string arm;
    uint32_t backend_version = 1;
    std::string measured_by;
    std::string regime;
  };
  using ArmKeys = std::map<int64_t, ArmKey>;  // by the ids of evidence_key

  // A source from which the sources of a scene are chosen.
  struct Candidate {
    int64_t source_id = 0;
    int64_t token_id = 0;
    std::string party;  // SourceOrigin::party
  };
  static bool IsLater(const Candidate& a, const Candidate& b) { return a.source_id > b.source_id; }
  static bool IsSame(const Candidate& a, const Candidate& b) { return a.source_id == b.source_id; }
  using Candidates = std::map<int64_t, std::vector<Candidate>>;  // by the id of the scene

  // Calls `add` for the latest parties of each of the newest tokens of these scenes.
  absl::Status AddPartiesOfTokens(const std::map<int64_t, uint32_t>& limits,
                                  const SqlDatabase::OnRow& add);
  // Returns about kSourcesPerPlace times the scene's limit of candidates from as
  // many parties as possible and about equally many per party. `limits` has the numbers of sources
  // to choose, by the id of the scene; for another machine class, its share of them.
  absl::StatusOr<Candidates> LoadCandidates(const std::map<int64_t, uint32_t>& limits);
  // The owners of the candidates, by the ids of scene and source.
  using Owners = absl::flat_hash_map<std::pair<int64_t, int64_t>, decision::SourceOwner>;
  using SourcesOfKeys = absl::flat_hash_map<int64_t, std::vector<int64_t>>;  // ids by key id
  // Returns the ids of scene and source of kSourcesOfOtherClasses sources of the scenes that have
  // other machine classes than the reader, for all classes and keys together. With a limit per
  // class or regime, a client could gain places by inventing these.
  static std::set<std::pair<int64_t, int64_t>> SourcesOfOtherClasses(
      const std::map<int64_t, uint32_t>& limits, const ArmKeys& keys, const SourcesOfKeys& sources,
      const Owners& owners, uint64_t seed);
  // Appends a pair of key id and source id to `chosen` for each piece of evidence to load.
  absl::Status ChooseSources(const std::map<int64_t, uint32_t>& limits, const ArmKeys& keys,
                             SqlBatch& chosen);
  absl::Status LoadArms(const std::map<int64_t, priors::SceneEvidence*>& scenes);
  // Exports the evidence in use or, if `quarantined`, the evidence in quarantine.
  absl::StatusOr<priors::ExportPage> ExportAll(const priors::SceneFilter& filter,
                                               const priors::ExportPlace& after, uint32_t limit,
                                               bool quarantined);
  // Returns the first key from `first` on that matches the filter. `first_reward_version` replaces
  // the version in `first`.
  absl::StatusOr<ExportKey> NextKey(const priors::SceneFilter& filter,
                                    const priors::EvidenceKey& first, int64_t first_reward_version,
                                    bool quarantined);
  // Appends the key's records after the place `page.next`, until the page has `limit` records.
  absl::Status AppendEvidence(const ExportKey& key, uint32_t limit, bool quarantined,
                              priors::ExportPage& page);

  SqlDatabase& database_;
};

// Returns a connection for a ReadThread. If its snapshot fails, each read returns the error.
std::unique_ptr<ReadConnection> MakeReadConnection(std::unique_ptr<SqlDatabase> database);

}  // namespace sweepstake::storage
