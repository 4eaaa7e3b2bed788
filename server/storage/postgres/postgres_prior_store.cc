#include "server/storage/postgres/postgres_prior_store.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/storage/postgres/postgres_audit_log.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_evidence.h"
#include "server/storage/postgres/postgres_quarantine.h"
#include "server/storage/postgres/postgres_reader.h"
#include "server/storage/postgres/postgres_schema.h"
#include "server/storage/postgres/postgres_sources.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

using priors::EvidenceKey;
using priors::PriorRecord;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;
using priors::SourceUpdate;

constexpr const char* kFirstTransaction = "0";
constexpr int kAttempts = 20;  // of a transaction that conflicts with others

// Commits join a few hundred given rows with tables by their keys. Without statistics about a table
// the server would read all of it.
constexpr const char* kPlans =
    "SET enable_hashjoin = off; SET enable_mergejoin = off; SET jit = off";

// Given rows, maybe several for one place: whole amounts, not changes.
using RowList = std::vector<std::pair<RowPlace, RowChange>>;

template <typename Rows>
std::set<RowPlace> PlacesOf(const Rows& rows) {
  std::set<RowPlace> places;
  for (const auto& [place, row] : rows) places.insert(place);
  return places;
}

// Returns the newest given row of each place that is newer than the stored one, and counts both
// kinds of rows.
template <typename Rows>
RowChanges NewerThan(const RowChanges& stored, const Rows& rows, priors::ImportResult& result) {
  RowChanges newest;
  for (const auto& [place, row] : rows) {
    const auto old = stored.find(place);
    const auto newer = newest.find(place);
    const uint64_t sequence = newer != newest.end() ? newer->second.sequence
                              : old != stored.end() ? old->second.sequence
                                                    : 0;
    const bool applied = row.sequence > sequence;
    if (applied) newest[place] = row;
    ++(applied ? result.applied_count : result.unchanged_count);
  }
  return newest;
}

class PostgresPriorStore final : public priors::PriorStore {
 public:
  PostgresPriorStore(const std::string& url, const priors::AuditLimits& audit_limits)
      : connection_(url),
        reader_(connection_),
        sources_(connection_),
        evidence_(connection_),
        quarantine_(connection_),
        audit_(connection_, audit_limits) {}

  absl::Status Prepare();
  void Limit(const priors::AuditLimits& audit_limits);
  absl::StatusOr<std::string> ShareResumeKey(const std::string& own);

  absl::Status Commit(std::span<const SourceUpdate> updates) override;
  uint64_t lost_audit_row_count() const override { return lost_audit_row_count_; }
  absl::StatusOr<std::vector<SceneKey>> TakeChangedScenes() override;
  absl::StatusOr<std::vector<priors::SceneSource>> LoadSources(const SceneKey& scene) override {
    return reader_.LoadSources(scene);
  }
  absl::StatusOr<std::optional<priors::SourceState>> LoadSource(
      const std::string& source_id) override {
    return reader_.LoadSource(source_id);
  }
  absl::StatusOr<std::vector<SceneEvidence>> List(const SceneFilter& filter,
                                                  const std::optional<SceneKey>& after,
                                                  uint32_t limit) override {
    return reader_.List(filter, after, limit);
  }
  absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) override {
    return reader_.LoadScene(key);
  }
  absl::StatusOr<priors::SceneCount> CountScenes(const std::string& project) override {
    return reader_.CountScenes(project);
  }
  absl::StatusOr<uint64_t> CountProjects() override { return reader_.CountProjects(); }
  absl::StatusOr<priors::ExportPage> Export(const SceneFilter& filter,
                                            const priors::ExportPlace& after,
                                            uint32_t limit) override {
    return reader_.Export(filter, after, limit);
  }
  absl::StatusOr<priors::ExportPage> ExportQuarantined(const SceneFilter& filter,
                                                       const priors::ExportPlace& after,
                                                       uint32_t limit) override {
    return reader_.ExportQuarantined(filter, after, limit);
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
    return reader_.ListAudit(filter, after, limit);
  }
  absl::StatusOr<std::vector<priors::AuditRow>> LoadAudit(uint64_t segment_id, uint64_t first_row,
                                                          uint32_t limit,
                                                          size_t max_bytes) override {
    return reader_.LoadAudit(segment_id, first_row, limit, max_bytes);
  }

 private:
  // Connects if necessary, and only to the same database as before.
  absl::Status Connect();
  // Runs `body` in a transaction, which is rolled back if it fails. After a conflict with another
  // daemon it runs again from the start.
  template <typename Body>
  absl::Status InTransaction(Body body);
  template <typename Body>
  absl::Status TryTransaction(Body& body);
  // Sets `lost` to the number of audit rows that could not be written.
  absl::Status CommitAll(std::span<const SourceUpdate> updates, uint64_t& lost);
  absl::Status AddIncrements(std::span<const SourceUpdate* const> updates,
                             const LockedSources& sources);
  // Returns a row for each record, in the same order. The row is {} if its source takes no
  // imports.
  absl::StatusOr<RowList> RowsOf(std::span<const PriorRecord> records);
  // Replaces the stored rows by whole amounts.
  absl::Status Replace(const RowChanges& stored, RowChanges newer);
  absl::Status ImportAll(std::span<const PriorRecord> records, priors::ImportResult& result);
  absl::Status QuarantineAll(std::span<const PriorRecord> records, uint64_t max_records,
                             priors::ImportResult& result);
  absl::StatusOr<priors::PromoteResult> PromoteAll(const priors::SourceFilter& filter);
  absl::StatusOr<priors::RevokeResult> RevokeAll(const priors::SourceFilter& filter);
  // Runs `change`, which returns a result, in a transaction. A preview does not commit it.
  template <typename Result, typename Change>
  absl::StatusOr<Result> ChangeUnless(const priors::Preview& preview, Change change);

  PostgresConnection connection_;
  PostgresReader reader_;
  PostgresSources sources_;
  PostgresEvidence evidence_;
  PostgresQuarantine quarantine_;
  PostgresAuditLog audit_;
  std::string store_id_;
  uint64_t incarnation_ = 0;  // of the connection that was checked to be to this store
  std::string changes_since_ = kFirstTransaction;
  uint64_t lost_audit_row_count_ = 0;
};

absl::Status PostgresPriorStore::Prepare() {
  if (absl::Status status = connection_.Connect(); !status.ok()) return status;
  auto id = PreparePostgresSchema(connection_);
  if (!id.ok()) return id.status();
  store_id_ = *std::move(id);
  return Connect();
}

void PostgresPriorStore::Limit(const priors::AuditLimits& audit_limits) {
  audit_.Limit(audit_limits);
  // If the server cannot remove the rows now, a later commit does.
  InTransaction([&] { return audit_.Trim(/*unix_now_s=*/0); }).IgnoreError();
}

absl::StatusOr<std::string> PostgresPriorStore::ShareResumeKey(const std::string& own) {
  std::string key;
  absl::Status status = InTransaction([&] {
    return connection_.ForEachRow(
        "UPDATE store SET resume_key = coalesce(resume_key, decode($1, 'hex')) RETURNING "
        "resume_key",
        [&](const PostgresRow& row) { key = row.Bytes(0); }, absl::BytesToHexString(own));
  });
  if (!status.ok()) return status;
  return key;
}

absl::Status PostgresPriorStore::Connect() {
  absl::Status status = connection_.Connect();
  if (!status.ok() || incarnation_ == connection_.incarnation()) return status;
  evidence_.OnReconnected();
  const auto id = PostgresStoreId(connection_);
  if (!id.ok()) return id.status();
  if (*id != store_id_) {
    return absl::UnavailableError(
        "the database in PostgreSQL is not the one that was there before; put that one back, or "
        "restart the daemon to use this one");
  }
  changes_since_ = kFirstTransaction;  // a restored server counts transactions from the start
  status = connection_.Execute(kPlans);
  if (status.ok()) incarnation_ = connection_.incarnation();
  return status;
}

template <typename Body>
absl::Status PostgresPriorStore::TryTransaction(Body& body) {
  absl::Status status = Connect();
  if (status.ok()) status = connection_.Execute("BEGIN");
  if (!status.ok()) return status;
  status = body();
  if (status.ok()) status = connection_.Execute("COMMIT");
  evidence_.OnEnd(status.ok());
  if (!status.ok()) connection_.Execute("ROLLBACK").IgnoreError();
  return status;
}

template <typename Body>
absl::Status PostgresPriorStore::InTransaction(Body body) {
  absl::Status status;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    status = TryTransaction(body);
    if (!absl::IsAborted(status)) return status;
  }
  return absl::UnavailableError(status.message());
}

absl::StatusOr<std::vector<SceneKey>> PostgresPriorStore::TakeChangedScenes() {
  if (absl::Status status = Connect(); !status.ok()) return status;
  return reader_.LoadChangedScenes(changes_since_);
}

absl::Status PostgresPriorStore::Commit(std::span<const SourceUpdate> updates) {
  if (absl::Status status = CheckUpdates(updates); !status.ok()) return status;
  uint64_t lost = 0;
  absl::Status status = InTransaction([&] { return CommitAll(updates, lost); });
  if (status.ok()) lost_audit_row_count_ += lost;
  return status;
}

absl::Status PostgresPriorStore::CommitAll(std::span<const SourceUpdate> updates, uint64_t& lost) {
  std::vector<NewSource> names;
  for (const SourceUpdate& update : updates) names.push_back({update.progress.source_id});
  auto sources = sources_.LockOrAdd(names);
  if (!sources.ok()) return sources.status();
  std::vector<const SourceUpdate*> applied;
  std::vector<const SourceUpdate*> audited;
  PostgresArray begun;  // sources that take no imports any more
  bool any_begun = false;
  for (const SourceUpdate& update : updates) {
    LockedSource& source = sources->at(update.progress.source_id);
    const auto is_new = source.Advance(update);
    if (!is_new.ok()) return is_new.status();
    if (!*is_new) continue;
    applied.push_back(&update);
    if (!update.audit.rows.empty()) audited.push_back(&update);
    if (source.is_session) continue;
    begun.Add(source.id);
    any_begun = true;
  }
  absl::Status status = AddIncrements(applied, *sources);
  if (status.ok() && any_begun) status = quarantine_.TakeOut(begun, "").status();
  if (status.ok()) status = sources_.Update(*sources);
  if (!status.ok() || audited.empty()) return status;
  const auto lost_rows = audit_.Append(audited);
  lost = lost_rows.value_or(0);
  return lost_rows.status();
}

absl::Status PostgresPriorStore::AddIncrements(std::span<const SourceUpdate* const> updates,
                                               const LockedSources& sources) {
  std::vector<const EvidenceKey*> keys;
  for (const SourceUpdate* update : updates) {
    for (const auto& increment : update->increments) keys.push_back(&increment.key);
  }
  const auto ids = evidence_.FindOrAddKeys(keys);
  if (!ids.ok()) return ids.status();
  RowChanges changes;
  auto id = ids->begin();
  for (const SourceUpdate* update : updates) {
    const int64_t source = sources.at(update->progress.source_id).id;
    for (const auto& [key, evidence] : update->increments) {
      RowChange& change = changes[{*id++, source}];
      change.sequence = update->progress.commit_sequence;
      change.units += UnitsOf(evidence);
    }
  }
  return evidence_.Apply(changes);
}

absl::StatusOr<priors::ImportResult> PostgresPriorStore::Import(
    std::span<const PriorRecord> records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  priors::ImportResult result;
  absl::Status status = InTransaction([&] {
    result = {};
    return ImportAll(records, result);
  });
  if (!status.ok()) return status;
  return result;
}

absl::StatusOr<RowList> PostgresPriorStore::RowsOf(std::span<const PriorRecord> records) {
  std::vector<NewSource> names;
  for (const PriorRecord& record : records)
    names.push_back({record.source_id, record.build, record.last_seen_unix_s});
  const auto sources = sources_.LockOrAdd(names);
  if (!sources.ok()) return sources.status();
  std::vector<const EvidenceKey*> keys;
  for (const PriorRecord& record : records) {
    if (sources->at(record.source_id).takes_imports()) keys.push_back(&record.key);
  }
  const auto ids = evidence_.FindOrAddKeys(keys);
  if (!ids.ok()) return ids.status();
  RowList rows;
  auto id = ids->begin();
  for (const PriorRecord& record : records) {
    auto& [place, row] = rows.emplace_back();
    const LockedSource& source = sources->at(record.source_id);
    if (!source.takes_imports()) continue;
    place = {*id++, source.id};
    row = {record.source_sequence, UnitsOf(record.evidence)};
  }
  return rows;
}

absl::Status PostgresPriorStore::Replace(const RowChanges& stored, RowChanges newer) {
  for (auto& [place, change] : newer) {
    if (const auto old = stored.find(place); old != stored.end()) change.units -= old->second.units;
  }
  return evidence_.Apply(newer);
}

absl::Status PostgresPriorStore::ImportAll(std::span<const PriorRecord> records,
                                           priors::ImportResult& result) {
  const auto rows = RowsOf(records);
  if (!rows.ok()) return rows.status();
  RowChanges given;  // rows in quarantine that are not newer are dropped in either case
  for (const auto& [place, row] : *rows) {
    if (row.sequence > given[place].sequence) given[place] = row;
  }
  const auto stored = evidence_.Load(PlacesOf(given));
  if (!stored.ok()) return stored.status();
  absl::Status status = Replace(*stored, NewerThan(*stored, *rows, result));
  return status.ok() ? quarantine_.Drop(given) : status;
}

absl::Status PostgresPriorStore::QuarantineAll(std::span<const PriorRecord> records,
                                               uint64_t max_records, priors::ImportResult& result) {
  const auto rows = RowsOf(records);
  if (!rows.ok()) return rows.status();
  const auto places = PlacesOf(*rows);
  auto stored = evidence_.Load(places);
  if (!stored.ok()) return stored.status();
  const auto waiting = quarantine_.Load(places);
  if (!waiting.ok()) return waiting.status();
  for (const auto& [place, row] : *waiting) {
    if (RowChange& newest = (*stored)[place]; row.sequence > newest.sequence) newest = row;
  }
  absl::Status status = quarantine_.Put(NewerThan(*stored, *rows, result));
  return status.ok() ? quarantine_.CheckSize(max_records) : status;
}

absl::StatusOr<priors::ImportResult> PostgresPriorStore::Quarantine(
    std::span<const PriorRecord> records, uint64_t max_records) {
  if (absl::Status status = CheckRecords(records); !status.ok()) return status;
  priors::ImportResult result;
  absl::Status status = InTransaction([&] {
    result = {};
    return QuarantineAll(records, max_records, result);
  });
  if (!status.ok()) return status;
  return result;
}

template <typename Result, typename Change>
absl::StatusOr<Result> PostgresPriorStore::ChangeUnless(const priors::Preview& preview,
                                                        Change change) {
  absl::StatusOr<Result> result;
  absl::Status status = InTransaction([&] {
    result = change();
    if (!result.ok() || !preview) return result.status();
    preview.Show(reader_);
    return absl::CancelledError("a preview");
  });
  return status.ok() || (result.ok() && absl::IsCancelled(status)) ? result : status;
}

absl::StatusOr<priors::PromoteResult> PostgresPriorStore::Promote(
    const priors::SourceFilter& filter, const priors::Preview& preview) {
  return ChangeUnless<priors::PromoteResult>(preview, [&] { return PromoteAll(filter); });
}

absl::StatusOr<priors::PromoteResult> PostgresPriorStore::PromoteAll(
    const priors::SourceFilter& filter) {
  const auto matching = sources_.LockMatching(filter, /*quarantined=*/true);
  if (!matching.ok()) return matching.status();
  const auto taken = quarantine_.TakeOut(matching->ids, filter.project);
  if (!taken.ok()) return taken.status();
  const auto stored = evidence_.Load(PlacesOf(taken->rows));
  if (!stored.ok()) return stored.status();
  std::set<int64_t> sources;
  for (const auto& [place, row] : taken->rows) sources.insert(place.second);
  priors::ImportResult ignored;
  absl::Status status = Replace(*stored, NewerThan(*stored, taken->rows, ignored));
  if (!status.ok()) return status;
  return priors::PromoteResult{.source_count = sources.size(),
                               .record_count = taken->rows.size(),
                               .window_count = taken->window_count,
                               .scene_count = taken->scenes.size()};
}

absl::StatusOr<priors::RevokeResult> PostgresPriorStore::Revoke(const priors::SourceFilter& filter,
                                                                const priors::Preview& preview) {
  return ChangeUnless<priors::RevokeResult>(preview, [&] { return RevokeAll(filter); });
}

absl::StatusOr<priors::RevokeResult> PostgresPriorStore::RevokeAll(
    const priors::SourceFilter& filter) {
  const auto matching = sources_.LockMatching(filter, /*quarantined=*/false);
  if (!matching.ok()) return matching.status();
  if (matching->count == 0 && BarsUnknown(filter)) {
    const std::vector<NewSource> unknown = {{filter.id}};
    const auto added = sources_.LockOrAdd(unknown);
    if (!added.ok()) return added.status();
    PostgresArray id;
    id.Add(added->at(filter.id).id);
    if (absl::Status status = sources_.Bar(id); !status.ok()) return status;
    return priors::RevokeResult{};
  }
  const auto removed = evidence_.Remove(matching->ids, filter.project);
  if (!removed.ok()) return removed.status();
  const auto waited = quarantine_.TakeOut(matching->ids, filter.project);
  if (!waited.ok()) return waited.status();
  if (absl::Status status = sources_.Bar(matching->ids); !status.ok()) return status;
  return priors::RevokeResult{.source_count = matching->count,
                              .record_count = removed->record_count + waited->rows.size(),
                              .window_count = removed->window_count + waited->window_count};
}

}  // namespace

absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenPostgresPriorStore(
    const std::string& url, const priors::AuditLimits& audit_limits) {
  auto store = std::make_unique<PostgresPriorStore>(url, audit_limits);
  if (absl::Status status = store->Prepare(); !status.ok()) return status;
  return store;
}

absl::StatusOr<std::string> ShareResumeKey(priors::PriorStore& store, const std::string& own) {
  return static_cast<PostgresPriorStore&>(store).ShareResumeKey(own);
}

void LimitPostgresAudit(priors::PriorStore& store, const priors::AuditLimits& audit_limits) {
  static_cast<PostgresPriorStore&>(store).Limit(audit_limits);
}

}  // namespace sweepstake::storage
