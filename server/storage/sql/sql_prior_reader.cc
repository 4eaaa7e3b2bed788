#include "server/storage/sql/sql_prior_reader.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "engine_client/decider/pooling/source_choice.h"
#include "engine_client/math/hash.h"

namespace sweepstake::storage {
namespace {

using priors::EvidenceKey;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

// Finds the rows of a scene, one per machine class: the given class first, then the newest of those
// with known arms, then the oldest of the others, which players have added.
constexpr const char* kSceneClasses = R"sql(
    SELECT id, machine_class, [hash = content_hash]{true} FROM scene
    WHERE project = ?1 AND scene = ?2 AND reward_version = ?4 AND source_count > 0
    ORDER BY machine_class = ?3 DESC, is_known DESC, CASE WHEN is_known THEN -id ELSE id END
    LIMIT ?5)sql";
constexpr const char* kSceneKeys = R"sql(
    SELECT scene_id, id, arm, backend_version, measured_by, regime, [hash = content_hash]{true}
    FROM evidence_key{, @given} WHERE scene_id = ?1 AND source_count > 0)sql";
// The parties of a scene that were active last, with their latest source: of all tokens, and of one
// token.
constexpr const char* kLatestParties = R"sql(
    {SELECT latest.* FROM @given CROSS JOIN LATERAL (}
    SELECT scene_id, latest_source_id, token_id, party FROM scene_party
    WHERE scene_id = ?1 ORDER BY latest_source_id DESC LIMIT ?2
    {) latest})sql";
constexpr const char* kLatestPartiesOfToken = R"sql(
    {SELECT latest.* FROM @given CROSS JOIN LATERAL (}
    SELECT scene_id, latest_source_id, token_id, party FROM scene_party
    WHERE scene_id = ?1 AND token_id = ?2 ORDER BY latest_source_id DESC LIMIT ?3
    {) latest})sql";
// Finds each next token, the newest first, by one lookup in the index.
constexpr const char* kNewestTokens = R"sql(
    WITH RECURSIVE of_scene(token_id) AS (
      SELECT max(token_id) FROM scene_party WHERE scene_id = ?1
      UNION ALL
      SELECT (SELECT max(p.token_id) FROM scene_party p
              WHERE p.scene_id = ?1 AND p.token_id < of_scene.token_id)
      FROM of_scene WHERE of_scene.token_id IS NOT NULL)
    SELECT token_id FROM of_scene WHERE token_id IS NOT NULL LIMIT ?2)sql";
constexpr const char* kStoreId = "SELECT id FROM store";
constexpr const char* kEarlierSources = R"sql(
    {SELECT earlier.* FROM @given CROSS JOIN LATERAL (}
    SELECT scene_id, source_id, token_id, party FROM scene_source
    WHERE scene_id = ?1 AND token_id = ?2 AND party = ?3 AND source_id < ?4
    ORDER BY source_id DESC LIMIT ?5
    {) earlier})sql";
// Keys of a scene were mostly added together, so most keys in this range belong to the scene.
constexpr const char* kKeysOfSources = R"sql(
    SELECT source_id, key_id FROM evidence{, @given}
    WHERE source_id = ?1 AND key_id BETWEEN ?2 AND ?3)sql";
// Rows with a wrong hash were excluded from the sums too.
constexpr const char* kEvidenceOfSources = R"sql(
    SELECT key_id, s.id, name, build, last_seen_unix_s, alpha, beta, window_count, bail_out_count
    FROM evidence e [CROSS] JOIN source s ON s.id = e.source_id{, @given}
    WHERE key_id = ?1 AND source_id = ?2 [AND e.hash = e.content_hash AND s.hash = s.content_hash]
    )sql";
constexpr const char* kLoadSource = R"sql(
    SELECT id, commit_sequence, message_sequence, explored_arm_count, decision_count,
           frame_count, seed, created_unix_s, last_seen_unix_s, [hash = content_hash]{true},
           (SELECT coalesce(max(segment), 0) FROM audit_segment WHERE session = name)
    FROM source WHERE name = ?1 AND is_session AND NOT revoked)sql";
constexpr const char* kSourceEvidence = R"sql(
    SELECT project, scene, regime, measured_by, arm, backend_version, machine_class, reward_version,
           alpha, beta, window_count, bail_out_count,
           [k.hash = k.content_hash AND e.hash = e.content_hash]{true}
    FROM evidence e JOIN evidence_key k ON k.id = key_id WHERE source_id = ?1
    ORDER BY 1, 2, 3, 4, 5, 6, 7, 8)sql";
// In SQLite the first comparison ends the index scan after the given project and scene. A name that
// is not given is replaced by an empty blob (x''), which sorts after every text.
constexpr const char* kListScenes = R"sql(
    SELECT id, source_count, project, scene, machine_class, reward_version FROM scene
    WHERE [(project, scene) <= (iif(?1 = '', x'', ?1), iif(?2 = '', x'', ?2))
      AND hash = content_hash
      AND NOT EXISTS (SELECT 1 FROM evidence_key k
                      WHERE k.scene_id = scene.id AND k.hash <> k.content_hash) AND]
      (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
      AND (project, scene, machine_class, reward_version) > (?3, ?4, ?5, ?6)
      AND source_count > 0
      AND (?8 = '' OR instr(?8, char(10) || project || char(10)) > 0)
    ORDER BY project, scene, machine_class, reward_version LIMIT ?7)sql";
constexpr const char* kFindScene = R"sql(
    SELECT id, source_count,
           [hash = content_hash
             AND NOT EXISTS (SELECT 1 FROM evidence_key k
                             WHERE k.scene_id = scene.id AND k.hash <> k.content_hash)]{true}
    FROM scene
    WHERE project = ?1 AND scene = ?2 AND machine_class = ?3 AND reward_version = ?4
      AND source_count > 0)sql";
constexpr const char* kSceneArms = R"sql(
    SELECT scene_id, arm, backend_version, measured_by, alpha_sum, beta_sum, window_sum,
           bail_out_sum, regime
    FROM evidence_key{, @given} WHERE scene_id = ?1 AND source_count > 0)sql";
constexpr const char* kSceneAges = R"sql(
    SELECT scene_id, arm, backend_version,
           (SELECT coalesce(max(last_seen_unix_s), 0)
            FROM (SELECT source_id FROM evidence WHERE key_id = k.id
                  ORDER BY source_id DESC LIMIT ?2) e
                 [CROSS] JOIN source s ON s.id = e.source_id [AND s.hash = s.content_hash])
    FROM evidence_key k{, @given} WHERE scene_id = ?1 AND source_count > 0)sql";
constexpr const char* kKnownArms = R"sql(
    SELECT DISTINCT arm, backend_version FROM evidence_key
    WHERE project = ?1 AND scene = ?2 AND is_known)sql";
constexpr const char* kCountScenes =
    "SELECT count(DISTINCT scene), count(*) FROM scene WHERE project = ?1 AND source_count > 0";
// Finds each next project by one lookup in the index, so that the cost does not depend on the
// number of scenes of a project.
constexpr const char* kCountProjects = R"sql(
    WITH RECURSIVE known(project) AS (
      SELECT min(project) FROM scene
      UNION ALL
      SELECT (SELECT min(s.project) FROM scene s WHERE s.project > known.project)
      FROM known WHERE known.project IS NOT NULL)
    SELECT count(*) FROM known
    WHERE EXISTS (SELECT 1 FROM scene s WHERE s.project = known.project AND source_count > 0))sql";
// Comparing row values lets the database begin in the index at the given key, without reading the
// keys before it.
constexpr const char* kNextKey = R"sql(
    SELECT project, scene, regime, measured_by, arm, backend_version, machine_class, reward_version,
           id, [hash = content_hash]{true}
    FROM evidence_key
    WHERE (project, scene, regime, measured_by, arm, backend_version, machine_class, reward_version)
          >= (?3, ?4, ?11, ?5, ?6, ?7, ?8, ?9)
      AND (?1 = '' OR project = ?1) AND (?2 = '' OR scene = ?2)
      AND (?10 = '' OR instr(?10, char(10) || project || char(10)) > 0)
      AND EXISTS (SELECT 1 FROM TABLE WHERE key_id = id)
    ORDER BY 1, 2, 3, 4, 5, 6, 7, 8 LIMIT 1)sql";
constexpr const char* kKeyEvidence = R"sql(
    SELECT s.id, name, sequence, alpha, beta, window_count, bail_out_count,
           [e.hash = e.content_hash AND s.hash = s.content_hash]{true},
           build, last_seen_unix_s, is_session
    FROM TABLE e [CROSS] JOIN source s ON s.id = source_id
    WHERE key_id = ?1 AND source_id > ?2
    ORDER BY source_id LIMIT ?3)sql";
constexpr const char* kListSegments = R"sql(
    SELECT s.id, session, segment, project, scene, unix_start_ms,
           (SELECT min(number) FROM audit_row WHERE segment_id = s.id),
           (SELECT max(number) FROM audit_row WHERE segment_id = s.id),
           (SELECT count(*) FROM audit_row WHERE segment_id = s.id),
           coalesce(token_id, 0), coalesce(CASE WHEN player = '' THEN network ELSE player END, '')
    FROM audit_segment s LEFT JOIN source o ON o.name = session
    WHERE s.id > ?4 AND (?1 = '' OR session = ?1) AND (?2 = '' OR project = ?2)
      AND (?3 = '' OR scene = ?3)
      AND (?6 = '' OR instr(?6, char(10) || project || char(10)) > 0)
    ORDER BY s.id LIMIT ?5)sql";
constexpr const char* kLoadRows = R"sql(
    SELECT number, bytes FROM (
      SELECT number, bytes,
             sum(octet_length(bytes)) OVER (ORDER BY number) - octet_length(bytes) AS before
      FROM (SELECT number, bytes FROM audit_row
            WHERE segment_id = ?1 AND number >= ?2 ORDER BY number LIMIT ?3) page) r
    WHERE before < ?4 ORDER BY number)sql";
// The first and the last id, and the number, of the rows that a scan examines. With this range,
// which needs no content of rows, a scan has a bounded cost however few rows match.
constexpr const char* kNewerRange = R"sql(
    SELECT coalesce(min(id), 0), coalesce(max(id), 0), count(*)
    FROM (SELECT id FROM audit_row WHERE id > ?1 ORDER BY id LIMIT ?2) examined)sql";
constexpr const char* kOlderRange = R"sql(
    SELECT coalesce(max(id), 0), coalesce(min(id), 0), count(*)
    FROM (SELECT id FROM audit_row WHERE id < ?1 ORDER BY id DESC LIMIT ?2) examined)sql";
// The rows with ids from ?1 to ?2. The word DIRECTION is replaced by that of the order.
constexpr const char* kScanRows = R"sql(
    SELECT r.id, segment_id, number, bytes
    FROM audit_row r [CROSS] JOIN audit_segment s ON s.id = segment_id
    WHERE r.id BETWEEN ?1 AND ?2 AND (?3 = '' OR session = ?3) AND (?4 = '' OR project = ?4)
      AND (?5 = '' OR scene = ?5)
      AND (?6 = '' OR instr(?6, char(10) || project || char(10)) > 0)
    ORDER BY r.id DIRECTION LIMIT ?7)sql";
constexpr const char* kChangedScenes = R"sql({
    SELECT project, scene, machine_class, reward_version FROM scene WHERE changed_in >= ?1::xid8
    })sql";
constexpr const char* kOldestTransaction = "{SELECT pg_snapshot_xmin(pg_current_snapshot())}";

// Tokens of a scene whose parties are candidates in any case.
constexpr uint32_t kMaxTokensOfScene = 64;

struct ScanRange {
  uint64_t first_id = 0;
  uint64_t last_id = 0;
  uint64_t row_count = 0;
};

std::string Directed(const char* direction) {
  return absl::StrReplaceAll(kScanRows, {{"DIRECTION", direction}});
}

EvidenceKey KeyOf(const SqlRow& row) {
  return {.project = row.Text(0),
          .scene = row.Text(1),
          .measured_by = row.Text(3),
          .arm = row.Text(4),
          .backend_version = row.Small(5),
          .machine_class = row.Text(6),
          .reward_version = row.Small(7),
          .regime = row.Text(2)};
}

absl::Status Damaged(absl::string_view what) {
  return absl::DataLossError(
      absl::StrCat("a row of ", what, " was changed on the disk: its hash does not match"));
}

absl::Status DamagedScene(absl::string_view project, absl::string_view scene) {
  return Damaged(absl::StrCat("scene ", scene, " of project ", project));
}

}  // namespace

EvidenceStatements ForBothTables(const char* sql) {
  return {absl::StrReplaceAll(sql, {{"TABLE", "evidence"}}),
          absl::StrReplaceAll(sql, {{"TABLE", "quarantined_evidence"}})};
}

priors::Evidence EvidenceOf(const SqlRow& row, int first) {
  return {.alpha = row.Amount(first),
          .beta = row.Amount(first + 1),
          .window_count = row.Count(first + 2),
          .bail_out_count = row.Count(first + 3)};
}

absl::StatusOr<std::vector<priors::SceneSource>> SqlPriorReader::LoadSources(
    const SceneKey& scene) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<SceneKey> classes;
  std::map<int64_t, size_t> class_of;  // place in `classes` by the id of the scene
  std::map<int64_t, uint32_t> limits;  // the number of sources to load, by the id of the scene
  SqlBatch ids;
  bool whole = true;
  absl::Status status = database_.ForEachRow(
      kSceneClasses,
      [&](const SqlRow& row) {
        class_of[row.Integer(0)] = classes.size();
        ids.Add(row.Integer(0));
        classes.push_back(scene);
        classes.back().machine_class = row.Text(1);
        limits[row.Integer(0)] = classes.back() == scene
                                     ? priors::kSourcesOfScene
                                     : priors::kSourcesOfOtherClasses / priors::kOtherClasses;
        whole = whole && row.Boolean(2);
      },
      scene.project, scene.scene, scene.machine_class, scene.reward_version,
      1 + priors::kOtherClasses);
  if (!status.ok()) return status;
  ArmKeys keys;
  status = database_.ForEachRow(
      kSceneKeys,
      [&](const SqlRow& row) {
        keys[row.Integer(1)] = {.class_number = class_of.at(row.Integer(0)),
                                .scene_id = row.Integer(0),
                                .arm = row.Text(2),
                                .backend_version = row.Small(3),
                                .measured_by = row.Text(4),
                                .regime = row.Text(5)};
        whole = whole && row.Boolean(6);
      },
      ids);
  if (status.ok() && !whole) return DamagedScene(scene.project, scene.scene);
  SqlBatch chosen;
  if (status.ok()) status = ChooseSources(limits, keys, chosen);
  if (!status.ok()) return status;
  // By class number and source id.
  std::map<std::pair<size_t, int64_t>, priors::SceneSource> sources;
  status = database_.ForEachRow(
      kEvidenceOfSources,
      [&](const SqlRow& row) {
        const ArmKey& key = keys.at(row.Integer(0));
        priors::SceneSource& source = sources[{key.class_number, row.Integer(1)}];
        source.id = row.Text(2);
        source.build = row.Text(3);
        source.last_seen_unix_s = row.Unsigned(4);
        source.evidence.key = classes[key.class_number];
        source.evidence.source_count = 1;
        source.evidence.ArmOf(key.arm, key.backend_version)
            .Add(key.regime, key.measured_by, EvidenceOf(row, 5));
      },
      chosen);
  if (!status.ok()) return status;
  std::vector<priors::SceneSource> list;
  for (auto& [place, source] : sources) list.push_back(std::move(source));
  return list;
}

absl::Status SqlPriorReader::AddPartiesOfTokens(const std::map<int64_t, uint32_t>& limits,
                                                const SqlDatabase::OnRow& add) {
  SqlBatch tokens;
  for (const auto& [scene, limit] : limits) {
    absl::Status status = database_.ForEachRow(
        kNewestTokens,
        [&, scene = scene](const SqlRow& row) {
          tokens.Add(scene, row.Integer(0), decision::kSourcesPerPlace);
        },
        scene, kMaxTokensOfScene);
    if (!status.ok()) return status;
  }
  return database_.ForEachRow(kLatestPartiesOfToken, add, tokens);
}

absl::StatusOr<SqlPriorReader::Candidates> SqlPriorReader::LoadCandidates(
    const std::map<int64_t, uint32_t>& limits) {
  SqlBatch scenes;
  for (const auto& [scene, limit] : limits) scenes.Add(scene, decision::kSourcesPerPlace * limit);
  Candidates candidates;
  const auto add = [&](const SqlRow& row) {
    candidates[row.Integer(0)].push_back({row.Integer(1), row.Integer(2), row.Text(3)});
  };
  absl::Status status = database_.ForEachRow(kLatestParties, add, scenes);
  // Many parties of one token must not displace the other tokens.
  if (status.ok()) status = AddPartiesOfTokens(limits, add);
  if (!status.ok()) return status;
  for (auto& [scene, of_scene] : candidates) {
    std::sort(of_scene.begin(), of_scene.end(), IsLater);
    of_scene.erase(std::unique(of_scene.begin(), of_scene.end(), IsSame), of_scene.end());
  }
  const Candidates parties = candidates;
  SqlBatch earlier;
  for (const auto& [scene, of_scene] : parties) {
    const size_t per_party = decision::kSourcesPerPlace * limits.at(scene) / of_scene.size();
    if (per_party < 2) continue;
    for (const Candidate& party : of_scene)
      earlier.Add(scene, party.token_id, party.party, party.source_id, per_party - 1);
  }
  status = database_.ForEachRow(kEarlierSources, add, earlier);
  if (!status.ok()) return status;
  return candidates;
}

std::set<std::pair<int64_t, int64_t>> SqlPriorReader::SourcesOfOtherClasses(
    const std::map<int64_t, uint32_t>& limits, const ArmKeys& keys, const SourcesOfKeys& sources,
    const Owners& owners, uint64_t seed) {
  std::set<std::pair<int64_t, int64_t>, std::greater<>> with_evidence;  // source, scene
  for (const auto& [id, of_key] : sources) {
    const auto key = keys.find(id);
    if (key == keys.end()) continue;
    const int64_t scene = key->second.scene_id;
    if (limits.at(scene) == priors::kSourcesOfScene) continue;
    for (const int64_t source : of_key) {
      if (owners.contains({scene, source})) with_evidence.emplace(source, scene);
    }
  }
  const std::vector<std::pair<int64_t, int64_t>> candidates(with_evidence.begin(),
                                                            with_evidence.end());
  std::vector<decision::SourceOwner> owners_of_candidates;
  for (const auto& [source, scene] : candidates)
    owners_of_candidates.push_back(owners.at({scene, source}));
  std::set<std::pair<int64_t, int64_t>> chosen;
  for (const size_t i :
       decision::ChooseSources(owners_of_candidates, priors::kSourcesOfOtherClasses, seed))
    chosen.emplace(candidates[i].second, candidates[i].first);
  return chosen;
}

absl::Status SqlPriorReader::ChooseSources(const std::map<int64_t, uint32_t>& limits,
                                           const ArmKeys& keys, SqlBatch& chosen) {
  const auto candidates = LoadCandidates(limits);
  if (!candidates.ok()) return candidates.status();
  std::map<int64_t, std::pair<int64_t, int64_t>> key_ranges;  // by the id of the scene
  for (const auto& [id, key] : keys) {
    auto& [first, last] = key_ranges.try_emplace(key.scene_id, id, id).first->second;
    first = std::min(first, id);
    last = std::max(last, id);
  }
  const auto store_id = database_.ReadText(kStoreId);
  if (!store_id.ok()) return store_id.status();
  const uint64_t seed = math::Fnv1a(math::kFnv1aStart, *store_id);  // clients do not know the id
  SqlBatch ranges;
  Owners owners;
  for (const auto& [scene, of_scene] : *candidates) {
    const auto range = key_ranges.find(scene);
    if (range == key_ranges.end()) continue;
    for (const Candidate& candidate : of_scene) {
      ranges.Add(candidate.source_id, range->second.first, range->second.second);
      owners[{scene, candidate.source_id}] = {candidate.token_id, candidate.party};
    }
  }
  SourcesOfKeys sources;
  absl::Status status = database_.ForEachRow(
      kKeysOfSources, [&](const SqlRow& row) { sources[row.Integer(1)].push_back(row.Integer(0)); },
      ranges);
  if (!status.ok()) return status;
  const auto of_others = SourcesOfOtherClasses(limits, keys, sources, owners, seed);
  for (const auto& [id, key] : keys) {
    // A source with evidence of several scenes can be a candidate for some of them only, and its
    // keys can be in several ranges.
    std::vector<int64_t>& of_key = sources[id];
    const int64_t scene = key.scene_id;
    const bool is_other = limits.at(scene) != priors::kSourcesOfScene;
    std::erase_if(of_key, [&](int64_t source) {
      return is_other ? !of_others.contains({scene, source}) : !owners.contains({scene, source});
    });
    std::sort(of_key.begin(), of_key.end(), std::greater<>());
    of_key.erase(std::unique(of_key.begin(), of_key.end()), of_key.end());
    std::vector<decision::SourceOwner> owners_of_key;
    for (const int64_t source : of_key) owners_of_key.push_back(owners.at({scene, source}));
    // The sources of other classes have been chosen already.
    static_assert(priors::kSourcesOfOtherClasses <= priors::kSourcesOfScene);
    for (const size_t i : decision::ChooseSources(owners_of_key, priors::kSourcesOfScene, seed))
      chosen.Add(id, of_key[i]);
  }
  return status;
}

absl::StatusOr<std::set<std::pair<std::string, uint32_t>>> SqlPriorReader::LoadKnownArms(
    const std::string& project, const std::string& scene) {
  return database_.Collect<std::set<std::pair<std::string, uint32_t>>>(
      kKnownArms, [](const SqlRow& row, auto& arms) { arms.emplace(row.Text(0), row.Small(1)); },
      project, scene);
}

absl::StatusOr<std::optional<priors::SourceState>> SqlPriorReader::LoadSource(
    const std::string& source_id) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  priors::SourceState state;
  int64_t id = 0;
  bool whole = true;
  absl::Status status = database_.ForEachRow(
      kLoadSource,
      [&](const SqlRow& row) {
        id = row.Integer(0);
        state.progress = {.source_id = source_id,
                          .commit_sequence = row.Unsigned(1),
                          .message_sequence = row.Unsigned(2),
                          .explored_arm_count = row.Small(3),
                          .decision_count = row.Unsigned(4),
                          .frame_count = row.Unsigned(5),
                          .seed = row.Unsigned(6)};
        state.created_unix_s = row.Unsigned(7);
        state.last_seen_unix_s = row.Unsigned(8);
        whole = row.Boolean(9);
        state.audit_segment = row.Small(10);
      },
      source_id);
  if (!status.ok()) return status;
  if (id == 0) return std::nullopt;
  status = database_.ForEachRow(
      kSourceEvidence,
      [&](const SqlRow& row) {
        state.evidence.push_back({KeyOf(row), EvidenceOf(row, 8)});
        whole = whole && row.Boolean(12);
      },
      id);
  if (!status.ok()) return status;
  if (!whole) return Damaged(absl::StrCat("source ", source_id));
  return state;
}

absl::Status SqlPriorReader::LoadArms(const std::map<int64_t, SceneEvidence*>& scenes) {
  SqlBatch ids, ages;
  for (const auto& [id, scene] : scenes) {
    ids.Add(id);
    ages.Add(id, priors::kSourcesOfAge);
  }
  const auto arm_of = [&](const SqlRow& row) -> SceneEvidence::Arm& {
    return scenes.at(row.Integer(0))->ArmOf(row.Text(1), row.Small(2));
  };
  absl::Status status = database_.ForEachRow(
      kSceneArms,
      [&](const SqlRow& row) { arm_of(row).Add(row.Text(8), row.Text(3), EvidenceOf(row, 4)); },
      ids);
  if (!status.ok()) return status;
  // Ignores errors here: if only the sources are unreadable, the sums are still right, and the
  // times stay 0 (unknown).
  database_
      .ForEachRow(
          kSceneAges,
          [&](const SqlRow& row) {
            SceneEvidence::Arm& arm = arm_of(row);
            arm.last_seen_unix_s = std::max(arm.last_seen_unix_s, row.Unsigned(3));
          },
          ages)
      .IgnoreError();
  return status;
}

absl::StatusOr<std::vector<SceneEvidence>> SqlPriorReader::List(
    const SceneFilter& filter, const std::optional<SceneKey>& after, uint32_t limit) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  // Without `after`, starts before all scenes of the filter: an empty name sorts before every name,
  // and reward version 0 before every version.
  const SceneKey start = after.value_or(SceneKey{filter.project, filter.scene, "", 0});
  std::vector<SceneEvidence> scenes;
  std::vector<int64_t> ids;
  absl::Status status = database_.ForEachRow(
      kListScenes,
      [&](const SqlRow& row) {
        ids.push_back(row.Integer(0));
        scenes.push_back({.key = {row.Text(2), row.Text(3), row.Text(4), row.Small(5)},
                          .arms = {},
                          .source_count = row.Unsigned(1)});
      },
      filter.project, filter.scene, start.project, start.scene, start.machine_class,
      start.reward_version, limit, LineList(filter.projects));
  std::map<int64_t, SceneEvidence*> by_id;
  for (size_t i = 0; i < scenes.size(); ++i) by_id[ids[i]] = &scenes[i];
  if (status.ok()) status = LoadArms(by_id);
  if (!status.ok()) return status;
  return scenes;
}

absl::StatusOr<std::optional<SceneEvidence>> SqlPriorReader::LoadScene(const SceneKey& key) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  SceneEvidence scene{.key = key, .arms = {}, .source_count = 0};
  int64_t id = 0;
  bool whole = true;
  absl::Status status = database_.ForEachRow(
      kFindScene,
      [&](const SqlRow& row) {
        id = row.Integer(0);
        scene.source_count = row.Unsigned(1);
        whole = row.Boolean(2);
      },
      key.project, key.scene, key.machine_class, key.reward_version);
  if (status.ok() && id == 0) return std::nullopt;
  if (!whole) return DamagedScene(key.project, key.scene);
  if (status.ok()) status = LoadArms({{id, &scene}});
  if (!status.ok()) return status;
  return scene;
}

absl::StatusOr<std::vector<SceneKey>> SqlPriorReader::LoadChangedScenes(std::string& since) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<SceneKey> scenes;
  absl::Status status = database_.ForEachRow(
      kChangedScenes,
      [&](const SqlRow& row) {
        scenes.push_back({row.Text(0), row.Text(1), row.Text(2), row.Small(3)});
      },
      since);
  if (status.ok())
    status =
        database_.ForEachRow(kOldestTransaction, [&](const SqlRow& row) { since = row.Text(0); });
  if (!status.ok()) return status;
  return scenes;
}

absl::StatusOr<priors::SceneCount> SqlPriorReader::CountScenes(const std::string& project) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  return database_.Collect<priors::SceneCount>(
      kCountScenes,
      [](const SqlRow& row, priors::SceneCount& count) {
        count = {row.Unsigned(0), row.Unsigned(1)};
      },
      project);
}

absl::StatusOr<uint64_t> SqlPriorReader::CountProjects() {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  return database_.ReadInteger(kCountProjects);
}

absl::StatusOr<SqlPriorReader::ExportKey> SqlPriorReader::NextKey(const SceneFilter& filter,
                                                                  const EvidenceKey& first,
                                                                  int64_t first_reward_version,
                                                                  bool quarantined) {
  static const auto& statements = *new EvidenceStatements(ForBothTables(kNextKey));
  return database_.Collect<ExportKey>(
      statements[quarantined ? 1 : 0].c_str(),
      [](const SqlRow& row, ExportKey& next) {
        next = {.key = KeyOf(row), .id = row.Integer(8), .damaged = !row.Boolean(9)};
      },
      filter.project, filter.scene, first.project, first.scene, first.measured_by, first.arm,
      first.backend_version, first.machine_class, first_reward_version, LineList(filter.projects),
      first.regime);
}

absl::Status SqlPriorReader::AppendEvidence(const ExportKey& key, uint32_t limit, bool quarantined,
                                            priors::ExportPage& page) {
  static const auto& statements = *new EvidenceStatements(ForBothTables(kKeyEvidence));
  const uint64_t first = page.next.key == key.key ? page.next.source_number : 0;
  bool damaged = key.damaged;
  absl::Status status = database_.ForEachRow(
      statements[quarantined ? 1 : 0].c_str(),
      [&](const SqlRow& row) {
        damaged = damaged || !row.Boolean(7);
        page.records.push_back({key.key, row.Text(1), row.Unsigned(2), EvidenceOf(row, 3),
                                row.Text(8), row.Unsigned(9), !row.Boolean(10), quarantined});
        page.next = {key.key, row.Unsigned(0)};
      },
      key.id, first, limit - page.records.size());
  return status.ok() && damaged ? DamagedScene(key.key.project, key.key.scene) : status;
}

absl::StatusOr<priors::ExportPage> SqlPriorReader::ExportAll(const SceneFilter& filter,
                                                             const priors::ExportPlace& after,
                                                             uint32_t limit, bool quarantined) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  priors::ExportPage page{.records = {}, .next = after};
  EvidenceKey first = after.key;
  // Skips the projects that sort before the project in the filter.
  if (first.project < filter.project) {
    first = EvidenceKey{};
    first.project = filter.project;
    first.scene = filter.scene;
  }
  int64_t first_reward_version = first.reward_version;
  while (page.records.size() < limit) {
    const auto key = NextKey(filter, first, first_reward_version, quarantined);
    if (!key.ok()) return key.status();
    if (key->id == 0) break;
    if (absl::Status status = AppendEvidence(*key, limit, quarantined, page); !status.ok())
      return status;
    // The reward version is the last part of the order of keys. The next key is therefore the first
    // key from this one on with the reward version + 1.
    first = key->key;
    first_reward_version = int64_t{first.reward_version} + 1;
  }
  return page;
}

absl::StatusOr<std::vector<priors::AuditSegment>> SqlPriorReader::ListAudit(
    const priors::AuditFilter& filter, uint64_t after, uint32_t limit) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  return database_.Collect<std::vector<priors::AuditSegment>>(
      kListSegments,
      [](const SqlRow& row, auto& segments) {
        const uint64_t first = row.Unsigned(6);
        const uint64_t count = row.Unsigned(8);
        segments.push_back({.id = row.Unsigned(0),
                            .session_id = row.Text(1),
                            .segment = row.Small(2),
                            .project = row.Text(3),
                            .scene = row.Text(4),
                            .unix_start_ms = row.Integer(5),
                            .first_row = first,
                            .row_count = count,
                            .lost_row_count = row.Unsigned(7) - first + 1 - count,
                            .token_id = row.Integer(9),
                            .party = row.Text(10)});
      },
      filter.session_id, filter.project, filter.scene, after, limit, LineList(filter.projects));
}

absl::StatusOr<std::vector<priors::StoredAuditRow>> SqlPriorReader::LoadAudit(uint64_t segment_id,
                                                                              uint64_t first_row,
                                                                              uint32_t limit,
                                                                              size_t max_bytes) {
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  return database_.Collect<std::vector<priors::StoredAuditRow>>(
      kLoadRows,
      [](const SqlRow& row, auto& rows) {
        rows.push_back({.number = row.Unsigned(0), .bytes = row.Bytes(1)});
      },
      segment_id, first_row, limit, max_bytes);
}

absl::StatusOr<priors::AuditScan> SqlPriorReader::ScanAudit(const priors::AuditFilter& filter,
                                                            priors::AuditOrder order,
                                                            uint64_t start, uint32_t limit) {
  static const auto& newer = *new std::string(Directed("ASC"));
  static const auto& older = *new std::string(Directed("DESC"));
  const bool is_newer = order == priors::AuditOrder::kOldestFirst;
  const SqlSnapshot snapshot(database_);
  if (!snapshot.status().ok()) return snapshot.status();
  constexpr auto kEnd = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
  priors::AuditScan scan{.rows = {}, .first_id = start, .last_id = start, .at_end = true};
  if (!is_newer && start == 0) start = kEnd;
  const auto range = database_.Collect<ScanRange>(
      is_newer ? kNewerRange : kOlderRange,
      [](const SqlRow& row, ScanRange& found) {
        found = {
            .first_id = row.Unsigned(0), .last_id = row.Unsigned(1), .row_count = row.Unsigned(2)};
      },
      start, priors::kAuditScanRows);
  if (!range.ok()) return range.status();
  if (range->row_count == 0) return scan;
  auto rows = database_.Collect<std::vector<priors::PlacedAuditRow>>(
      (is_newer ? newer : older).c_str(),
      [](const SqlRow& row, auto& placed) {
        placed.push_back({.id = row.Unsigned(0),
                          .segment_id = row.Unsigned(1),
                          .row = {.number = row.Unsigned(2), .bytes = row.Bytes(3)}});
      },
      is_newer ? start + 1 : range->last_id, is_newer ? range->last_id : start - 1,
      filter.session_id, filter.project, filter.scene, LineList(filter.projects), limit);
  if (!rows.ok()) return rows.status();
  scan.rows = *std::move(rows);
  scan.first_id = range->first_id;
  const bool is_cut = scan.rows.size() == limit;
  scan.last_id = is_cut ? scan.rows.back().id : range->last_id;
  scan.at_end = range->row_count < priors::kAuditScanRows && scan.last_id == range->last_id;
  return scan;
}

namespace {

class SqlReadConnection final : public ReadConnection {
 public:
  explicit SqlReadConnection(std::unique_ptr<SqlDatabase> database)
      : database_(std::move(database)), reader_(*database_) {}

  priors::PriorReader& Begin() override {
    snapshot_.emplace(*database_);
    return reader_;
  }
  void End() override { snapshot_.reset(); }

 private:
  const std::unique_ptr<SqlDatabase> database_;
  SqlPriorReader reader_;
  std::optional<SqlSnapshot> snapshot_;  // present while a job reads
};

}  // namespace

std::unique_ptr<ReadConnection> MakeReadConnection(std::unique_ptr<SqlDatabase> database) {
  return std::make_unique<SqlReadConnection>(std::move(database));
}

}  // namespace sweepstake::storage
