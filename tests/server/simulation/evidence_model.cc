#include "tests/server/simulation/evidence_model.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace sweepstake::simulation {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using priors::PriorRecord;
using priors::SceneKey;
using priors::SourceUpdate;

SceneKey SceneOf(const EvidenceKey& key) {
  return {.project = key.project,
          .scene = key.scene,
          .machine_class = key.machine_class,
          .reward_version = key.reward_version};
}

}  // namespace

void EvidenceModel::Commit(std::span<const SourceUpdate> updates, bool ok) {
  for (const SourceUpdate& update : updates) {
    Session& session = sessions_[update.progress.source_id];
    if (update.progress.commit_sequence <= session.progress.commit_sequence) continue;
    if (ok) {
      Apply(update, session);
    } else {
      session.failed.push_back(update);
    }
  }
}

void EvidenceModel::Apply(const SourceUpdate& update, Session& session) {
  session.progress = update.progress;
  for (const auto& [key, evidence] : update.increments)
    session.evidence[key] += priors::InUnits(evidence);
  session.failed.clear();
}

void EvidenceModel::Settle(priors::PriorReader& store, const Complain& complain) {
  for (auto& [id, session] : sessions_) {
    const auto stored = store.LoadSource(id);
    if (!stored.ok()) return complain("a session cannot be read: " + stored.status().ToString());
    const priors::SourceProgress progress =
        stored->has_value() ? (*stored)->progress : priors::SourceProgress{};
    const auto on_disk =
        std::find_if(session.failed.begin(), session.failed.end(),
                     [&](const SourceUpdate& update) { return update.progress == progress; });
    if (on_disk != session.failed.end()) Apply(SourceUpdate(*on_disk), session);
    if (progress != session.progress)
      complain(absl::StrCat("session ", id, " is on disk at commit ", progress.commit_sequence,
                            ", which the session never made or which is not its latest"));
    session.failed.clear();
  }
}

Evidence EvidenceModel::OfSession(const std::string& id) const {
  Evidence total;
  const auto session = sessions_.find(id);
  if (session == sessions_.end()) return total;
  for (const auto& [key, evidence] : session->second.evidence) total += evidence;
  return total;
}

void EvidenceModel::Scene::Add(const std::string& source, const EvidenceKey& key,
                               const Evidence& more) {
  evidence.ArmOf(key.arm, key.backend_version).Add(key.regime, key.measured_by, more);
  sources.insert(source);
}

bool EvidenceModel::Scene::SameAs(const priors::SceneEvidence& stored) const {
  return stored.source_count == sources.size() &&
         std::equal(stored.arms.begin(), stored.arms.end(), evidence.arms.begin(),
                    evidence.arms.end(), [](const auto& arm, const auto& mine) {
                      return arm.name == mine.name && arm.backend_version == mine.backend_version &&
                             mine.live == arm.live && mine.lane == arm.lane &&
                             mine.regimes == arm.regimes;
                    });
}

std::map<SceneKey, EvidenceModel::Scene> EvidenceModel::Scenes(
    std::span<const PriorRecord> exported) const {
  std::map<SceneKey, Scene> scenes;
  for (const auto& [id, session] : sessions_) {
    for (const auto& [key, evidence] : session.evidence)
      scenes[SceneOf(key)].Add(id, key, evidence);
  }
  for (const PriorRecord& record : exported) {
    if (has_session(record.source_id)) continue;
    scenes[SceneOf(record.key)].Add(record.source_id, record.key, record.evidence);
  }
  return scenes;
}

void EvidenceModel::Check(priors::PriorReader& store, const priors::ExportPage& exported,
                          const Complain& complain) const {
  const auto stored = store.List({}, {}, 1000);
  if (!stored.ok()) return complain("the scenes cannot be read: " + stored.status().ToString());
  const auto scenes = Scenes(exported.records);
  uint64_t windows = 0;
  for (const PriorRecord& record : exported.records) windows += record.evidence.window_count;
  for (const priors::SceneEvidence& scene : *stored) {
    for (const auto& arm : scene.arms) windows -= arm.live.window_count + arm.lane.window_count;
    const auto mine = scenes.find(scene.key);
    if (mine == scenes.end() || !mine->second.SameAs(scene))
      complain("scene " + scene.key.scene + " differs from the evidence of its sessions and files");
  }
  if (stored->size() != scenes.size()) complain("a scene was lost");
  if (windows != 0) complain("the windows of the records differ from those of the scenes");
  CheckRecords(exported.records, complain);
}

void EvidenceModel::CheckRecords(std::span<const PriorRecord> records,
                                 const Complain& complain) const {
  std::map<std::string, size_t> counts;
  for (const PriorRecord& record : records) {
    const auto session = sessions_.find(record.source_id);
    if (session == sessions_.end()) continue;
    ++counts[record.source_id];
    const auto mine = session->second.evidence.find(record.key);
    if (mine == session->second.evidence.end() || mine->second != record.evidence)
      complain("a record of session " + record.source_id +
               " differs from the evidence that the session committed");
  }
  for (const auto& [id, session] : sessions_) {
    if (counts[id] != session.evidence.size()) complain("a record of session " + id + " was lost");
  }
}

}  // namespace sweepstake::simulation
