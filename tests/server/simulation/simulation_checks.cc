// Checks the invariants of the store of a simulation.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/audit/rederive.h"
#include "server/storage/backup/sqlite_backup.h"
#include "tests/engine_client/decider/audit/stored_audit.h"
#include "tests/server/simulation/simulation.h"

namespace sweepstake::simulation {

void Simulation::CheckStore(priors::PriorStore& store) {
  for (const auto& game : games_) {
    std::set<uint64_t> counted;
    for (const auto& [id, sent] : game->sessions()) CheckSession(id, sent, *game, store, counted);
  }
  const auto records = store.Export({}, {}, 100'000);
  if (!records.ok()) return Complain("the records cannot be read: " + records.status().ToString());
  const auto complain = [this](const std::string& what) { Complain(what); };
  files_.Check(records->records, complain);
  model_.Check(store, *records, complain);
  const auto scenes = store.List({}, {}, 1000);
  if (!scenes.ok()) return Complain("the scenes cannot be read: " + scenes.status().ToString());
  CheckProject(store, *scenes);
}

void Simulation::CheckFile() {
  const auto contents = storage::VerifyStore(directory_.path() / "priors.db");
  if (!contents.ok()) Complain("the file is not whole: " + contents.status().ToString());
}

void Simulation::CheckProject(priors::PriorStore& store,
                              const std::vector<priors::SceneEvidence>& all) {
  const auto is_shown = [this](const auto& scene) {
    return watcher_.filter().Matches(scene.key.project, scene.key.scene);
  };
  const auto scenes = store.List(watcher_.filter(), {}, 1000);
  const auto records = store.Export(watcher_.filter(), {}, 100'000);
  if (!scenes.ok() || !records.ok()) return Complain("the scenes of a project cannot be read");
  if (std::count_if(all.begin(), all.end(), is_shown) !=
      std::count_if(scenes->begin(), scenes->end(), is_shown))
    Complain("a caller does not see all scenes of its project");
  for (const priors::SceneEvidence& scene : *scenes) {
    if (!is_shown(scene)) Complain("a caller sees a scene of another project");
  }
  for (const priors::PriorRecord& record : records->records) {
    if (record.key.project != kProjects.front())
      Complain("a caller receives evidence of another project");
  }
}

void Simulation::CheckWatcher(priors::PriorStore& store) {
  for (const auto& [key, told] : watcher_.latest()) {
    ++tally_.watched_scenes;
    const auto stored = store.LoadScene(key);
    bool same = stored.ok() && stored->has_value() && (*stored)->arms.size() == told.arms.size() &&
                (*stored)->source_count == told.source_count;
    for (size_t i = 0; same && i < told.arms.size(); ++i) {
      const priors::SceneEvidence::Arm& arm = (*stored)->arms[i];
      same = arm.live.window_count == told.arms[i].live.window_count &&
             arm.live.bail_out_count == told.arms[i].live.bail_out_count &&
             arm.lane.window_count == told.arms[i].lane.window_count;
    }
    if (!same) Complain("a watcher received different evidence than the store has of " + key.scene);
  }
}

void Simulation::CheckSession(const std::string& id, const SentSession& sent,
                              const SimulatedGame& game, priors::PriorStore& store,
                              std::set<uint64_t>& counted) {
  const auto source = store.LoadSource(id);
  if (!source.ok()) {
    return Complain("a session cannot be read: " + source.status().ToString());
  }
  const priors::SourceProgress progress =
      source->has_value() ? (*source)->progress : priors::SourceProgress{};
  if (progress.message_sequence < sent.promised_sequence) {
    Complain(absl::StrCat("session ", id, " has lost evidence: ", sent.promised_sequence,
                          " was acknowledged, but on disk is ", progress.message_sequence));
  }
  if (progress.message_sequence > sent.messages.size()) {
    return Complain("the store has messages that no game has sent");
  }
  uint64_t frames = 0;
  uint64_t bail_outs = 0;
  for (size_t i = 0; i < progress.message_sequence; ++i) {
    const SentMessage& message = sent.messages[i];
    frames += message.frame_count;
    bail_outs += message.bail_out_count;
    if (message.first_frame != 0 && !counted.insert(message.first_frame).second)
      Complain(absl::StrCat("frame ", message.first_frame, " counts for two sessions"));
  }
  const priors::Evidence total = model_.OfSession(id);
  if (progress.frame_count != frames || total.bail_out_count != bail_outs) {
    Complain(absl::StrCat("session ", id, " (", game.hello().policy(), ") of ",
                          progress.message_sequence, " messages has ", progress.frame_count,
                          " frames for ", frames, " and ", total.bail_out_count, " bail-outs for ",
                          bail_outs));
  }
  const auto observations = static_cast<double>(total.window_count + 10 * total.bail_out_count);
  if (game.hello().policy() == "paper" && std::abs(total.alpha + total.beta - observations) > 1e-6)
    Complain(absl::StrCat("session ", id, " has other evidence than its windows and bail-outs"));
}

void Simulation::CheckAudit(priors::PriorStore& store) {
  const auto rows = test_support::StoredAudit(store);
  if (!rows.ok()) return Complain("no audit log: " + rows.status().ToString());
  const decision::AuditReport report = decision::Rederive(*rows);
  if (report.difference) Complain("a decision differs: " + report.difference->Text());
  tally_.derived_decisions = report.decision_count;
}

}  // namespace sweepstake::simulation
