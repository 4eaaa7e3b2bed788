#include "server/storage/sqlite_prior_store.h"

#include <unordered_set>
#include <utility>

#include "server/storage/record_limits.h"
#include "server/storage/sqlite_audit_log.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::PriorRecord;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

// Every statement of the store, prepared once.
struct Statements {
  SqliteStatement advance_source, find_key, add_key, add_evidence, key_evidence, load_source,
      source_evidence, list_scenes, scene_arms, scene_sources, export_records, touch_source,
      import_evidence, revoke_source, delete_evidence;
};

struct StatementText {
  SqliteStatement Statements::*statement;
  const char* sql;
};

// An upsert returns a row exactly if it changed something; this is how repeated updates and revoked
// sources are recognised. Counts are added by total(), because sum() fails on an overflow, so that
// two imported records could make a scene unreadable.
constexpr StatementText kStatements[] = {
    {&Statements::advance_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed)
        VALUES (?1, 1, 0, ?2, ?3, ?4, ?5, ?6, ?7)
        ON CONFLICT (name) DO UPDATE
          SET is_session = 1, commit_sequence = ?2, message_sequence = ?3, explored_arm_count = ?4,
              decision_count = ?5, frame_count = ?6, seed = ?7
          WHERE revoked = 0 AND ?2 > commit_sequence
        RETURNING id)sql"},
    {&Statements::find_key, R"sql(
        SELECT id FROM evidence_key
        WHERE project = ?1 AND scene = ?2 AND context_bucket = ?3 AND arm = ?4
          AND backend_version = ?5 AND machine_class = ?6 AND reward_version = ?7)sql"},
    {&Statements::add_key, R"sql(
        INSERT INTO evidence_key (project, scene, context_bucket, arm, backend_version,
                                  machine_class, reward_version)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)
        RETURNING id)sql"},
    {&Statements::add_evidence, R"sql(
        INSERT INTO evidence (key_id, source_id, sequence, alpha, beta, window_count,
                              bail_out_count)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)
        ON CONFLICT DO UPDATE
          SET sequence = ?3, alpha = alpha + ?4, beta = beta + ?5,
              window_count = window_count + ?6, bail_out_count = bail_out_count + ?7)sql"},
    {&Statements::key_evidence, R"sql(
        SELECT source_id, alpha, beta, window_count, bail_out_count
        FROM evidence WHERE key_id = ?1)sql"},
    {&Statements::load_source, R"sql(
        SELECT id, commit_sequence, message_sequence, explored_arm_count, decision_count,
               frame_count, seed
        FROM source WHERE name = ?1 AND is_session = 1 AND revoked = 0)sql"},
    {&Statements::source_evidence, R"sql(
        SELECT project, scene, context_bucket, arm, backend_version, machine_class, reward_version,
               alpha, beta, window_count, bail_out_count
        FROM evidence JOIN evidence_key k ON k.id = key_id
        WHERE source_id = ?1
        ORDER BY project, scene, context_bucket, arm, backend_version, machine_class,
                 reward_version)sql"},
    {&Statements::list_scenes, R"sql(
        SELECT DISTINCT project, scene, machine_class, reward_version FROM evidence_key
        WHERE (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
          AND (project, scene, machine_class, reward_version) > (?3, ?4, ?5, ?6)
          AND EXISTS (SELECT 1 FROM evidence WHERE key_id = evidence_key.id)
        ORDER BY 1, 2, 3, 4 LIMIT ?7)sql"},
    {&Statements::scene_arms, R"sql(
        SELECT arm, backend_version, sum(alpha), sum(beta), CAST(total(window_count) AS INTEGER),
               CAST(total(bail_out_count) AS INTEGER)
        FROM evidence_key k JOIN evidence ON k.id = key_id
        WHERE project = ?1 AND scene = ?2 AND machine_class = ?3 AND reward_version = ?4
        GROUP BY arm, backend_version ORDER BY arm, backend_version)sql"},
    {&Statements::scene_sources, R"sql(
        SELECT count(DISTINCT source_id)
        FROM evidence_key k JOIN evidence ON k.id = key_id
        WHERE project = ?1 AND scene = ?2 AND machine_class = ?3 AND reward_version = ?4)sql"},
    {&Statements::export_records, R"sql(
        SELECT project, scene, context_bucket, arm, backend_version, machine_class, reward_version,
               alpha, beta, window_count, bail_out_count, name, sequence
        FROM evidence_key k JOIN evidence ON k.id = key_id JOIN source s ON s.id = source_id
        WHERE (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
          AND (project, scene, context_bucket, arm, backend_version, machine_class, reward_version,
               name) > (?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)
        ORDER BY 1, 2, 3, 4, 5, 6, 7, 12 LIMIT ?11)sql"},
    {&Statements::touch_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed)
        VALUES (?1, 0, 0, ?2, 0, 0, 0, 0, 0)
        ON CONFLICT (name) DO UPDATE
          SET commit_sequence = max(commit_sequence, ?2) WHERE revoked = 0
        RETURNING id)sql"},
    {&Statements::import_evidence, R"sql(
        INSERT INTO evidence (key_id, source_id, sequence, alpha, beta, window_count,
                              bail_out_count)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)
        ON CONFLICT DO UPDATE
          SET sequence = ?3, alpha = ?4, beta = ?5, window_count = ?6, bail_out_count = ?7
          WHERE ?3 > sequence
        RETURNING 1)sql"},
    {&Statements::revoke_source, R"sql(
        INSERT INTO source (name, is_session, revoked, commit_sequence, message_sequence,
                            explored_arm_count, decision_count, frame_count, seed)
        VALUES (?1, 0, 1, 0, 0, 0, 0, 0, 0)
        ON CONFLICT (name) DO UPDATE SET revoked = 1
        RETURNING id)sql"},
    {&Statements::delete_evidence, "DELETE FROM evidence WHERE source_id = ?1 RETURNING 1"},
};

EvidenceKey KeyOf(const SqliteRow& row) {
  return {.project = row.Text(0),
          .scene = row.Text(1),
          .context_bucket = row.Text(2),
          .arm = row.Text(3),
          .backend_version = static_cast<uint32_t>(row.Integer(4)),
          .machine_class = row.Text(5),
          .reward_version = static_cast<uint32_t>(row.Integer(6))};
}

Evidence EvidenceOf(const SqliteRow& row, int first) {
  return {.alpha = row.Real(first),
          .beta = row.Real(first + 1),
          .window_count = row.Unsigned(first + 2),
          .bail_out_count = row.Unsigned(first + 3)};
}

class SqlitePriorStore final : public priors::PriorStore {
 public:
  explicit SqlitePriorStore(SqliteDatabase database) : database_(std::move(database)) {}

  absl::Status Prepare(const priors::AuditLimits& audit_limits);

  absl::Status Commit(std::span<const priors::SourceUpdate> updates) override;
  absl::StatusOr<priors::PriorSums> LoadPriors(std::span<const EvidenceKey> keys) override;
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override;
  absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                  const std::optional<SceneKey>& after,
                                                  uint32_t limit) override;
  absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) override;
  absl::StatusOr<std::vector<PriorRecord>> Export(const SceneFilter& filter,
                                                  const std::optional<PriorRecord>& after,
                                                  uint32_t limit) override;
  absl::StatusOr<priors::ImportResult> Import(std::span<const PriorRecord> records) override;
  absl::StatusOr<uint64_t> Revoke(const std::string& source_id) override;
  absl::StatusOr<std::vector<priors::AuditSegment>> ListAudit(const priors::AuditFilter& filter,
                                                              uint64_t after,
                                                              uint32_t limit) override {
    return audit_->List(filter, after, limit);
  }
  absl::StatusOr<std::vector<std::string>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                     uint32_t limit, size_t max_bytes) override {
    return audit_->Load(segment_id, first_row, limit, max_bytes);
  }

 private:
  // Runs `body` in a transaction, which is rolled back if it fails.
  template <typename Body>
  absl::Status InTransaction(Body body);
  // Returns false if the update was applied before or its source is revoked.
  absl::StatusOr<bool> Apply(const priors::SourceUpdate& update);
  absl::Status ImportOne(const PriorRecord& record, priors::ImportResult& result);
  // Returns 0 if there is no such key.
  absl::StatusOr<int64_t> FindKey(const EvidenceKey& key);
  absl::StatusOr<int64_t> FindOrAddKey(const EvidenceKey& key);
  absl::Status LoadArms(SceneEvidence& scene);

  SqliteDatabase database_;
  // Statements must be destroyed before the database, so they stand after it.
  Statements statements_;
  std::optional<SqliteAuditLog> audit_;  // present from Prepare on
};

absl::Status SqlitePriorStore::Prepare(const priors::AuditLimits& audit_limits) {
  for (const StatementText& text : kStatements) {
    auto statement = database_.Prepare(text.sql);
    if (!statement.ok()) return statement.status();
    statements_.*text.statement = *std::move(statement);
  }
  auto audit = SqliteAuditLog::Open(database_, audit_limits);
  if (!audit.ok()) return audit.status();
  audit_ = *std::move(audit);
  return absl::OkStatus();
}

template <typename Body>
absl::Status SqlitePriorStore::InTransaction(Body body) {
  SqliteTransaction transaction(database_);
  absl::Status status = transaction.begun();
  if (status.ok()) status = body();
  if (status.ok()) status = transaction.Commit();
  return status;
}

absl::Status SqlitePriorStore::Commit(std::span<const priors::SourceUpdate> updates) {
  if (absl::Status status = CheckUpdates(updates); !status.ok()) return status;
  bool audited = false;
  absl::Status status = InTransaction([&] {
    std::vector<const priors::SourceUpdate*> applied;
    for (const auto& update : updates) {
      const auto is_new = Apply(update);
      if (!is_new.ok()) return is_new.status();
      if (*is_new && !update.audit.rows.empty()) applied.push_back(&update);
    }
    // The log must not cost evidence: if its rows cannot be written, the commit goes on without.
    audited = !applied.empty() && audit_->Append(database_, applied).ok();
    return absl::OkStatus();
  });
  if (status.ok() && audited) audit_->Committed();
  return status;
}

absl::StatusOr<bool> SqlitePriorStore::Apply(const priors::SourceUpdate& update) {
  const auto& progress = update.progress;
  int64_t source = 0;
  absl::Status status = statements_.advance_source.ForEachRow(
      [&](const SqliteRow& row) { source = row.Integer(0); }, progress.source_id,
      progress.commit_sequence, progress.message_sequence, progress.explored_arm_count,
      progress.decision_count, progress.frame_count, progress.seed);
  if (!status.ok()) return status;
  if (source == 0) return false;
  for (const auto& [key, evidence] : update.increments) {
    auto key_id = FindOrAddKey(key);
    if (!key_id.ok()) return key_id.status();
    status =
        statements_.add_evidence.Run(*key_id, source, progress.commit_sequence, evidence.alpha,
                                     evidence.beta, evidence.window_count, evidence.bail_out_count);
    if (!status.ok()) return status;
  }
  return true;
}

absl::StatusOr<int64_t> SqlitePriorStore::FindKey(const EvidenceKey& key) {
  int64_t id = 0;
  absl::Status status = statements_.find_key.ForEachRow(
      [&](const SqliteRow& row) { id = row.Integer(0); }, key.project, key.scene,
      key.context_bucket, key.arm, key.backend_version, key.machine_class, key.reward_version);
  if (!status.ok()) return status;
  return id;
}

absl::StatusOr<int64_t> SqlitePriorStore::FindOrAddKey(const EvidenceKey& key) {
  auto id = FindKey(key);
  if (!id.ok() || *id != 0) return id;
  absl::Status status = statements_.add_key.ForEachRow(
      [&](const SqliteRow& row) { *id = row.Integer(0); }, key.project, key.scene,
      key.context_bucket, key.arm, key.backend_version, key.machine_class, key.reward_version);
  if (!status.ok()) return status;
  return id;
}

absl::StatusOr<priors::PriorSums> SqlitePriorStore::LoadPriors(std::span<const EvidenceKey> keys) {
  priors::PriorSums result;
  std::unordered_set<int64_t> sources;
  for (const EvidenceKey& key : keys) {
    auto id = FindKey(key);
    if (!id.ok()) return id.status();
    priors::PriorSum& sum = result.sums.emplace_back();
    absl::Status status = statements_.key_evidence.ForEachRow(
        [&](const SqliteRow& row) {
          sum.evidence += EvidenceOf(row, 1);
          ++sum.source_count;
          sources.insert(row.Integer(0));
        },
        *id);
    if (!status.ok()) return status;
  }
  result.source_count = sources.size();
  return result;
}

absl::StatusOr<std::optional<priors::SourceState>> SqlitePriorStore::LoadSource(
    const std::string& source_id) {
  priors::SourceState state;
  int64_t id = 0;
  absl::Status status = statements_.load_source.ForEachRow(
      [&](const SqliteRow& row) {
        id = row.Integer(0);
        state.progress = {.source_id = source_id,
                          .commit_sequence = row.Unsigned(1),
                          .message_sequence = row.Unsigned(2),
                          .explored_arm_count = static_cast<uint32_t>(row.Integer(3)),
                          .decision_count = row.Unsigned(4),
                          .frame_count = row.Unsigned(5),
                          .seed = row.Unsigned(6)};
      },
      source_id);
  if (!status.ok()) return status;
  if (id == 0) return std::nullopt;
  status = statements_.source_evidence.ForEachRow(
      [&](const SqliteRow& row) {
        state.evidence.push_back({KeyOf(row), EvidenceOf(row, 7)});
      },
      id);
  if (!status.ok()) return status;
  const auto segment = audit_->LastSegment(source_id);
  if (!segment.ok()) return segment.status();
  state.audit_segment = *segment;
  return state;
}

absl::Status SqlitePriorStore::LoadArms(SceneEvidence& scene) {
  const SceneKey& key = scene.key;
  absl::Status status = statements_.scene_arms.ForEachRow(
      [&](const SqliteRow& row) {
        scene.arms.push_back(
            {row.Text(0), static_cast<uint32_t>(row.Integer(1)), EvidenceOf(row, 2)});
      },
      key.project, key.scene, key.machine_class, key.reward_version);
  if (!status.ok()) return status;
  return statements_.scene_sources.ForEachRow(
      [&](const SqliteRow& row) { scene.source_count = row.Unsigned(0); }, key.project, key.scene,
      key.machine_class, key.reward_version);
}

absl::StatusOr<std::vector<SceneEvidence>> SqlitePriorStore::List(
    const SceneFilter& filter, const std::optional<SceneKey>& after, uint32_t limit) {
  // An empty project sorts before all, since projects are never empty.
  const SceneKey start = after.value_or(SceneKey{});
  std::vector<SceneEvidence> scenes;
  absl::Status status = statements_.list_scenes.ForEachRow(
      [&](const SqliteRow& row) {
        scenes.push_back(
            {.key = {row.Text(0), row.Text(1), row.Text(2), static_cast<uint32_t>(row.Integer(3))},
             .arms = {},
             .source_count = 0});
      },
      filter.project, filter.scene, start.project, start.scene, start.machine_class,
      start.reward_version, limit);
  if (!status.ok()) return status;
  for (SceneEvidence& scene : scenes) {
    if (status = LoadArms(scene); !status.ok()) return status;
  }
  return scenes;
}

absl::StatusOr<std::optional<SceneEvidence>> SqlitePriorStore::LoadScene(const SceneKey& key) {
  SceneEvidence scene{.key = key, .arms = {}, .source_count = 0};
  if (absl::Status status = LoadArms(scene); !status.ok()) return status;
  if (scene.arms.empty()) return std::nullopt;
  return scene;
}

absl::StatusOr<std::vector<PriorRecord>> SqlitePriorStore::Export(
    const SceneFilter& filter, const std::optional<PriorRecord>& after, uint32_t limit) {
  const PriorRecord start = after.value_or(PriorRecord{});
  const EvidenceKey& key = start.key;
  std::vector<PriorRecord> records;
  absl::Status status = statements_.export_records.ForEachRow(
      [&](const SqliteRow& row) {
        records.push_back({KeyOf(row), row.Text(11), row.Unsigned(12), EvidenceOf(row, 7)});
      },
      filter.project, filter.scene, key.project, key.scene, key.context_bucket, key.arm,
      key.backend_version, key.machine_class, key.reward_version, start.source_id, limit);
  if (!status.ok()) return status;
  return records;
}

absl::Status SqlitePriorStore::ImportOne(const PriorRecord& record, priors::ImportResult& result) {
  int64_t source = 0;
  absl::Status status =
      statements_.touch_source.ForEachRow([&](const SqliteRow& row) { source = row.Integer(0); },
                                          record.source_id, record.source_sequence);
  if (!status.ok()) return status;
  bool applied = false;
  if (source != 0) {
    auto key_id = FindOrAddKey(record.key);
    if (!key_id.ok()) return key_id.status();
    const Evidence& evidence = record.evidence;
    status = statements_.import_evidence.ForEachRow(
        [&](const SqliteRow&) { applied = true; }, *key_id, source, record.source_sequence,
        evidence.alpha, evidence.beta, evidence.window_count, evidence.bail_out_count);
  }
  ++(applied ? result.applied_count : result.unchanged_count);
  return status;
}

absl::StatusOr<priors::ImportResult> SqlitePriorStore::Import(
    std::span<const PriorRecord> records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  priors::ImportResult result;
  absl::Status status = InTransaction([&] {
    for (const PriorRecord& record : records) {
      if (absl::Status one = ImportOne(record, result); !one.ok()) return one;
    }
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return result;
}

absl::StatusOr<uint64_t> SqlitePriorStore::Revoke(const std::string& source_id) {
  uint64_t removed = 0;
  absl::Status status = InTransaction([&] {
    int64_t source = 0;
    absl::Status found = statements_.revoke_source.ForEachRow(
        [&](const SqliteRow& row) { source = row.Integer(0); }, source_id);
    if (!found.ok()) return found;
    return statements_.delete_evidence.ForEachRow([&](const SqliteRow&) { ++removed; }, source);
  });
  if (!status.ok()) return status;
  return removed;
}

}  // namespace

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits) {
  auto database = OpenPriorDatabase(path);
  if (!database.ok()) return database.status();
  auto store = std::make_unique<SqlitePriorStore>(*std::move(database));
  if (absl::Status status = store->Prepare(audit_limits); !status.ok()) return status;
  return store;
}

}  // namespace sweepstake::storage
