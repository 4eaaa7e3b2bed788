#include "server/storage/postgres/postgres_reader.h"

#include <algorithm>
#include <utility>

#include "engine_client/decider/pooling/source_choice.h"
#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

// The scene's classes of machines: the given one first, then the newest ones.
constexpr const char* kSceneClasses = R"sql(
    SELECT id, machine_class FROM scene
    WHERE project = $1 AND scene = $2 AND reward_version = $4::bigint AND source_count > 0
    ORDER BY machine_class = $3 DESC, id DESC LIMIT $5::bigint)sql";
// Each source is looked up by itself, because a join may read all sources.
constexpr const char* kLatestSources = R"sql(
    SELECT k.id, source_id, (SELECT token_id FROM source WHERE id = source_id)
    FROM evidence_key k
         CROSS JOIN LATERAL (SELECT source_id FROM evidence WHERE key_id = k.id
                             ORDER BY source_id DESC LIMIT $2::bigint) e
    WHERE scene_id = $1::bigint AND source_count > 0 ORDER BY k.id, source_id DESC)sql";
constexpr const char* kEvidenceOfSources = R"sql(
    SELECT s.id, s.name, s.build, s.last_seen_unix_s, k.arm, k.backend_version, k.measured_by,
           e.alpha, e.beta, e.window_count, e.bail_out_count
    FROM unnest($1::bigint[], $2::bigint[]) wanted(key_id, source_id)
         JOIN evidence e USING (key_id, source_id)
         JOIN evidence_key k ON k.id = key_id JOIN source s ON s.id = source_id)sql";
constexpr const char* kLoadSource = R"sql(
    SELECT id, commit_sequence, message_sequence, explored_arm_count, decision_count,
           frame_count, seed, created_unix_s, last_seen_unix_s,
           (SELECT coalesce(max(segment), 0) FROM audit_segment WHERE session = name)
    FROM source WHERE name = $1 AND is_session AND NOT revoked)sql";
constexpr const char* kSourceEvidence = R"sql(
    SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version,
           alpha, beta, window_count, bail_out_count
    FROM evidence JOIN evidence_key k ON k.id = key_id WHERE source_id = $1::bigint
    ORDER BY 1, 2, 3, 4, 5, 6, 7)sql";
constexpr const char* kListScenes = R"sql(
    SELECT id, source_count, project, scene, machine_class, reward_version FROM scene
    WHERE ($1 = '' OR project = $1) AND ($2 = '' OR scene = $2)
      AND (project, scene, machine_class, reward_version) > ($3, $4, $5, $6::bigint)
      AND source_count > 0 AND ($8::text[] = '{}' OR project = ANY($8::text[]))
    ORDER BY project, scene, machine_class, reward_version LIMIT $7::bigint)sql";
constexpr const char* kChangedScenes =
    "SELECT project, scene, machine_class, reward_version FROM scene WHERE changed_in >= $1::xid8";
constexpr const char* kOldestTransaction = "SELECT pg_snapshot_xmin(pg_current_snapshot())";
constexpr const char* kFindScene = R"sql(
    SELECT id, source_count FROM scene
    WHERE project = $1 AND scene = $2 AND machine_class = $3 AND reward_version = $4::bigint
      AND source_count > 0)sql";
constexpr const char* kSceneArms = R"sql(
    SELECT scene_id, arm, backend_version, measured_by, alpha_sum, beta_sum, window_sum,
           bail_out_sum,
           (SELECT coalesce(max(last_seen_unix_s), 0) FROM source WHERE id = ANY (ARRAY(
                SELECT source_id FROM evidence WHERE key_id = k.id
                ORDER BY source_id DESC LIMIT $2::bigint)))
    FROM evidence_key k WHERE scene_id = ANY($1::bigint[]) AND source_count > 0)sql";
constexpr const char* kCountScenes =
    "SELECT count(DISTINCT scene), count(*) FROM scene WHERE project = $1 AND source_count > 0";
// Jumps from one project to the next in the index, however many scenes they have.
constexpr const char* kCountProjects = R"sql(
    WITH RECURSIVE known(project) AS (
      SELECT min(project) FROM scene
      UNION ALL
      SELECT (SELECT min(s.project) FROM scene s WHERE s.project > known.project)
      FROM known WHERE known.project IS NOT NULL)
    SELECT count(*) FROM known
    WHERE EXISTS (SELECT 1 FROM scene s WHERE s.project = known.project AND source_count > 0))sql";
// The row value finds its place in the index without reading what comes before it.
constexpr const char* kNextKey = R"sql(
    SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version, id
    FROM evidence_key
    WHERE (project, scene, measured_by, arm, backend_version, machine_class, reward_version)
          >= ($3, $4, $5, $6, $7::bigint, $8, $9::bigint)
      AND ($1 = '' OR project = $1) AND ($2 = '' OR scene = $2)
      AND ($10::text[] = '{}' OR project = ANY($10::text[])) AND source_count > 0
    ORDER BY 1, 2, 3, 4, 5, 6, 7 LIMIT 1)sql";
constexpr const char* kKeyEvidence = R"sql(
    SELECT s.id, s.name, e.sequence, e.alpha, e.beta, e.window_count, e.bail_out_count, s.build,
           s.last_seen_unix_s, NOT s.is_session
    FROM evidence e JOIN source s ON s.id = e.source_id
    WHERE e.key_id = $1::bigint AND e.source_id > $2::bigint
    ORDER BY e.source_id LIMIT $3::bigint)sql";
constexpr const char* kNextQuarantinedKey = R"sql(
    SELECT project, scene, measured_by, arm, backend_version, machine_class, reward_version, id
    FROM evidence_key k
    WHERE (project, scene, measured_by, arm, backend_version, machine_class, reward_version)
          >= ($3, $4, $5, $6, $7::bigint, $8, $9::bigint)
      AND ($1 = '' OR project = $1) AND ($2 = '' OR scene = $2)
      AND ($10::text[] = '{}' OR project = ANY($10::text[]))
      AND EXISTS (SELECT 1 FROM quarantined_evidence WHERE key_id = k.id)
    ORDER BY 1, 2, 3, 4, 5, 6, 7 LIMIT 1)sql";
constexpr const char* kQuarantinedEvidence = R"sql(
    SELECT s.id, s.name, q.sequence, q.alpha, q.beta, q.window_count, q.bail_out_count, s.build,
           s.last_seen_unix_s, NOT s.is_session
    FROM quarantined_evidence q JOIN source s ON s.id = q.source_id
    WHERE q.key_id = $1::bigint AND q.source_id > $2::bigint
    ORDER BY q.source_id LIMIT $3::bigint)sql";
constexpr const char* kListSegments = R"sql(
    SELECT id, session, segment, project, scene, unix_start_ms, first, last, count
    FROM audit_segment s
         CROSS JOIN LATERAL (SELECT min(number) AS first, max(number) AS last, count(*) AS count
                             FROM audit_row WHERE segment_id = s.id) r
    WHERE id > $4::bigint AND ($1 = '' OR session = $1) AND ($2 = '' OR project = $2)
      AND ($3 = '' OR scene = $3) AND ($6::text[] = '{}' OR project = ANY($6::text[]))
    ORDER BY id LIMIT $5::bigint)sql";
constexpr const char* kLoadRows = R"sql(
    SELECT number, text FROM (
      SELECT number, text,
             sum(octet_length(text)) OVER (ORDER BY number) - octet_length(text) AS before
      FROM (SELECT number, text FROM audit_row
            WHERE segment_id = $1::bigint AND number >= $2::bigint
            ORDER BY number LIMIT $3::bigint) page) r
    WHERE before < $4::bigint ORDER BY number)sql";

EvidenceKey KeyOf(const PostgresRow& row) {
  return {.project = row.Text(0),
          .scene = row.Text(1),
          .measured_by = row.Text(2),
          .arm = row.Text(3),
          .backend_version = static_cast<uint32_t>(row.Integer(4)),
          .machine_class = row.Text(5),
          .reward_version = static_cast<uint32_t>(row.Integer(6))};
}

// Limits a sum to the maximum of a count.
uint64_t CountOf(const PostgresRow& row, int column) {
  return static_cast<uint64_t>(std::min(row.Number(column), Units(kMaxCount)));
}

Evidence EvidenceOf(const PostgresRow& row, int first) {
  return {.alpha = AmountOf(row.Number(first)),
          .beta = AmountOf(row.Number(first + 1)),
          .window_count = CountOf(row, first + 2),
          .bail_out_count = CountOf(row, first + 3)};
}

PostgresArray ArrayOf(const std::vector<std::string>& texts) {
  PostgresArray array;
  for (const std::string& text : texts) array.Add(text);
  return array;
}

}  // namespace

absl::StatusOr<std::vector<priors::SceneSource>> PostgresReader::LoadSources(
    const SceneKey& scene) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<std::pair<int64_t, SceneKey>> classes;
  absl::Status status = connection_.ForEachRow(
      kSceneClasses,
      [&](const PostgresRow& row) {
        classes.emplace_back(row.Integer(0), scene);
        classes.back().second.machine_class = row.Text(1);
      },
      scene.project, scene.scene, scene.machine_class, scene.reward_version,
      1 + priors::kOtherClasses);
  std::vector<priors::SceneSource> sources;
  for (const auto& [id, key] : classes) {
    const uint32_t limit = key == scene ? priors::kSourcesOfScene : priors::kSourcesOfOtherClass;
    if (status.ok()) status = AppendSources(id, key, limit, sources);
  }
  if (!status.ok()) return status;
  return sources;
}

absl::Status PostgresReader::AppendSources(int64_t scene_id, const SceneKey& scene, uint32_t limit,
                                           std::vector<priors::SceneSource>& sources) {
  std::map<int64_t, std::vector<int64_t>> latest, tokens;  // by key
  absl::Status status = connection_.ForEachRow(
      kLatestSources,
      [&](const PostgresRow& row) {
        latest[row.Integer(0)].push_back(row.Integer(1));
        tokens[row.Integer(0)].push_back(row.Integer(2));
      },
      scene_id, decision::kSourcesPerPlace * limit);
  if (!status.ok()) return status;
  PostgresArray keys, chosen;
  for (const auto& [key, sources_of_key] : latest) {
    for (const size_t i : decision::ChooseSources(tokens[key], limit)) {
      keys.Add(key);
      chosen.Add(sources_of_key[i]);
    }
  }
  std::map<int64_t, priors::SceneSource> by_number;
  status = connection_.ForEachRow(
      kEvidenceOfSources,
      [&](const PostgresRow& row) {
        priors::SceneSource& source = by_number[row.Integer(0)];
        source.id = row.Text(1);
        source.build = row.Text(2);
        source.last_seen_unix_s = row.Unsigned(3);
        source.evidence.ArmOf(row.Text(4), static_cast<uint32_t>(row.Integer(5))).of(row.Text(6)) =
            EvidenceOf(row, 7);
      },
      keys, chosen);
  for (auto& [number, source] : by_number) {
    source.evidence.key = scene;
    source.evidence.source_count = 1;
    sources.push_back(std::move(source));
  }
  return status;
}

absl::StatusOr<std::optional<priors::SourceState>> PostgresReader::LoadSource(
    const std::string& source_id) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  priors::SourceState state;
  int64_t id = 0;
  absl::Status status = connection_.ForEachRow(
      kLoadSource,
      [&](const PostgresRow& row) {
        id = row.Integer(0);
        state.progress = {.source_id = source_id,
                          .commit_sequence = row.Unsigned(1),
                          .message_sequence = row.Unsigned(2),
                          .explored_arm_count = static_cast<uint32_t>(row.Integer(3)),
                          .decision_count = row.Unsigned(4),
                          .frame_count = row.Unsigned(5),
                          .seed = row.Unsigned(6)};
        state.created_unix_s = row.Unsigned(7);
        state.last_seen_unix_s = row.Unsigned(8);
        state.audit_segment = static_cast<uint32_t>(row.Integer(9));
      },
      source_id);
  if (!status.ok()) return status;
  if (id == 0) return std::nullopt;
  status = connection_.ForEachRow(
      kSourceEvidence,
      [&](const PostgresRow& row) {
        state.evidence.push_back({KeyOf(row), EvidenceOf(row, 7)});
      },
      id);
  if (!status.ok()) return status;
  return state;
}

absl::Status PostgresReader::LoadArms(const std::map<int64_t, SceneEvidence*>& scenes) {
  PostgresArray ids;
  for (const auto& [id, scene] : scenes) ids.Add(id);
  return connection_.ForEachRow(
      kSceneArms,
      [&](const PostgresRow& row) {
        SceneEvidence::Arm& arm =
            scenes.at(row.Integer(0))->ArmOf(row.Text(1), static_cast<uint32_t>(row.Integer(2)));
        arm.of(row.Text(3)) += EvidenceOf(row, 4);
        arm.last_seen_unix_s = std::max(arm.last_seen_unix_s, row.Unsigned(8));
      },
      ids, priors::kSourcesOfAge);
}

absl::StatusOr<std::vector<SceneEvidence>> PostgresReader::List(
    const SceneFilter& filter, const std::optional<SceneKey>& after, uint32_t limit) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  // The start is before all wanted scenes: an empty project is before every project, and a key
  // without a reward version before those of its scene.
  const SceneKey start = after.value_or(SceneKey{filter.project, filter.scene, "", 0});
  std::vector<SceneEvidence> scenes;
  std::vector<int64_t> ids;
  absl::Status status = connection_.ForEachRow(
      kListScenes,
      [&](const PostgresRow& row) {
        ids.push_back(row.Integer(0));
        scenes.push_back(
            {.key = {row.Text(2), row.Text(3), row.Text(4), static_cast<uint32_t>(row.Integer(5))},
             .arms = {},
             .source_count = row.Unsigned(1)});
      },
      filter.project, filter.scene, start.project, start.scene, start.machine_class,
      start.reward_version, limit, ArrayOf(filter.projects));
  std::map<int64_t, SceneEvidence*> by_id;
  for (size_t i = 0; i < scenes.size(); ++i) by_id[ids[i]] = &scenes[i];
  if (status.ok()) status = LoadArms(by_id);
  if (!status.ok()) return status;
  return scenes;
}

absl::StatusOr<std::optional<SceneEvidence>> PostgresReader::LoadScene(const SceneKey& key) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  SceneEvidence scene{.key = key, .arms = {}, .source_count = 0};
  int64_t id = 0;
  absl::Status status = connection_.ForEachRow(
      kFindScene,
      [&](const PostgresRow& row) {
        id = row.Integer(0);
        scene.source_count = row.Unsigned(1);
      },
      key.project, key.scene, key.machine_class, key.reward_version);
  if (status.ok() && id == 0) return std::nullopt;
  if (status.ok()) status = LoadArms({{id, &scene}});
  if (!status.ok()) return status;
  return scene;
}

absl::StatusOr<std::vector<SceneKey>> PostgresReader::LoadChangedScenes(std::string& since) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<SceneKey> scenes;
  absl::Status status = connection_.ForEachRow(
      kChangedScenes,
      [&](const PostgresRow& row) {
        scenes.push_back(
            {row.Text(0), row.Text(1), row.Text(2), static_cast<uint32_t>(row.Integer(3))});
      },
      since);
  if (status.ok())
    status = connection_.ForEachRow(kOldestTransaction,
                                    [&](const PostgresRow& row) { since = row.Text(0); });
  if (!status.ok()) return status;
  return scenes;
}

absl::StatusOr<priors::SceneCount> PostgresReader::CountScenes(const std::string& project) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  priors::SceneCount count;
  absl::Status status = connection_.ForEachRow(
      kCountScenes,
      [&](const PostgresRow& row) {
        count = {row.Unsigned(0), row.Unsigned(1)};
      },
      project);
  if (!status.ok()) return status;
  return count;
}

absl::StatusOr<uint64_t> PostgresReader::CountProjects() {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  uint64_t count = 0;
  absl::Status status = connection_.ForEachRow(
      kCountProjects, [&](const PostgresRow& row) { count = row.Unsigned(0); });
  if (!status.ok()) return status;
  return count;
}

absl::StatusOr<PostgresReader::ExportKey> PostgresReader::NextKey(const SceneFilter& filter,
                                                                  const EvidenceKey& first,
                                                                  int64_t first_reward_version,
                                                                  bool quarantined) {
  ExportKey next;
  absl::Status status = connection_.ForEachRow(
      quarantined ? kNextQuarantinedKey : kNextKey,
      [&](const PostgresRow& row) { next = {.key = KeyOf(row), .id = row.Integer(7)}; },
      filter.project, filter.scene, first.project, first.scene, first.measured_by, first.arm,
      first.backend_version, first.machine_class, first_reward_version, ArrayOf(filter.projects));
  if (!status.ok()) return status;
  return next;
}

absl::Status PostgresReader::AppendEvidence(const ExportKey& key, uint32_t limit, bool quarantined,
                                            priors::ExportPage& page) {
  const uint64_t first = page.next.key == key.key ? page.next.source_number : 0;
  return connection_.ForEachRow(
      quarantined ? kQuarantinedEvidence : kKeyEvidence,
      [&](const PostgresRow& row) {
        page.records.push_back({key.key, row.Text(1), row.Unsigned(2), EvidenceOf(row, 3),
                                row.Text(7), row.Unsigned(8), row.Boolean(9), quarantined});
        page.next = {key.key, row.Unsigned(0)};
      },
      key.id, first, limit - page.records.size());
}

absl::StatusOr<priors::ExportPage> PostgresReader::Export(const SceneFilter& filter,
                                                          const priors::ExportPlace& after,
                                                          uint32_t limit) {
  return ExportAll(filter, after, limit, /*quarantined=*/false);
}

absl::StatusOr<priors::ExportPage> PostgresReader::ExportQuarantined(
    const SceneFilter& filter, const priors::ExportPlace& after, uint32_t limit) {
  return ExportAll(filter, after, limit, /*quarantined=*/true);
}

absl::StatusOr<priors::ExportPage> PostgresReader::ExportAll(const SceneFilter& filter,
                                                             const priors::ExportPlace& after,
                                                             uint32_t limit, bool quarantined) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  priors::ExportPage page{.records = {}, .next = after};
  EvidenceKey first = after.key;
  // Begins at the filter's project in the index.
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
    absl::Status status = AppendEvidence(*key, limit, quarantined, page);
    if (!status.ok()) return status;
    // The version comes last in the order of keys, and is a whole number.
    first = key->key;
    first_reward_version = int64_t{first.reward_version} + 1;
  }
  return page;
}

absl::StatusOr<std::vector<priors::AuditSegment>> PostgresReader::ListAudit(
    const priors::AuditFilter& filter, uint64_t after, uint32_t limit) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<priors::AuditSegment> segments;
  absl::Status status = connection_.ForEachRow(
      kListSegments,
      [&](const PostgresRow& row) {
        const uint64_t first = row.Unsigned(6);
        const uint64_t count = row.Unsigned(8);
        segments.push_back({.id = row.Unsigned(0),
                            .session_id = row.Text(1),
                            .segment = static_cast<uint32_t>(row.Integer(2)),
                            .project = row.Text(3),
                            .scene = row.Text(4),
                            .unix_start_ms = row.Integer(5),
                            .first_row = first,
                            .row_count = count,
                            .lost_row_count = row.Unsigned(7) - first + 1 - count});
      },
      filter.session_id, filter.project, filter.scene, after, limit, ArrayOf(filter.projects));
  if (!status.ok()) return status;
  return segments;
}

absl::StatusOr<std::vector<priors::AuditRow>> PostgresReader::LoadAudit(uint64_t segment_id,
                                                                        uint64_t first_row,
                                                                        uint32_t limit,
                                                                        size_t max_bytes) {
  const PostgresSnapshot snapshot(connection_);
  if (!snapshot.status().ok()) return snapshot.status();
  std::vector<priors::AuditRow> rows;
  absl::Status status = connection_.ForEachRow(
      kLoadRows,
      [&](const PostgresRow& row) {
        rows.push_back({.number = row.Unsigned(0), .text = row.Bytes(1)});
      },
      segment_id, first_row, limit, max_bytes);
  if (!status.ok()) return status;
  return rows;
}

namespace {

class PostgresReadConnection final : public ReadConnection {
 public:
  explicit PostgresReadConnection(const std::string& url) : connection_(url) {}

  // If the snapshot fails, each read returns the error.
  priors::PriorReader& Begin() override {
    snapshot_.emplace(connection_);
    return reader_;
  }
  void End() override { snapshot_.reset(); }

 private:
  PostgresConnection connection_;
  PostgresReader reader_{connection_};
  std::optional<PostgresSnapshot> snapshot_;  // present while a job reads
};

}  // namespace

std::unique_ptr<ReadConnection> OpenPostgresReadConnection(const std::string& url) {
  return std::make_unique<PostgresReadConnection>(url);
}

}  // namespace sweepstake::storage
