#include "server/storage/sql/sql_prior_store.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/sessions/common/unix_time.h"
#include "server/storage/record_limits.h"
#include "server/storage/sql/sql_prior_statements.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::ImportResult;
using priors::PriorRecord;
using priors::SceneKey;
using priors::SourceUpdate;

constexpr const char* kFirstTransaction = "0";
constexpr int kAttempts = 20;  // limit for a transaction that conflicts with other daemons
constexpr size_t kMaxKnownKeys = 100'000;  // cached keys, of about 200 bytes each

// Returns the pairs of key id and source id of the rows.
template <typename Rows>
std::set<std::pair<int64_t, int64_t>> PlacesOf(const Rows& rows) {
  std::set<std::pair<int64_t, int64_t>> places;
  for (const auto& [place, row] : rows) places.insert(place);
  return places;
}

// Adds `evidence` to `sum`. Counts stop at kMaxCount.
void AddTo(Evidence& sum, const Evidence& evidence) {
  sum += evidence;
  sum.window_count = std::min(sum.window_count, kMaxCount);
  sum.bail_out_count = std::min(sum.bail_out_count, kMaxCount);
}

void AddRow(SqlBatch& batch, const std::pair<int64_t, int64_t>& place, uint64_t sequence,
            const Evidence& evidence) {
  batch.Add(place.first, place.second, sequence, SqlAmount{evidence.alpha},
            SqlAmount{evidence.beta}, evidence.window_count, evidence.bail_out_count);
}

}  // namespace

SqlPriorStore::SqlPriorStore(std::unique_ptr<SqlDatabase> database,
                             const priors::AuditLimits& audit_limits)
    : SqlPriorReader(*database), database_(std::move(database)), audit_(*database_, audit_limits) {
  // Trims the audit log: the limits may be lower than in the last run, and a file at its maximum
  // size needs the space.
  Limit(audit_limits);
}

void SqlPriorStore::Limit(const priors::AuditLimits& audit_limits) {
  audit_.Limit(audit_limits);
  InTransaction([&] { return audit_.Trim(/*unix_now_s=*/0); }).IgnoreError();
}

void SqlPriorStore::CheckIncarnation() {
  if (incarnation_ == database_->incarnation()) return;
  incarnation_ = database_->incarnation();
  known_keys_.clear();  // a server restored from a backup may lack some of these keys
  changes_since_ = kFirstTransaction;  // the server may have lower transaction ids
}

template <typename Body>
absl::Status SqlPriorStore::TryTransaction(Body& body) {
  absl::Status status = storage::InTransaction(*database_, [&] {
    CheckIncarnation();
    new_keys_.clear();
    added_counts_.clear();
    added_commits_ = 0;
    return body();
  });
  if (!status.ok()) return status;
  if (known_keys_.size() + new_keys_.size() > kMaxKnownKeys) known_keys_.clear();
  for (const auto& [key, stored] : new_keys_) known_keys_[key] = stored;
  if (commit_count_) *commit_count_ += added_commits_;
  for (const auto& [project, added] : added_counts_) {
    scene_counts_[project].names += added.names;
    scene_counts_[project].keys += added.keys;
  }
  return status;
}

template <typename Body>
absl::Status SqlPriorStore::InTransaction(Body body) {
  absl::Status status;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    status = TryTransaction(body);
    if (!absl::IsAborted(status)) return status;
  }
  return absl::UnavailableError(status.message());
}

template <typename Result, typename Change>
absl::StatusOr<Result> SqlPriorStore::ChangeUnless(const priors::Preview& preview, Change change) {
  absl::StatusOr<Result> result;
  absl::Status status = InTransaction([&] {
    database_->StopWhen(stop_changes_);
    result = change();
    if (result.ok() && preview) preview.Show(*this);
    database_->StopWhen(nullptr);
    return result.ok() && preview ? absl::CancelledError("a preview") : result.status();
  });
  return status.ok() || (result.ok() && absl::IsCancelled(status)) ? result : status;
}

absl::StatusOr<std::vector<SceneKey>> SqlPriorStore::TakeChangedScenes() {
  if (!database_->shared()) return std::vector<SceneKey>();
  const SqlSnapshot snapshot(*database_);
  if (!snapshot.status().ok()) return snapshot.status();
  CheckIncarnation();
  return LoadChangedScenes(changes_since_);
}

absl::StatusOr<priors::SceneCount> SqlPriorStore::CountScenes(const std::string& project) {
  if (const auto known = scene_counts_.find(project); known != scene_counts_.end())
    return known->second;
  auto count = SqlPriorReader::CountScenes(project);
  // Projects without scenes are not cached, because clients can send any number of names.
  if (count.ok() && count->keys > 0 && !database_->shared()) scene_counts_[project] = *count;
  return count;
}

absl::StatusOr<uint64_t> SqlPriorStore::CountCommits() {
  if (commit_count_) return *commit_count_;
  const auto count = database_->ReadInteger(kCountCommits);
  if (!count.ok()) return count.status();
  commit_count_ = static_cast<uint64_t>(*count);
  return *commit_count_;
}

absl::Status SqlPriorStore::Commit(std::span<const SourceUpdate> updates) {
  if (absl::Status status = CheckUpdates(updates); !status.ok()) return status;
  priors::StoreLosses lost;
  bool ended = false;
  absl::Status status = InTransaction([&] {
    lost = {};
    const absl::Status committed = CommitAll(updates, /*with_audit=*/true, lost);
    ended = committed.ok() && !database_->in_transaction();
    return committed;
  });
  // Audit rows must not prevent evidence from being stored. If the file has no room for the audit
  // rows, SQLite ends the transaction. A second transaction then writes the evidence alone.
  if (ended && !database_->shared())
    status = InTransaction([&] { return CommitAll(updates, /*with_audit=*/false, lost); });
  if (status.ok()) {
    losses_.audit_row_count += lost.audit_row_count;
    losses_.player_increment_count += lost.player_increment_count;
    if (!lost.example.empty()) losses_.example = lost.example;
  }
  return status;
}

absl::Status SqlPriorStore::CommitAll(std::span<const SourceUpdate> updates, bool with_audit,
                                      priors::StoreLosses& lost) {
  lost.player_increment_count = 0;
  std::vector<NewSource> names;
  for (const SourceUpdate& update : updates) names.push_back({update.progress.source_id});
  auto sources = LockOrAdd(names);
  if (!sources.ok()) return sources.status();
  struct Addition {
    const Source* source;
    const SourceUpdate* update;
    const priors::KeyedEvidence* increment;
    std::optional<EvidenceKey> replaced_key;  // in place of that of the increment

    const EvidenceKey& key() const { return replaced_key ? *replaced_key : increment->key; }
  };
  std::vector<Addition> additions;
  std::vector<const EvidenceKey*> keys;   // those of `additions`, then `known`
  std::vector<const EvidenceKey*> known;  // keys whose arms become known
  PlayerAdditions of_players;
  std::vector<const SourceUpdate*> audited;
  // Sources whose first commit this is; their imported records in quarantine are removed.
  Ids begun;
  for (const SourceUpdate& update : updates) {
    Source& source = sources->at(update.progress.source_id);
    if (source.revoked) {  // its evidence does not count, but its decisions are logged
      if (!update.audit.rows.empty()) audited.push_back(&update);
      continue;
    }
    const uint64_t before = source.commit_sequence;
    const auto is_new = Advance(source, update);
    if (!is_new.ok()) return is_new.status();
    if (!*is_new) continue;
    added_commits_ += source.commit_sequence - before;
    for (const auto& increment : update.increments) {
      additions.push_back({&source, &update, &increment, std::nullopt});
      const EvidenceKey& key = increment.key;
      if (!update.is_of_player || known_keys_.contains(key)) continue;
      const auto may_add = MayAdd(update, key, of_players);
      if (!may_add.ok()) return may_add.status();
      const auto has_regime = *may_add ? MayAddRegime(key, of_players) : false;
      if (!has_regime.ok()) return has_regime.status();
      if (*has_regime) continue;
      ++lost.player_increment_count;
      lost.example =
          absl::StrCat("scene ", key.scene, " of project ", key.project, ", from ",
                       update.origin.party().empty() ? "a token" : update.origin.party());
      if (!*may_add) {
        additions.pop_back();
      } else {
        additions.back().replaced_key.emplace(key).regime.clear();
      }
    }
    for (const EvidenceKey& key : update.known) known.push_back(&key);
    if (!update.audit.rows.empty()) audited.push_back(&update);
    if (!source.is_session) begun.insert(source.id);
  }
  for (const Addition& addition : additions) keys.push_back(&addition.key());
  keys.insert(keys.end(), known.begin(), known.end());
  const auto stored_keys = FindOrAddKeys(keys, of_players.adders);
  if (!stored_keys.ok()) return stored_keys.status();
  Rows rows;
  auto stored = stored_keys->begin();
  for (const Addition& addition : additions) {
    Row& row = rows[{stored->id, addition.source->id}];
    row.scene = (stored++)->scene;
    row.sequence = addition.update->progress.commit_sequence;
    AddTo(row.evidence, priors::InUnits(addition.increment->evidence));
  }
  absl::Status status = UpdateSources(*sources);
  if (status.ok()) status = AddEvidence(rows);
  if (status.ok()) status = MakeKnown(known, std::span(*stored_keys).subspan(additions.size()));
  if (status.ok()) status = TakeOut(begun, "", /*with_damaged=*/true).status();
  if (!status.ok() || audited.empty() || !with_audit) return status;
  const auto lost_rows = audit_.Append(audited);
  lost.audit_row_count = lost_rows.value_or(0);
  return lost_rows.status();
}

absl::StatusOr<bool> SqlPriorStore::MayAdd(const SourceUpdate& update, const EvidenceKey& key,
                                           PlayerAdditions& additions) {
  const priors::SourceOrigin::Owner owner = update.origin.owner();
  const SceneKey scene{key.project, key.scene, key.machine_class, key.reward_version};
  auto& [adders, refused, regimes] = additions;
  if (refused.contains({scene, owner})) return false;
  if (const auto adder = adders.find(scene); adder != adders.end()) return true;
  uint64_t added_count = 0;
  bool is_stored = false;
  absl::Status status = database_->ForEachRow(
      kCountAdded,
      [&](const SqlRow& row) {
        added_count = row.Unsigned(0);
        is_stored = row.Integer(1) != 0;
      },
      scene.project, scene.scene, scene.machine_class, scene.reward_version, owner.first,
      owner.second);
  if (!status.ok()) return status;
  if (is_stored) return true;
  for (const auto& [other, adder] : adders) {
    if (adder == owner && other.project == scene.project && other.scene == scene.scene)
      ++added_count;
  }
  if (added_count >= priors::kMaxScenesOfParty) {
    refused.emplace(scene, owner);
    return false;
  }
  adders[scene] = owner;
  return true;
}

// A scene has the same regimes on all machine classes: a session begins with those of several.
absl::StatusOr<bool> SqlPriorStore::MayAddRegime(const EvidenceKey& key,
                                                 PlayerAdditions& additions) {
  if (key.regime.empty()) return true;
  const auto [found, is_new] =
      additions.regimes.try_emplace({key.project, key.scene, "", key.reward_version});
  std::set<std::string>& of_scene = found->second;
  if (is_new) {
    absl::Status status = database_->ForEachRow(
        kRegimes, [&](const SqlRow& row) { of_scene.insert(row.Text(0)); }, key.project, key.scene,
        key.reward_version);
    if (!status.ok()) return status;
  }
  if (of_scene.size() < priors::kMaxRegimesOfPlayers) of_scene.insert(key.regime);
  return of_scene.contains(key.regime);
}

absl::StatusOr<bool> SqlPriorStore::Advance(Source& source, const SourceUpdate& update) const {
  const auto& [writer, resumed_sequence] = update.writer;
  if (database_->shared() && writer != source.writer && writer != 0 &&
      resumed_sequence != source.commit_sequence) {
    return absl::FailedPreconditionError(
        absl::StrCat("another daemon has continued the session ", update.progress.source_id));
  }
  if (update.progress.commit_sequence <= source.commit_sequence) return false;
  source.commit_sequence = update.progress.commit_sequence;
  source.writer = writer;
  if (source.first == nullptr) source.first = &update;
  source.last = &update;
  return true;
}

absl::Status SqlPriorStore::AddEvidence(const Rows& rows) {
  struct Change {
    Evidence evidence;
    int64_t source_count = 0;
  };
  static const auto& put = *new EvidenceStatements(ForBothTables(kPutRows));
  if (rows.empty()) return absl::OkStatus();
  SqlBatch batch;
  std::map<int64_t, Change> sums;
  for (const auto& [place, row] : rows) {
    AddRow(batch, place, row.sequence, row.evidence);
    AddTo(sums[place.first].evidence, row.evidence);
  }
  const auto changed = database_->Change(kAddToRows, batch);
  if (!changed.ok()) return changed.status();
  std::set<std::pair<int64_t, int64_t>> joined;
  if (*changed < rows.size()) {
    const auto stored = LoadSequences(PlacesOf(rows), /*quarantined=*/false);
    if (!stored.ok()) return stored.status();
    SqlBatch missing;
    for (const auto& [place, row] : rows) {
      if (stored->contains(place)) continue;
      AddRow(missing, place, row.sequence, row.evidence);
      ++sums[place.first].source_count;
      joined.emplace(place.second, row.scene);
    }
    if (absl::Status status = database_->Run(put[0].c_str(), missing); !status.ok()) return status;
  }
  SqlBatch keys, changes;
  for (const auto& [key, change] : sums) {
    keys.Add(key);
    changes.Add(key, SqlAmount{change.evidence.alpha}, SqlAmount{change.evidence.beta},
                change.evidence.window_count, change.evidence.bail_out_count, change.source_count);
  }
  SourceCounts scenes;
  for (const auto& [place, row] : rows) scenes.try_emplace(row.scene, 0);
  absl::Status status = database_->Run(kLockKeys, keys);
  if (status.ok()) status = database_->Run(kAddToSums, changes);
  if (status.ok()) status = JoinScenes(joined, scenes);
  return status.ok() ? ChangeScenes(scenes) : status;
}

absl::StatusOr<SqlPriorStore::Sources> SqlPriorStore::LockOrAdd(
    std::span<const NewSource> sources) {
  std::set<std::string_view> names;
  for (const NewSource& source : sources) names.insert(source.name);
  SqlBatch batch;
  for (const std::string_view name : names) batch.Add(name);
  Sources found;
  absl::Status status = database_->ForEachRow(
      kLockSources,
      [&](const SqlRow& row) {
        found[row.Text(0)] = {.id = row.Integer(1),
                              .is_session = row.Boolean(2),
                              .revoked = row.Boolean(3),
                              .commit_sequence = row.Unsigned(4),
                              .writer = row.Unsigned(5)};
      },
      batch);
  std::vector<const NewSource*> unknown;
  for (const NewSource& source : sources) {
    if (found.try_emplace(source.name).second) unknown.push_back(&source);
  }
  if (status.ok()) status = AddSources(unknown, found);
  if (!status.ok()) return status;
  return found;
}

absl::Status SqlPriorStore::AddSources(std::span<const NewSource* const> sources, Sources& found) {
  if (sources.empty()) return absl::OkStatus();
  std::map<std::string_view, const NewSource*> by_name;
  auto source = sources.begin();
  absl::Status status = database_->ForEachRow(
      kNextSourceIds,
      [&](const SqlRow& row) {
        by_name[(*source)->name] = *source;
        found[(*source++)->name].id = row.Integer(0);
      },
      sources.size());
  if (!status.ok()) return status;
  SqlBatch batch;
  for (const auto& [name, values] : by_name)
    batch.Add(found[values->name].id, name, values->build, values->last_seen_unix_s);
  size_t added = 0;
  status = database_->ForEachRow(
      kAddSources, [&](const SqlRow&) { ++added; }, batch);
  if (!status.ok() || added == sources.size()) return status;
  return absl::AbortedError("another daemon has added a source at the same time");
}

absl::Status SqlPriorStore::UpdateSources(const Sources& sources) {
  SqlBatch batch;
  for (const auto& [name, source] : sources) {
    if (source.last == nullptr) continue;
    const auto& progress = source.last->progress;
    const auto& origin = source.first->origin;
    const std::array<SqlValue, 14> values = {ToSql(source.id),
                                             ToSql(progress.commit_sequence),
                                             ToSql(progress.message_sequence),
                                             ToSql(progress.explored_arm_count),
                                             ToSql(progress.decision_count),
                                             ToSql(progress.frame_count),
                                             ToSql(progress.seed),
                                             ToSql(source.last->unix_time_s),
                                             ToSql(source.first->unix_time_s),
                                             ToSql(origin.build),
                                             ToSql(origin.token_id),
                                             ToSql(origin.player),
                                             ToSql(origin.network),
                                             ToSql(source.writer)};
    // The column `writer`, the last value, exists in PostgreSQL only.
    batch.Add(std::span(values).first(database_->shared() ? values.size() : values.size() - 1));
  }
  return database_->Run(kUpdateSources, batch);
}

absl::StatusOr<SqlPriorStore::Ids> SqlPriorStore::LockMatching(const priors::SourceFilter& filter,
                                                               bool quarantined) {
  return database_->Collect<Ids>(
      kLockMatching, [](const SqlRow& row, Ids& ids) { ids.insert(row.Integer(0)); }, filter.id,
      filter.build, filter.token_id, filter.from_unix_s, filter.until_unix_s, filter.project,
      decision::kAdminSession, quarantined, filter.player, filter.network);
}

absl::Status SqlPriorStore::Bar(const Ids& sources) {
  SqlBatch batch;
  for (const int64_t source : sources) batch.Add(source);
  return database_->Run(kBar, batch);
}

absl::StatusOr<std::vector<SqlPriorStore::StoredKey>> SqlPriorStore::FindOrAddKeys(
    std::span<const EvidenceKey* const> keys, const Adders& adders) {
  std::vector<StoredKey> found;
  std::set<EvidenceKey> unknown;
  for (const EvidenceKey* key : keys) {
    const auto known = known_keys_.find(*key);
    found.push_back(known == known_keys_.end() ? StoredKey() : known->second);
    if (found.back().id == 0) unknown.insert(*key);
  }
  if (unknown.empty()) return found;
  absl::Status status = FindKeys(unknown);
  if (status.ok() && !unknown.empty()) {
    std::set<std::tuple<std::string_view, std::string_view, std::string_view, uint32_t>> scenes;
    SqlBatch new_scenes, new_keys;
    const std::string no_party;
    for (const EvidenceKey& key : unknown) {
      scenes.emplace(key.project, key.scene, key.machine_class, key.reward_version);
      new_keys.Add(key.project, key.scene, key.measured_by, key.arm, key.backend_version,
                   key.machine_class, key.reward_version, key.regime);
    }
    for (const auto& [project, scene, machine_class, reward_version] : scenes) {
      const auto adder = adders.find(
          {std::string(project), std::string(scene), std::string(machine_class), reward_version});
      const bool has_adder = adder != adders.end();
      new_scenes.Add(project, scene, machine_class, reward_version,
                     has_adder ? adder->second.first : 0,
                     std::string_view(has_adder ? adder->second.second : no_party));
    }
    status = database_->Run(kAddScenes, new_scenes);
    if (status.ok()) status = database_->Run(kAddKeys, new_keys);
    if (status.ok()) status = FindKeys(unknown);
  }
  if (!status.ok()) return status;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (found[i].id == 0) found[i] = new_keys_.at(*keys[i]);
  }
  return found;
}

absl::Status SqlPriorStore::FindKeys(std::set<EvidenceKey>& unknown) {
  SqlBatch batch;
  std::vector<const EvidenceKey*> keys;
  for (const EvidenceKey& key : unknown) {
    batch.Add(key.project, key.scene, key.measured_by, key.arm, key.backend_version,
              key.machine_class, key.reward_version, key.regime, keys.size());
    keys.push_back(&key);
  }
  absl::Status status = database_->ForEachRow(
      kFindKeys,
      [&](const SqlRow& row) {
        new_keys_[*keys[row.Unsigned(0)]] = {
            .id = row.Integer(1), .scene = row.Integer(2), .is_known = row.Boolean(3)};
      },
      batch);
  std::erase_if(unknown, [&](const EvidenceKey& key) { return new_keys_.contains(key); });
  return status;
}

absl::Status SqlPriorStore::MakeKnown(std::span<const EvidenceKey* const> keys,
                                      std::span<const StoredKey> stored) {
  Ids unknown, scenes;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (stored[i].is_known) continue;
    unknown.insert(stored[i].id);
    scenes.insert(stored[i].scene);
    new_keys_[*keys[i]] = {.id = stored[i].id, .scene = stored[i].scene, .is_known = true};
  }
  return MakeKnown(unknown, scenes);
}

absl::Status SqlPriorStore::MakeKnown(const Ids& keys, const Ids& scenes) {
  SqlBatch of_keys, of_scenes;
  for (const int64_t key : keys) of_keys.Add(key);
  for (const int64_t scene : scenes) of_scenes.Add(scene);
  absl::Status status = database_->Run(kLockKeys, of_keys);
  if (status.ok()) status = database_->Run(kMakeKnown, of_keys);
  if (status.ok()) status = database_->Run(kLockScenes, of_scenes);
  return status.ok() ? database_->Run(kMakeScenesKnown, of_scenes) : status;
}

absl::StatusOr<ImportResult> SqlPriorStore::Import(std::span<const PriorRecord> records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  return ChangeUnless<ImportResult>(/*preview=*/false, [&] { return ImportAll(records); });
}

absl::StatusOr<ImportResult> SqlPriorStore::Quarantine(std::span<const PriorRecord> records,
                                                       uint64_t max_records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  return ChangeUnless<ImportResult>(/*preview=*/false,
                                    [&] { return QuarantineAll(records, max_records); });
}

absl::StatusOr<SqlPriorStore::RowList> SqlPriorStore::RowsOf(std::span<const PriorRecord> records,
                                                             ImportResult& result) {
  // A time in the future would make the source the latest one for ever.
  const auto now_s = static_cast<uint64_t>(priors::UnixNowS());
  std::vector<NewSource> names;
  for (const PriorRecord& record : records)
    names.push_back({record.source_id, record.build, std::min(record.last_seen_unix_s, now_s)});
  const auto sources = LockOrAdd(names);
  if (!sources.ok()) return sources.status();
  std::vector<const EvidenceKey*> keys;
  RowList rows;
  for (const PriorRecord& record : records) {
    const Source& source = sources->at(record.source_id);
    if (source.is_session || source.revoked) {
      ++result.unchanged_count;
      continue;
    }
    keys.push_back(&record.key);
    rows.push_back({{0, source.id}, {record.source_sequence, priors::InUnits(record.evidence), 0}});
  }
  const auto stored = FindOrAddKeys(keys);
  if (!stored.ok()) return stored.status();
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i].first.first = (*stored)[i].id;
    rows[i].second.scene = (*stored)[i].scene;
  }
  return rows;
}

absl::StatusOr<ImportResult> SqlPriorStore::ImportAll(std::span<const PriorRecord> records) {
  ImportResult result;
  const auto rows = RowsOf(records, result);
  if (!rows.ok()) return rows.status();
  const auto stored = LoadSequences(PlacesOf(*rows), /*quarantined=*/false);
  if (!stored.ok()) return stored.status();
  absl::Status status = Replace(*stored, *rows, /*quarantined=*/false, result);
  // Drops rows in quarantine that are not newer than a given record of the same key and source.
  SqlBatch given;
  for (const auto& [place, row] : *rows) given.Add(place.first, place.second, row.sequence);
  if (status.ok()) status = database_->Run(kDropWaiting, given);
  if (!status.ok()) return status;
  return result;
}

absl::StatusOr<ImportResult> SqlPriorStore::QuarantineAll(std::span<const PriorRecord> records,
                                                          uint64_t max_records) {
  ImportResult result;
  const auto rows = RowsOf(records, result);
  if (!rows.ok()) return rows.status();
  auto stored = LoadSequences(PlacesOf(*rows), /*quarantined=*/false);
  if (!stored.ok()) return stored.status();
  const auto waiting = LoadSequences(PlacesOf(*rows), /*quarantined=*/true);
  if (!waiting.ok()) return waiting.status();
  for (const auto& [place, sequence] : *waiting) {
    uint64_t& newest = (*stored)[place];
    newest = std::max(newest, sequence);
  }
  absl::Status status = Replace(*stored, *rows, /*quarantined=*/true, result);
  if (!status.ok()) return status;
  const auto count = database_->ReadInteger(kCountWaiting);
  status =
      count.ok() ? QuarantineBound(static_cast<uint64_t>(*count), max_records) : count.status();
  if (!status.ok()) return status;
  return result;
}

absl::StatusOr<SqlPriorStore::Sequences> SqlPriorStore::LoadSequences(const std::set<Place>& places,
                                                                      bool quarantined) {
  static const auto& load = *new EvidenceStatements(ForBothTables(kLoadSequences));
  SqlBatch batch;
  for (const auto& [key, source] : places) batch.Add(key, source);
  return database_->Collect<Sequences>(
      load[quarantined ? 1 : 0].c_str(),
      [](const SqlRow& row, Sequences& sequences) {
        sequences[{row.Integer(0), row.Integer(1)}] = row.Unsigned(2);
      },
      batch);
}

absl::Status SqlPriorStore::Replace(const Sequences& stored, const RowList& rows, bool quarantined,
                                    ImportResult& result) {
  static const auto& put = *new EvidenceStatements(ForBothTables(kPutRows));
  std::map<Place, const Row*> newest;
  for (const auto& [place, row] : rows) {
    const auto old = stored.find(place);
    const auto newer = newest.find(place);
    const uint64_t sequence = newer != newest.end() ? newer->second->sequence
                              : old != stored.end() ? old->second
                                                    : 0;
    const bool applied = row.sequence > sequence;
    if (applied) newest[place] = &row;
    ++(applied ? result.applied_count : result.unchanged_count);
  }
  SqlBatch batch;
  std::set<std::pair<int64_t, int64_t>> joined;
  Ids keys;
  SourceCounts scenes;
  for (const auto& [place, row] : newest) {
    AddRow(batch, place, row->sequence, row->evidence);
    keys.insert(place.first);
    scenes.try_emplace(row->scene, 0);
    if (!stored.contains(place)) joined.emplace(place.second, row->scene);
  }
  absl::Status status = database_->Run(put[quarantined ? 1 : 0].c_str(), batch);
  if (!status.ok() || quarantined) return status;
  status = RecountSums(keys);
  Ids changed;
  for (const auto& [scene, added] : scenes) changed.insert(scene);
  if (status.ok()) status = MakeKnown(keys, changed);
  if (status.ok()) status = JoinScenes(joined, scenes);
  return status.ok() ? ChangeScenes(scenes) : status;
}

absl::StatusOr<SqlPriorStore::RowList> SqlPriorStore::TakeOut(const Ids& sources,
                                                              const std::string& project,
                                                              bool with_damaged) {
  SqlBatch batch;
  for (const int64_t source : sources) batch.Add(source, project, with_damaged);
  return database_->Collect<RowList>(
      kTakeOut,
      [](const SqlRow& row, RowList& taken) {
        taken.push_back({{row.Integer(0), row.Integer(1)},
                         {row.Unsigned(2), EvidenceOf(row, 3), row.Integer(7)}});
      },
      batch);
}

absl::Status SqlPriorStore::RecountSums(const Ids& keys) {
  SqlBatch batch;
  for (const int64_t key : keys) batch.Add(key);
  absl::Status status = database_->Run(kLockKeys, batch);
  return status.ok() ? database_->Run(kRecountSums, batch) : status;
}

absl::Status SqlPriorStore::JoinScenes(
    const std::set<std::pair<int64_t, int64_t>>& sources_and_scenes, SourceCounts& scenes) {
  SqlBatch batch, ids;
  for (const auto& [source, scene] : sources_and_scenes) batch.Add(source, scene);
  Ids joined;
  for (const auto& [source, scene] : sources_and_scenes) joined.insert(scene);
  for (const int64_t scene : joined) ids.Add(scene);
  absl::Status status = database_->Run(kLockScenes, ids);
  if (!status.ok()) return status;
  status = database_->ForEachRow(
      kJoinScenes, [&](const SqlRow& row) { ++scenes[row.Integer(0)]; }, batch);
  return status.ok() ? database_->Run(kJoinParties, batch) : status;
}

absl::Status SqlPriorStore::LeaveScenes(const SqlBatch& sources, SourceCounts& scenes) {
  std::set<std::tuple<int64_t, int64_t, std::string>> left;
  absl::Status status = database_->ForEachRow(
      kLeaveScenes,
      [&](const SqlRow& row) {
        --scenes[row.Integer(0)];
        left.emplace(row.Integer(0), row.Integer(1), row.Text(2));
      },
      sources);
  SqlBatch ids, parties;
  for (const auto& [scene, count] : scenes) ids.Add(scene);
  for (const auto& [scene, token_id, party] : left) parties.Add(scene, token_id, party);
  if (status.ok()) status = database_->Run(kLockScenes, ids);
  if (status.ok()) status = database_->Run(kLeaveParties, parties);
  return status.ok() ? database_->Run(kKeepParties, parties) : status;
}

absl::Status SqlPriorStore::ChangeScenes(const SourceCounts& changes) {
  SqlBatch ids, batch;
  for (const auto& [id, added] : changes) {
    if (added == 0 && !database_->shared()) continue;
    ids.Add(id);
    batch.Add(id, added);
  }
  // Scenes that got their first source, by project and name.
  std::map<std::pair<std::string, std::string>, uint64_t> begun;
  absl::Status status = database_->Run(kLockScenes, ids);
  if (status.ok())
    status = database_->ForEachRow(
        kChangeScenes,
        [&](const SqlRow& row) {
          if (row.Boolean(2) && scene_counts_.contains(row.Text(0)))
            ++begun[{row.Text(0), row.Text(1)}];
        },
        batch);
  for (const auto& [name, count] : begun) {
    priors::SceneCount& added = added_counts_[name.first];
    added.keys += count;
    const auto count_name = [&, count = count](const SqlRow& row) {
      if (row.Unsigned(0) == count) ++added.names;
    };
    if (status.ok())
      status = database_->ForEachRow(kCountKeysOfName, count_name, name.first, name.second);
  }
  return status;
}

absl::StatusOr<priors::ChangeResult> SqlPriorStore::Promote(const priors::SourceFilter& filter,
                                                            const priors::Preview& preview) {
  return ChangeUnless<priors::ChangeResult>(preview, [&] { return PromoteAll(filter); });
}

absl::StatusOr<priors::ChangeResult> SqlPriorStore::PromoteAll(const priors::SourceFilter& filter) {
  const auto matching = LockMatching(filter, /*quarantined=*/true);
  if (!matching.ok()) return matching.status();
  const auto taken = TakeOut(*matching, filter.project, /*with_damaged=*/false);
  if (!taken.ok()) return taken.status();
  const auto stored = LoadSequences(PlacesOf(*taken), /*quarantined=*/false);
  if (!stored.ok()) return stored.status();
  ImportResult ignored;
  absl::Status status = Replace(*stored, *taken, /*quarantined=*/false, ignored);
  if (!status.ok()) return status;
  priors::ChangeResult result{.record_count = taken->size()};
  Ids sources, scenes;
  for (const auto& [place, row] : *taken) {
    sources.insert(place.second);
    scenes.insert(row.scene);
    result.window_count += row.evidence.window_count;
  }
  result.source_count = sources.size();
  result.scene_count = scenes.size();
  return result;
}

absl::StatusOr<priors::ChangeResult> SqlPriorStore::Revoke(const priors::SourceFilter& filter,
                                                           const priors::Preview& preview) {
  scene_counts_.clear();  // a revocation can leave scenes without evidence
  known_keys_.clear();    // and arms unknown
  return ChangeUnless<priors::ChangeResult>(preview, [&] { return RevokeAll(filter); });
}

absl::StatusOr<priors::ChangeResult> SqlPriorStore::RevokeAll(const priors::SourceFilter& filter) {
  auto matching = LockMatching(filter, /*quarantined=*/false);
  if (!matching.ok()) return matching.status();
  priors::ChangeResult result{.source_count = matching->size()};
  if (matching->empty() && BarsUnknown(filter)) {
    const auto added = LockOrAdd(std::vector<NewSource>{{filter.id}});
    if (!added.ok()) return added.status();
    matching->insert(added->at(filter.id).id);
  }
  SqlBatch sources;
  for (const int64_t source : *matching) sources.Add(source, filter.project);
  Ids keys;
  absl::Status status = database_->ForEachRow(
      kDeleteEvidence,
      [&](const SqlRow& row) {
        keys.insert(row.Integer(0));
        ++result.record_count;
        result.window_count += row.Count(1);
      },
      sources);
  if (status.ok()) status = RecountSums(keys);
  SourceCounts scenes;
  if (status.ok()) status = LeaveScenes(sources, scenes);
  SqlBatch left;
  for (const auto& [scene, count] : scenes) left.Add(scene);
  if (status.ok()) status = database_->Run(kMakeUnknown, left);
  if (status.ok()) status = ChangeScenes(scenes);
  if (!status.ok()) return status;
  const auto waited = TakeOut(*matching, filter.project, /*with_damaged=*/true);
  if (!waited.ok()) return waited.status();
  result.record_count += waited->size();
  for (const auto& [place, row] : *waited) result.window_count += row.evidence.window_count;
  if (status = Bar(*matching); !status.ok()) return status;
  return result;
}

}  // namespace sweepstake::storage
