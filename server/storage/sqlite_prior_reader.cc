#include "server/storage/sqlite_prior_reader.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/pooling/source_choice.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::SceneEvidence;
using priors::SceneFilter;
using priors::SceneKey;

EvidenceKey KeyOf(const SqliteRow& row) {
  return {.project = row.Text(0),
          .scene = row.Text(1),
          .measured_by = row.Text(2),
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

absl::Status Damaged(absl::string_view what) {
  return absl::DataLossError(
      absl::StrCat("a row of ", what, " is not what was written: it was changed on the disk"));
}

absl::Status DamagedScene(absl::string_view project, absl::string_view scene) {
  return Damaged(absl::StrCat("scene ", scene, " of project ", project));
}

}  // namespace

absl::StatusOr<SqlitePriorReader> SqlitePriorReader::Prepare(SqliteDatabase& database) {
  auto statements = PriorReadStatements::Prepare(database);
  if (!statements.ok()) return statements.status();
  auto audit = SqliteAuditReader::Open(database);
  if (!audit.ok()) return audit.status();
  return SqlitePriorReader(*std::move(statements), *std::move(audit));
}

absl::StatusOr<StoredKey> SqlitePriorReader::FindKey(const EvidenceKey& key) {
  StoredKey stored;
  absl::Status status = statements_.find_key.ForEachRow(
      [&](const SqliteRow& row) { stored = {.id = row.Integer(0), .scene_id = row.Integer(1)}; },
      key.project, key.scene, key.measured_by, key.arm, key.backend_version, key.machine_class,
      key.reward_version);
  if (!status.ok()) return status;
  return stored;
}

absl::StatusOr<std::vector<priors::SceneSource>> SqlitePriorReader::LoadSources(
    const SceneKey& scene) {
  std::vector<std::pair<int64_t, SceneKey>> classes;
  bool whole = true;
  absl::Status status = statements_.scene_classes.ForEachRow(
      [&](const SqliteRow& row) {
        classes.emplace_back(row.Integer(0), scene);
        classes.back().second.machine_class = row.Text(1);
        whole = whole && row.Integer(2) != 0;
      },
      scene.project, scene.scene, scene.machine_class, scene.reward_version,
      1 + priors::kOtherClasses);
  if (!whole) return DamagedScene(scene.project, scene.scene);
  std::vector<priors::SceneSource> sources;
  for (const auto& [id, key] : classes) {
    const uint32_t limit = key == scene ? priors::kSourcesOfScene : priors::kSourcesOfOtherClass;
    if (status.ok()) status = AppendSources(id, key, limit, sources);
  }
  if (!status.ok()) return status;
  return sources;
}

absl::StatusOr<SqlitePriorReader::SourceNumbers> SqlitePriorReader::ChooseSources(
    int64_t key_id, uint32_t limit, std::map<SourceNumbers, SourceNumbers>& known) {
  SourceNumbers latest;
  absl::Status status = statements_.latest_sources.ForEachRow(
      [&](const SqliteRow& row) { latest.push_back(row.Integer(0)); }, key_id,
      decision::kSourcesPerPlace * limit);
  const auto found = known.find(latest);
  if (status.ok() && found != known.end()) return found->second;
  std::vector<int64_t> tokens;
  for (const int64_t source : latest) {
    if (!status.ok()) return status;
    int64_t& token = tokens.emplace_back();
    status = statements_.token_of_source.ForEachRow(
        [&](const SqliteRow& row) { token = row.Integer(0); }, source);
  }
  if (!status.ok()) return status;
  SourceNumbers chosen;
  for (const size_t i : decision::ChooseSources(tokens, limit)) chosen.push_back(latest[i]);
  known[latest] = chosen;
  return chosen;
}

absl::Status SqlitePriorReader::AppendSources(int64_t scene_id, const SceneKey& scene,
                                              uint32_t limit,
                                              std::vector<priors::SceneSource>& sources) {
  std::vector<std::pair<int64_t, EvidenceKey>> keys;
  bool whole = true;
  absl::Status status = statements_.scene_keys.ForEachRow(
      [&](const SqliteRow& row) {
        EvidenceKey& key = keys.emplace_back(row.Integer(0), EvidenceKey()).second;
        key.arm = row.Text(1);
        key.backend_version = static_cast<uint32_t>(row.Integer(2));
        key.measured_by = row.Text(3);
        whole = whole && row.Integer(4) != 0;
      },
      scene_id);
  std::map<int64_t, priors::SceneSource> by_number;
  std::map<SourceNumbers, SourceNumbers> known;
  for (const auto& [id, key] : keys) {
    if (!status.ok()) return status;
    const auto chosen = ChooseSources(id, limit, known);
    if (!chosen.ok()) return chosen.status();
    for (const int64_t number : *chosen) {
      if (!status.ok()) return status;
      // Rows with a wrong hash were excluded from the sums too.
      status = statements_.evidence_of_source.ForEachRow(
          [&, key = key](const SqliteRow& row) {
            priors::SceneSource& source = by_number[number];
            source.id = row.Text(0);
            source.build = row.Text(1);
            source.last_seen_unix_s = row.Unsigned(2);
            source.evidence.ArmOf(key.arm, key.backend_version).of(key.measured_by) =
                EvidenceOf(row, 3);
          },
          id, number);
    }
  }
  if (status.ok() && !whole) return DamagedScene(scene.project, scene.scene);
  for (auto& [number, source] : by_number) {
    source.evidence.key = scene;
    source.evidence.source_count = 1;
    sources.push_back(std::move(source));
  }
  return status;
}

absl::StatusOr<std::optional<priors::SourceState>> SqlitePriorReader::LoadSource(
    const std::string& source_id) {
  priors::SourceState state;
  int64_t id = 0;
  bool whole = true;
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
        state.created_unix_s = row.Unsigned(7);
        state.last_seen_unix_s = row.Unsigned(8);
        whole = row.Integer(9) != 0;
      },
      source_id);
  if (!status.ok()) return status;
  if (id == 0) return std::nullopt;
  status = statements_.source_evidence.ForEachRow(
      [&](const SqliteRow& row) {
        state.evidence.push_back({KeyOf(row), EvidenceOf(row, 7)});
        whole = whole && row.Integer(11) != 0;
      },
      id);
  if (!status.ok()) return status;
  if (!whole) return Damaged(absl::StrCat("source ", source_id));
  const auto segment = audit_.LastSegment(source_id);
  if (!segment.ok()) return segment.status();
  state.audit_segment = *segment;
  return state;
}

absl::Status SqlitePriorReader::LoadArms(int64_t scene_id, SceneEvidence& scene) {
  const auto arm_of = [&](const SqliteRow& row) -> SceneEvidence::Arm& {
    return scene.ArmOf(row.Text(0), static_cast<uint32_t>(row.Integer(1)));
  };
  absl::Status status = statements_.scene_arms.ForEachRow(
      [&](const SqliteRow& row) { arm_of(row).of(row.Text(2)) += EvidenceOf(row, 3); }, scene_id);
  if (!status.ok()) return status;
  // If only the sources are unreadable, the sums are returned and the times are unknown.
  statements_.scene_ages
      .ForEachRow(
          [&](const SqliteRow& row) {
            SceneEvidence::Arm& arm = arm_of(row);
            arm.last_seen_unix_s = std::max(arm.last_seen_unix_s, row.Unsigned(2));
          },
          scene_id, priors::kSourcesOfAge)
      .IgnoreError();
  return status;
}

absl::StatusOr<std::vector<SceneEvidence>> SqlitePriorReader::List(
    const SceneFilter& filter, const std::optional<SceneKey>& after, uint32_t limit) {
  // The start is before all wanted scenes: an empty project is before every project, and a key
  // without a reward version before those of its scene.
  const SceneKey start = after.value_or(SceneKey{filter.project, filter.scene, "", 0});
  std::vector<SceneEvidence> scenes;
  std::vector<int64_t> ids;
  absl::Status status = statements_.list_scenes.ForEachRow(
      [&](const SqliteRow& row) {
        ids.push_back(row.Integer(0));
        scenes.push_back(
            {.key = {row.Text(2), row.Text(3), row.Text(4), static_cast<uint32_t>(row.Integer(5))},
             .arms = {},
             .source_count = row.Unsigned(1)});
      },
      filter.project, filter.scene, start.project, start.scene, start.machine_class,
      start.reward_version, limit, LineList(filter.projects));
  for (size_t i = 0; status.ok() && i < scenes.size(); ++i) status = LoadArms(ids[i], scenes[i]);
  if (!status.ok()) return status;
  return scenes;
}

absl::StatusOr<std::optional<SceneEvidence>> SqlitePriorReader::LoadScene(const SceneKey& key) {
  SceneEvidence scene{.key = key, .arms = {}, .source_count = 0};
  int64_t id = 0;
  bool whole = true;
  absl::Status status = statements_.find_scene.ForEachRow(
      [&](const SqliteRow& row) {
        id = row.Integer(0);
        scene.source_count = row.Unsigned(1);
        whole = row.Integer(2) != 0;
      },
      key.project, key.scene, key.machine_class, key.reward_version);
  if (status.ok() && id == 0) return std::nullopt;
  if (!whole) return DamagedScene(key.project, key.scene);
  if (status.ok()) status = LoadArms(id, scene);
  if (!status.ok()) return status;
  return scene;
}

absl::StatusOr<priors::SceneCount> SqlitePriorReader::CountScenes(const std::string& project) {
  priors::SceneCount count;
  absl::Status status = statements_.count_scenes.ForEachRow(
      [&](const SqliteRow& row) {
        count = {row.Unsigned(0), row.Unsigned(1)};
      },
      project);
  if (!status.ok()) return status;
  return count;
}

absl::StatusOr<bool> SqlitePriorReader::HasOtherKeys(const std::string& project,
                                                     const std::string& scene, int64_t scene_id) {
  bool has = false;
  absl::Status status = statements_.other_keys_of_name.ForEachRow(
      [&](const SqliteRow&) { has = true; }, project, scene, scene_id);
  if (!status.ok()) return status;
  return has;
}

absl::StatusOr<uint64_t> SqlitePriorReader::CountProjects() {
  uint64_t count = 0;
  absl::Status status =
      statements_.count_projects.ForEachRow([&](const SqliteRow& row) { count = row.Unsigned(0); });
  if (!status.ok()) return status;
  return count;
}

absl::StatusOr<SqlitePriorReader::ExportKey> SqlitePriorReader::NextKey(
    const SceneFilter& filter, const EvidenceKey& first, int64_t first_reward_version,
    bool quarantined) {
  ExportKey next;
  SqliteStatement& statement =
      quarantined ? statements_.next_quarantined_key : statements_.next_key;
  absl::Status status = statement.ForEachRow(
      [&](const SqliteRow& row) {
        next = {.key = KeyOf(row), .id = row.Integer(7), .damaged = row.Integer(8) == 0};
      },
      filter.project, filter.scene, first.project, first.scene, first.measured_by, first.arm,
      first.backend_version, first.machine_class, first_reward_version, LineList(filter.projects));
  if (!status.ok()) return status;
  return next;
}

absl::Status SqlitePriorReader::AppendEvidence(const ExportKey& key, uint32_t limit,
                                               bool quarantined, priors::ExportPage& page) {
  const uint64_t first = page.next.key == key.key ? page.next.source_number : 0;
  bool damaged = key.damaged;
  SqliteStatement& statement =
      quarantined ? statements_.quarantined_evidence : statements_.key_evidence;
  absl::Status status = statement.ForEachRow(
      [&](const SqliteRow& row) {
        damaged = damaged || row.Integer(7) == 0;
        page.records.push_back({key.key, row.Text(1), row.Unsigned(2), EvidenceOf(row, 3),
                                row.Text(8), row.Unsigned(9), row.Integer(10) != 0, quarantined});
        page.next = {key.key, row.Unsigned(0)};
      },
      key.id, first, limit - static_cast<uint32_t>(page.records.size()));
  return status.ok() && damaged ? DamagedScene(key.key.project, key.key.scene) : status;
}

absl::StatusOr<priors::ExportPage> SqlitePriorReader::Export(const SceneFilter& filter,
                                                             const priors::ExportPlace& after,
                                                             uint32_t limit) {
  return ExportAll(filter, after, limit, /*quarantined=*/false);
}

absl::StatusOr<priors::ExportPage> SqlitePriorReader::ExportQuarantined(
    const SceneFilter& filter, const priors::ExportPlace& after, uint32_t limit) {
  return ExportAll(filter, after, limit, /*quarantined=*/true);
}

absl::StatusOr<priors::ExportPage> SqlitePriorReader::ExportAll(const SceneFilter& filter,
                                                                const priors::ExportPlace& after,
                                                                uint32_t limit, bool quarantined) {
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
    if (absl::Status status = AppendEvidence(*key, limit, quarantined, page); !status.ok())
      return status;
    // The version comes last in the order of keys, and is a whole number.
    first = key->key;
    first_reward_version = int64_t{first.reward_version} + 1;
  }
  return page;
}

namespace {

// The reads of a job are one transaction, which sees one state of the database.
class SqliteReadConnection final : public ReadConnection {
 public:
  explicit SqliteReadConnection(SqliteDatabase database) : database_(std::move(database)) {}

  absl::Status Prepare() {
    auto reader = SqlitePriorReader::Prepare(database_);
    if (!reader.ok()) return reader.status();
    reader_ = *std::move(reader);
    return absl::OkStatus();
  }
  // BEGIN reads nothing and fails only without memory. Then each read sees a state of its own.
  priors::PriorReader& Begin() override {
    database_.Execute("BEGIN").IgnoreError();
    return *reader_;
  }
  void End() override {
    if (database_.in_transaction()) database_.Execute("ROLLBACK").IgnoreError();
  }

 private:
  SqliteDatabase database_;
  std::optional<SqlitePriorReader> reader_;  // after the database, which its statements use
};

}  // namespace

absl::StatusOr<std::unique_ptr<ReadConnection>> OpenSqliteReadConnection(
    const std::filesystem::path& path) {
  auto database = OpenPriorDatabaseToRead(path);
  if (!database.ok()) return database.status();
  auto connection = std::make_unique<SqliteReadConnection>(*std::move(database));
  if (absl::Status status = connection->Prepare(); !status.ok()) return status;
  return connection;
}

}  // namespace sweepstake::storage
