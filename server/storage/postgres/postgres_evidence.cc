#include "server/storage/postgres/postgres_evidence.h"

#include <array>

namespace sweepstake::storage {
namespace {

using priors::EvidenceKey;

constexpr size_t kMaxKnownKeys = 100'000;  // some 200 bytes each

// The last of the three also finds the keys that another daemon has added meanwhile.
constexpr const char* kAddScenes = R"sql(
    INSERT INTO scene (project, scene, machine_class, reward_version)
    SELECT DISTINCT project COLLATE "C", scene COLLATE "C", machine_class COLLATE "C",
           reward_version
    FROM unnest($1::text[], $2::text[], $3::text[], $4::text[], $5::bigint[], $6::text[],
                $7::bigint[])
         AS given(project, scene, measured_by, arm, backend_version, machine_class, reward_version)
    ORDER BY 1, 2, 3, 4 ON CONFLICT DO NOTHING)sql";
constexpr const char* kAddKeys = R"sql(
    INSERT INTO evidence_key (scene_id, project, scene, measured_by, arm, backend_version,
                              machine_class, reward_version)
    SELECT s.id, project, scene, measured_by, arm, backend_version, machine_class, reward_version
    FROM unnest($1::text[], $2::text[], $3::text[], $4::text[], $5::bigint[], $6::text[],
                $7::bigint[])
         AS given(project, scene, measured_by, arm, backend_version, machine_class, reward_version)
         JOIN scene s USING (project, scene, machine_class, reward_version)
    ORDER BY 2, 3, 4, 5, 6, 7, 8 ON CONFLICT DO NOTHING)sql";
constexpr const char* kFindKeys = R"sql(
    SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version, k.id
    FROM unnest($1::text[], $2::text[], $3::text[], $4::text[], $5::bigint[], $6::text[],
                $7::bigint[])
         AS given(project, scene, measured_by, arm, backend_version, machine_class, reward_version)
         JOIN evidence_key k USING (project, scene, measured_by, arm, backend_version,
                                    machine_class, reward_version))sql";
constexpr const char* kLoadEvidence = R"sql(
    SELECT key_id, source_id, sequence, alpha, beta, window_count, bail_out_count
    FROM unnest($1::bigint[], $2::bigint[]) AS given(key_id, source_id)
         JOIN evidence USING (key_id, source_id))sql";
constexpr const char* kChangeRows = R"sql(
    UPDATE evidence e
    SET sequence = g.sequence, alpha = e.alpha + g.alpha, beta = e.beta + g.beta,
        window_count = e.window_count + g.window_count,
        bail_out_count = e.bail_out_count + g.bail_out_count
    FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::numeric[], $5::numeric[],
                $6::numeric[], $7::numeric[])
         AS g(key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)
    WHERE e.key_id = g.key_id AND e.source_id = g.source_id)sql";
// Adds the missing ones of the same rows. No one else adds them, since the sources are locked.
constexpr const char* kAddEvidence = R"sql(
    INSERT INTO evidence (key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)
    SELECT *
    FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::numeric[], $5::numeric[],
                $6::numeric[], $7::numeric[])
         AS g(key_id, source_id, sequence, alpha, beta, window_count, bail_out_count)
    WHERE NOT EXISTS (SELECT FROM evidence e
                      WHERE e.key_id = g.key_id AND e.source_id = g.source_id)
    RETURNING key_id, source_id)sql";
// Returns the scenes that gained a source.
constexpr const char* kJoinScenes = R"sql(
    INSERT INTO scene_source (source_id, scene_id)
    SELECT DISTINCT source_id, scene_id
    FROM unnest($1::bigint[], $2::bigint[]) AS given(key_id, source_id)
         JOIN evidence_key k ON k.id = key_id
    ORDER BY 1, 2 ON CONFLICT DO NOTHING RETURNING scene_id)sql";
constexpr const char* kLockScenes =
    "SELECT FROM scene WHERE id = ANY($1::bigint[]) ORDER BY id FOR NO KEY UPDATE";
constexpr const char* kChangeScenes = R"sql(
    UPDATE scene
    SET source_count = source_count + added, changed_in = pg_current_xact_id()
    FROM unnest($1::bigint[], $2::bigint[]) AS given(scene_id, added) WHERE id = scene_id)sql";
constexpr const char* kLockKeys =
    "SELECT FROM evidence_key WHERE id = ANY($1::bigint[]) ORDER BY id FOR NO KEY UPDATE";
constexpr const char* kAddToSums = R"sql(
    UPDATE evidence_key
    SET alpha_sum = alpha_sum + alpha, beta_sum = beta_sum + beta,
        window_sum = window_sum + window_count, bail_out_sum = bail_out_sum + bail_out_count,
        source_count = source_count + added
    FROM unnest($1::bigint[], $2::numeric[], $3::numeric[], $4::numeric[], $5::numeric[],
                $6::bigint[])
         AS given(key_id, alpha, beta, window_count, bail_out_count, added)
    WHERE id = key_id
    RETURNING scene_id)sql";
constexpr const char* kRemoveRows = R"sql(
    DELETE FROM evidence e USING evidence_key k
    WHERE k.id = key_id AND source_id = ANY($1::bigint[]) AND ($2 = '' OR project = $2)
    RETURNING key_id, alpha, beta, window_count, bail_out_count)sql";
constexpr const char* kLeaveScenes = R"sql(
    DELETE FROM scene_source j USING scene s
    WHERE s.id = j.scene_id AND j.source_id = ANY($1::bigint[]) AND ($2 = '' OR s.project = $2)
    RETURNING scene_id)sql";

// The columns of keys, as parameters.
class KeyArrays {
 public:
  explicit KeyArrays(const std::set<EvidenceKey>& keys) {
    for (const EvidenceKey& key : keys) {
      columns_[0].Add(key.project);
      columns_[1].Add(key.scene);
      columns_[2].Add(key.measured_by);
      columns_[3].Add(key.arm);
      columns_[4].Add(key.backend_version);
      columns_[5].Add(key.machine_class);
      columns_[6].Add(key.reward_version);
    }
  }
  template <typename OnRow>
  absl::Status Run(PostgresConnection& connection, const char* sql, OnRow on_row) const {
    return connection.ForEachRow(sql, on_row, columns_[0], columns_[1], columns_[2], columns_[3],
                                 columns_[4], columns_[5], columns_[6]);
  }

 private:
  std::array<PostgresArray, 7> columns_;
};

}  // namespace

EvidenceUnits& EvidenceUnits::operator+=(const EvidenceUnits& other) {
  alpha += other.alpha;
  beta += other.beta;
  window_count += other.window_count;
  bail_out_count += other.bail_out_count;
  return *this;
}

EvidenceUnits& EvidenceUnits::operator-=(const EvidenceUnits& other) {
  alpha -= other.alpha;
  beta -= other.beta;
  window_count -= other.window_count;
  bail_out_count -= other.bail_out_count;
  return *this;
}

EvidenceUnits UnitsOf(const priors::Evidence& evidence) {
  const priors::Evidence whole = priors::InUnits(evidence);
  return {.alpha = UnitsOf(whole.alpha),
          .beta = UnitsOf(whole.beta),
          .window_count = Units(evidence.window_count),
          .bail_out_count = Units(evidence.bail_out_count)};
}

EvidenceUnits UnitsOf(const PostgresRow& row, int first) {
  return {.alpha = row.Number(first),
          .beta = row.Number(first + 1),
          .window_count = row.Number(first + 2),
          .bail_out_count = row.Number(first + 3)};
}

void UnitArrays::Add(const EvidenceUnits& units) {
  alpha.Add(units.alpha);
  beta.Add(units.beta);
  window_count.Add(units.window_count);
  bail_out_count.Add(units.bail_out_count);
}

absl::StatusOr<std::vector<int64_t>> PostgresEvidence::FindOrAddKeys(
    std::span<const EvidenceKey* const> keys) {
  std::vector<int64_t> ids;
  std::set<EvidenceKey> unknown;
  for (const EvidenceKey* key : keys) {
    const auto known = known_keys_.find(*key);
    ids.push_back(known == known_keys_.end() ? 0 : known->second);
    if (ids.back() == 0) unknown.insert(*key);
  }
  if (unknown.empty()) return ids;
  if (absl::Status status = AddKeys(unknown); !status.ok()) return status;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (ids[i] == 0) ids[i] = new_keys_.at(*keys[i]);
  }
  return ids;
}

absl::Status PostgresEvidence::AddKeys(const std::set<EvidenceKey>& keys) {
  const auto ignore = [](const PostgresRow&) {};
  const KeyArrays arrays(keys);
  absl::Status status = arrays.Run(connection_, kAddScenes, ignore);
  if (status.ok()) status = arrays.Run(connection_, kAddKeys, ignore);
  if (!status.ok()) return status;
  return arrays.Run(connection_, kFindKeys, [&](const PostgresRow& row) {
    const EvidenceKey key{.project = row.Text(0),
                          .scene = row.Text(1),
                          .measured_by = row.Text(2),
                          .arm = row.Text(3),
                          .backend_version = static_cast<uint32_t>(row.Integer(4)),
                          .machine_class = row.Text(5),
                          .reward_version = static_cast<uint32_t>(row.Integer(6))};
    new_keys_[key] = row.Integer(7);
  });
}

void PostgresEvidence::OnEnd(bool committed) {
  if (committed) {
    if (known_keys_.size() + new_keys_.size() > kMaxKnownKeys) known_keys_.clear();
    known_keys_.insert(new_keys_.begin(), new_keys_.end());
  }
  new_keys_.clear();
}

absl::StatusOr<RowChanges> PostgresEvidence::Load(const std::set<RowPlace>& places) {
  PostgresArray keys;
  PostgresArray sources;
  for (const auto& [key, source] : places) {
    keys.Add(key);
    sources.Add(source);
  }
  RowChanges rows;
  absl::Status status = connection_.ForEachRow(
      kLoadEvidence,
      [&](const PostgresRow& row) {
        rows[{row.Integer(0), row.Integer(1)}] = {row.Unsigned(2), UnitsOf(row, 3)};
      },
      keys, sources);
  if (!status.ok()) return status;
  return rows;
}

absl::Status PostgresEvidence::Apply(const RowChanges& changes) {
  if (changes.empty()) return absl::OkStatus();
  PostgresArray keys;
  PostgresArray sources;
  PostgresArray sequences;
  UnitArrays units;
  std::map<int64_t, KeyChange> sums;
  for (const auto& [place, change] : changes) {
    keys.Add(place.first);
    sources.Add(place.second);
    sequences.Add(change.sequence);
    units.Add(change.units);
    sums[place.first].units += change.units;
  }
  const auto changed = connection_.Change(kChangeRows, keys, sources, sequences, units.alpha,
                                          units.beta, units.window_count, units.bail_out_count);
  if (!changed.ok()) return changed.status();
  const bool any_new = *changed < changes.size();
  PostgresArray new_keys;
  PostgresArray new_sources;
  absl::Status status;
  if (any_new)
    status = connection_.ForEachRow(
        kAddEvidence,
        [&](const PostgresRow& row) {
          new_keys.Add(row.Integer(0));
          new_sources.Add(row.Integer(1));
          ++sums[row.Integer(0)].source_count;
        },
        keys, sources, sequences, units.alpha, units.beta, units.window_count,
        units.bail_out_count);
  SceneChanges scenes;
  if (status.ok()) status = AddToSums(sums, scenes);
  if (status.ok() && any_new)
    status = connection_.ForEachRow(
        kJoinScenes, [&](const PostgresRow& row) { ++scenes[row.Integer(0)]; }, new_keys,
        new_sources);
  return status.ok() ? ChangeScenes(scenes) : status;
}

absl::Status PostgresEvidence::ChangeScenes(const SceneChanges& changes) {
  PostgresArray ids;
  PostgresArray added;
  for (const auto& [id, count] : changes) {
    ids.Add(id);
    added.Add(count);
  }
  absl::Status status = connection_.Run(kLockScenes, ids);
  return status.ok() ? connection_.Run(kChangeScenes, ids, added) : status;
}

absl::Status PostgresEvidence::AddToSums(const std::map<int64_t, KeyChange>& changes,
                                         SceneChanges& scenes) {
  PostgresArray ids;
  UnitArrays units;
  PostgresArray added;
  for (const auto& [id, change] : changes) {
    ids.Add(id);
    units.Add(change.units);
    added.Add(change.source_count);
  }
  absl::Status status = connection_.Run(kLockKeys, ids);
  if (!status.ok()) return status;
  return connection_.ForEachRow(
      kAddToSums, [&](const PostgresRow& row) { scenes.try_emplace(row.Integer(0), 0); }, ids,
      units.alpha, units.beta, units.window_count, units.bail_out_count, added);
}

absl::StatusOr<RemovedEvidence> PostgresEvidence::Remove(const PostgresArray& sources,
                                                         const std::string& project) {
  RemovedEvidence removed;
  SceneChanges scenes;
  absl::Status status = connection_.ForEachRow(
      kLeaveScenes, [&](const PostgresRow& row) { --scenes[row.Integer(0)]; }, sources, project);
  if (!status.ok()) return status;
  std::map<int64_t, KeyChange> sums;
  status = connection_.ForEachRow(
      kRemoveRows,
      [&](const PostgresRow& row) {
        KeyChange& sum = sums[row.Integer(0)];
        const EvidenceUnits units = UnitsOf(row, 1);
        sum.units -= units;
        --sum.source_count;
        ++removed.record_count;
        removed.window_count += static_cast<uint64_t>(units.window_count);
      },
      sources, project);
  if (status.ok()) status = AddToSums(sums, scenes);
  if (status.ok()) status = ChangeScenes(scenes);
  if (!status.ok()) return status;
  return removed;
}

}  // namespace sweepstake::storage
