#include "server/storage/sqlite_prior_store.h"

#include <map>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/private_file.h"
#include "server/storage/record_limits.h"
#include "server/storage/sources/sqlite_sources.h"
#include "server/storage/sqlite_audit_log.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_reader.h"
#include "server/storage/sqlite_prior_statements.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::PriorRecord;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

using SceneCounts = std::map<std::string, priors::SceneCount>;  // by project

class SqlitePriorStore final : public priors::PriorStore {
 public:
  explicit SqlitePriorStore(SqliteDatabase database) : database_(std::move(database)) {}

  absl::Status Prepare(const priors::AuditLimits& audit_limits);
  // Sets the file of the database, which CheckPlace compares from then on.
  absl::Status SetPlace(const std::filesystem::path& path);
  absl::Status Limit(const priors::AuditLimits& audit_limits, uint64_t max_bytes);
  absl::StatusOr<uint64_t> UsedBytes() { return database_.UsedBytes(); }

  absl::Status CopyTo(const std::filesystem::path& file, const SqliteDatabase::Edit& edit);

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override;
  absl::Status CheckPlace() override { return files_.Check(); }
  uint64_t lost_audit_row_count() const override { return lost_audit_row_count_; }
  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(const SceneKey& scene) override {
    return reader_->LoadSources(scene);
  }
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override {
    return reader_->LoadSource(source_id);
  }
  absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                  const std::optional<SceneKey>& after,
                                                  uint32_t limit) override {
    return reader_->List(filter, after, limit);
  }
  absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) override {
    return reader_->LoadScene(key);
  }
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override;
  absl::StatusOr<uint64_t> CountProjects() override { return reader_->CountProjects(); }
  absl::StatusOr<priors::ExportPage> Export(const SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return reader_->Export(filter, after, limit);
  }
  absl::StatusOr<priors::ExportPage> ExportQuarantined(const SceneFilter& filter,
                                                       const priors::ExportPlace& after,
                                                       uint32_t limit) override {
    return reader_->ExportQuarantined(filter, after, limit);
  }
  absl::StatusOr<priors::ImportResult> Import(std::span<const PriorRecord> records) override;
  absl::StatusOr<priors::ImportResult> Quarantine(std::span<const PriorRecord> records,
                                                  uint64_t max_records) override;
  absl::StatusOr<priors::PromoteResult> Promote(const priors::SourceFilter& filter,
                                                const priors::Preview& preview) override;
  absl::StatusOr<priors::RevokeResult> Revoke(const priors::SourceFilter& filter,
                                              const priors::Preview& preview) override;
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override {
    return reader_->ListAudit(filter, after, limit);
  }
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override {
    return reader_->LoadAudit(segment_id, first_row, limit, max_bytes);
  }

 private:
  // Runs `body` in a transaction, which is rolled back if it fails. Returns an error instead if
  // commits would be lost (CheckPlace).
  template <typename Body>
  absl::Status InTransaction(Body body);
  // Appends the updates that were applied and have audit rows to `audited`.
  absl::Status ApplyAll(std::span<const priors::SourceUpdate> updates,
                        std::vector<const priors::SourceUpdate*>& audited);
  // Returns false if the update was applied before or its source is revoked.
  absl::StatusOr<bool> Apply(const priors::SourceUpdate& update);
  absl::Status Add(int64_t source, uint64_t sequence, const priors::KeyedEvidence& increment);
  // Runs `apply` for each record whose source takes imports, and counts those for which it returns
  // true.
  template <typename Body>
  absl::Status ForEachImported(std::span<const PriorRecord> records, priors::ImportResult& result,
                               Body apply);
  // Moves the evidence to where it counts, and inserts its key into `changed`. Returns false if the
  // evidence there is as new.
  absl::StatusOr<bool> Take(const QuarantinedRow& row, KeyIds& changed);
  // Counts the source in the scene, once. Counts the scene if this is its first source.
  absl::Status JoinScene(int64_t source, int64_t scene);
  absl::Status CountSource(int64_t scene);
  absl::StatusOr<priors::PromoteResult> PromoteAll(const priors::SourceFilter& filter);
  // Shows a preview and then returns an error, which rolls the transaction back.
  absl::Status KeepUnless(const priors::Preview& preview) {
    if (!preview) return absl::OkStatus();
    preview.Show(*reader_);
    return absl::CancelledError("a preview");
  }
  absl::StatusOr<StoredKey> FindOrAddKey(const EvidenceKey& key);
  // Returns 0 for a source that is a session of the store, or revoked.
  absl::StatusOr<int64_t> FindOrAddImported(const PriorRecord& record);
  SqliteDatabase database_;
  // Statements must be destroyed before the database, so they are declared after it.
  PriorStatements statements_;
  std::optional<SqlitePriorReader> reader_;  // present from Prepare on
  std::optional<SqliteAuditLog> audit_;      // present from Prepare on
  uint64_t lost_audit_row_count_ = 0;
  // Counts by project that were asked for, if the project has scenes. Each is read once.
  SceneCounts scene_counts_;
  SceneCounts added_counts_;  // by the running transaction
  FilesInUse files_;          // the database and its log; none in memory
};

absl::Status SqlitePriorStore::Prepare(const priors::AuditLimits& audit_limits) {
  auto statements = PriorStatements::Prepare(database_);
  if (!statements.ok()) return statements.status();
  statements_ = *std::move(statements);
  auto reader = SqlitePriorReader::Prepare(database_);
  if (!reader.ok()) return reader.status();
  reader_ = *std::move(reader);
  auto audit = SqliteAuditLog::Open(database_, audit_limits);
  if (!audit.ok()) return audit.status();
  audit_ = *std::move(audit);
  return absl::OkStatus();
}

absl::Status SqlitePriorStore::SetPlace(const std::filesystem::path& path) {
  absl::Status status = files_.Add(path);
  return status.ok() ? files_.Add(path.string() + "-wal") : status;
}

absl::Status SqlitePriorStore::CopyTo(const std::filesystem::path& file,
                                      const SqliteDatabase::Edit& edit) {
  // A read that does not end prevents the checkpoint. The copy includes the log all the same.
  database_.Execute("PRAGMA wal_checkpoint(TRUNCATE)").IgnoreError();
  return database_.CopyTo(file.string(), edit);
}

template <typename Body>
absl::Status SqlitePriorStore::InTransaction(Body body) {
  if (const absl::Status place = CheckPlace(); !place.ok())
    return absl::UnavailableError(place.message());
  added_counts_.clear();
  SqliteTransaction transaction(database_);
  absl::Status status = transaction.begun();
  if (status.ok()) status = body();
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) return status;
  for (const auto& [project, added] : added_counts_) {
    const auto known = scene_counts_.find(project);
    if (known == scene_counts_.end()) continue;
    known->second.names += added.names;
    known->second.keys += added.keys;
  }
  return status;
}

absl::StatusOr<priors::SceneCount> SqlitePriorStore::CountScenes(const std::string& project) {
  if (const auto known = scene_counts_.find(project); known != scene_counts_.end())
    return known->second;
  auto count = reader_->CountScenes(project);
  // Unknown projects are not kept, because clients may ask for any number of them.
  if (count.ok() && count->keys > 0) scene_counts_.emplace(project, *count);
  return count;
}

absl::Status SqlitePriorStore::Limit(const priors::AuditLimits& audit_limits, uint64_t max_bytes) {
  absl::Status status = database_.LimitSize(max_bytes);
  audit_->Limit(audit_limits);
  // If the disk cannot remove the rows now, a later commit does.
  InTransaction([&] { return audit_->Trim(/*unix_now_s=*/0); }).IgnoreError();
  return status;
}

absl::Status SqlitePriorStore::Commit(std::span<const priors::SourceUpdate> updates) {
  if (absl::Status status = CheckUpdates(updates); !status.ok()) return status;
  uint64_t lost = 0;
  bool ended = false;
  absl::Status status = InTransaction([&] {
    std::vector<const priors::SourceUpdate*> audited;
    absl::Status applied = ApplyAll(updates, audited);
    if (!applied.ok() || audited.empty()) return applied;
    lost = audit_->Append(database_, audited);
    ended = !database_.in_transaction();
    return absl::OkStatus();
  });
  // The log must not cost evidence. If the file has no room for the rows, SQLite ends the
  // transaction, and a second one writes the evidence alone.
  if (ended) {
    status = InTransaction([&] {
      std::vector<const priors::SourceUpdate*> audited;
      return ApplyAll(updates, audited);
    });
  }
  if (status.ok()) lost_audit_row_count_ += lost;
  return status;
}

absl::Status SqlitePriorStore::ApplyAll(std::span<const priors::SourceUpdate> updates,
                                        std::vector<const priors::SourceUpdate*>& audited) {
  for (const auto& update : updates) {
    const auto is_new = Apply(update);
    if (!is_new.ok()) return is_new.status();
    if (*is_new && !update.audit.rows.empty()) audited.push_back(&update);
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> SqlitePriorStore::Apply(const priors::SourceUpdate& update) {
  const auto& progress = update.progress;
  int64_t source = 0;
  absl::Status status = statements_.advance_source.ForEachRow(
      [&](const SqliteRow& row) { source = row.Integer(0); }, progress.source_id,
      progress.commit_sequence, progress.message_sequence, progress.explored_arm_count,
      progress.decision_count, progress.frame_count, progress.seed, update.unix_time_s,
      update.origin.build, update.origin.token_id);
  if (!status.ok()) return status;
  if (source == 0) return false;
  status = statements_.forget_quarantined.ForEachRow([](const SqliteRow&) {}, source, "");
  if (!status.ok()) return status;
  for (const auto& increment : update.increments) {
    if (status = Add(source, progress.commit_sequence, increment); !status.ok()) return status;
  }
  return true;
}

absl::Status SqlitePriorStore::Add(int64_t source, uint64_t sequence,
                                   const priors::KeyedEvidence& increment) {
  const Evidence evidence = priors::InUnits(increment.evidence);
  auto key = FindOrAddKey(increment.key);
  if (!key.ok()) return key.status();
  bool is_new = true;
  absl::Status status = statements_.advance_evidence.ForEachRow(
      [&](const SqliteRow&) { is_new = false; }, key->id, source, sequence, evidence.alpha,
      evidence.beta, evidence.window_count, evidence.bail_out_count);
  if (status.ok() && is_new) {
    status = statements_.add_evidence.Run(key->id, source, sequence, evidence.alpha, evidence.beta,
                                          evidence.window_count, evidence.bail_out_count);
    if (status.ok()) status = JoinScene(source, key->scene_id);
  }
  if (!status.ok()) return status;
  return statements_.add_to_sums.Run(key->id, evidence.alpha, evidence.beta, evidence.window_count,
                                     evidence.bail_out_count, uint32_t{is_new});
}

absl::Status SqlitePriorStore::JoinScene(int64_t source, int64_t scene) {
  bool joined = false;
  absl::Status status =
      statements_.join_scene.ForEachRow([&](const SqliteRow&) { joined = true; }, source, scene);
  return status.ok() && joined ? CountSource(scene) : status;
}

absl::Status SqlitePriorStore::CountSource(int64_t scene) {
  std::string project;
  std::string name;
  uint64_t source_count = 0;
  absl::Status status = statements_.count_source.ForEachRow(
      [&](const SqliteRow& row) {
        project = row.Text(0);
        name = row.Text(1);
        source_count = row.Unsigned(2);
      },
      scene);
  if (!status.ok() || source_count != 1) return status;
  const auto known_name = reader_->HasOtherKeys(project, name, scene);
  if (!known_name.ok()) return known_name.status();
  priors::SceneCount& added = added_counts_[project];
  ++added.keys;
  added.names += *known_name ? 0 : 1;
  return absl::OkStatus();
}

absl::StatusOr<StoredKey> SqlitePriorStore::FindOrAddKey(const EvidenceKey& key) {
  auto stored = reader_->FindKey(key);
  if (!stored.ok() || stored->id != 0) return stored;
  absl::Status status = statements_.add_scene.ForEachRow(
      [&](const SqliteRow& row) { stored->scene_id = row.Integer(0); }, key.project, key.scene,
      key.machine_class, key.reward_version);
  if (!status.ok()) return status;
  status = statements_.add_key.ForEachRow(
      [&](const SqliteRow& row) { stored->id = row.Integer(0); }, key.project, key.scene,
      key.measured_by, key.arm, key.backend_version, key.machine_class, key.reward_version,
      stored->scene_id);
  if (!status.ok()) return status;
  return stored;
}

absl::StatusOr<int64_t> SqlitePriorStore::FindOrAddImported(const PriorRecord& record) {
  int64_t source = 0;
  absl::Status status =
      statements_.import_source.ForEachRow([&](const SqliteRow& row) { source = row.Integer(0); },
                                           record.source_id, record.build, record.last_seen_unix_s);
  if (!status.ok()) return status;
  return source;
}

template <typename Body>
absl::Status SqlitePriorStore::ForEachImported(std::span<const PriorRecord> records,
                                               priors::ImportResult& result, Body apply) {
  // A file has many records of each source and key; each is looked up once.
  std::map<std::string_view, int64_t> sources;
  std::map<EvidenceKey, StoredKey> keys;
  for (const PriorRecord& record : records) {
    const auto [source, is_new_source] = sources.try_emplace(record.source_id);
    if (is_new_source) {
      const auto found = FindOrAddImported(record);
      if (!found.ok()) return found.status();
      source->second = *found;
    }
    absl::StatusOr<bool> applied = false;
    if (source->second != 0) {
      const auto [key, is_new_key] = keys.try_emplace(record.key);
      if (is_new_key) {
        const auto found = FindOrAddKey(record.key);
        if (!found.ok()) return found.status();
        key->second = *found;
      }
      applied = apply(
          {source->second, key->second, record.source_sequence, priors::InUnits(record.evidence)});
    }
    if (!applied.ok()) return applied.status();
    ++(*applied ? result.applied_count : result.unchanged_count);
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> SqlitePriorStore::Take(const QuarantinedRow& row, KeyIds& changed) {
  bool applied = false;
  const auto& [source, key, sequence, evidence] = row;
  absl::Status status = statements_.import_evidence.ForEachRow(
      [&](const SqliteRow&) { applied = true; }, key.id, source, sequence, evidence.alpha,
      evidence.beta, evidence.window_count, evidence.bail_out_count);
  if (status.ok() && applied) status = JoinScene(source, key.scene_id);
  if (status.ok()) status = statements_.drop_quarantined.Run(key.id, source, sequence);
  if (!status.ok()) return status;
  if (applied) changed.insert(key.id);
  return applied;
}

absl::StatusOr<priors::ImportResult> SqlitePriorStore::Import(
    std::span<const PriorRecord> records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  priors::ImportResult result;
  absl::Status status = InTransaction([&] {
    KeyIds changed;
    absl::Status imported = ForEachImported(
        records, result, [&](const QuarantinedRow& row) { return Take(row, changed); });
    return imported.ok() ? RecountSums(statements_, changed) : imported;
  });
  if (!status.ok()) return status;
  return result;
}

absl::StatusOr<priors::ImportResult> SqlitePriorStore::Quarantine(
    std::span<const PriorRecord> records, uint64_t max_records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  priors::ImportResult result;
  absl::Status status = InTransaction([&] {
    absl::Status imported = ForEachImported(
        records, result, [&](const QuarantinedRow& row) { return SetAside(statements_, row); });
    return imported.ok() ? CheckQuarantineSize(statements_, max_records) : imported;
  });
  if (!status.ok()) return status;
  return result;
}

// A preview is a change that is rolled back.
absl::StatusOr<priors::PromoteResult> SqlitePriorStore::Promote(const priors::SourceFilter& filter,
                                                                const priors::Preview& preview) {
  absl::StatusOr<priors::PromoteResult> result;
  absl::Status status = InTransaction([&] {
    result = PromoteAll(filter);
    return result.ok() ? KeepUnless(preview) : result.status();
  });
  return status.ok() || (result.ok() && preview) ? result : status;
}

absl::StatusOr<priors::PromoteResult> SqlitePriorStore::PromoteAll(
    const priors::SourceFilter& filter) {
  const auto sources = MatchingSources(statements_, filter, /*quarantined=*/true);
  if (!sources.ok()) return sources.status();
  priors::PromoteResult result;
  KeyIds changed;
  std::unordered_set<int64_t> scenes;
  for (const auto& [source, name] : *sources) {
    const auto rows = QuarantinedOf(statements_, source, filter.project);
    if (!rows.ok()) return rows.status();
    for (const QuarantinedRow& row : *rows) {
      if (const auto taken = Take(row, changed); !taken.ok()) return taken.status();
      result.window_count += row.evidence.window_count;
      scenes.insert(row.key.scene_id);
    }
    result.record_count += rows->size();
    result.source_count += rows->empty() ? 0 : 1;
  }
  result.scene_count = scenes.size();
  if (absl::Status status = RecountSums(statements_, changed); !status.ok()) return status;
  return result;
}

absl::StatusOr<priors::RevokeResult> SqlitePriorStore::Revoke(const priors::SourceFilter& filter,
                                                              const priors::Preview& preview) {
  scene_counts_.clear();  // fewer scenes may have evidence then
  absl::StatusOr<priors::RevokeResult> result;
  absl::Status status = InTransaction([&] {
    result = RevokeSources(statements_, filter);
    return result.ok() ? KeepUnless(preview) : result.status();
  });
  return status.ok() || (result.ok() && preview) ? result : status;
}

}  // namespace

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits, uint64_t max_bytes,
    OnSync on_sync) {
  auto database = OpenPriorDatabase(path);
  if (!database.ok()) return database.status();
  if (max_bytes > 0) {
    if (absl::Status status = database->LimitSize(max_bytes); !status.ok()) return status;
  }
  if (on_sync) {
    if (absl::Status status = database->TimeSyncs(std::move(on_sync)); !status.ok()) return status;
  }
  auto store = std::make_unique<SqlitePriorStore>(*std::move(database));
  absl::Status status = store->Prepare(audit_limits);
  if (status.ok()) status = store->SetPlace(path);
  if (!status.ok()) return status;
  return store;
}

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenMemoryPriorStore(
    const priors::AuditLimits& audit_limits) {
  auto database = OpenPriorDatabaseInMemory();
  if (!database.ok()) return database.status();
  auto store = std::make_unique<SqlitePriorStore>(*std::move(database));
  if (absl::Status status = store->Prepare(audit_limits); !status.ok()) return status;
  return store;
}

absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes) {
  return static_cast<SqlitePriorStore&>(store).Limit(audit_limits, max_bytes);
}

absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store) {
  return static_cast<SqlitePriorStore&>(store).UsedBytes();
}

absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit) {
  return static_cast<SqlitePriorStore&>(store).CopyTo(file, edit);
}

}  // namespace sweepstake::storage
