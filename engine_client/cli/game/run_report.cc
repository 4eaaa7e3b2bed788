#include "engine_client/cli/game/run_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/standing_cells.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/types.h"
#include "engine_client/text/counts.h"

namespace sweepstake::cli {
namespace {

constexpr std::array kReasons = {SwitchReason::kPolicy, SwitchReason::kExploration,
                                 SwitchReason::kBailOut, SwitchReason::kManual};

// The text of each ShadowState, indexed by value.
constexpr std::array<std::string_view, 6> kShadowStateNames = {
    "off",
    "off, there is only one arm",
    "off, no core to spare",
    "paused, because the mode is manual or the policy does not use it",
    "running",
    "off, the scene is too big for the lane's memory"};

std::string StateName(ShadowState state) { return decision::NameOf(kShadowStateNames, state); }

std::string TimeText(double time_s, uint64_t frame_index) {
  return Fixed(time_s, 1) + " s  frame " + std::to_string(frame_index) + ": ";
}

std::string ArmTable(const RunSummary& summary) {
  std::vector<std::string> header = StandingHeader();
  header.insert(header.begin(), "arm");
  header.insert(header.end(), {"mean", "alpha", "beta", "active_%", "frames", "detection_ms"});
  TextTable table(header);
  const double whole_s = std::max(summary.active_s(), 1e-9);
  for (const ArmRow& row : summary.arms) {
    std::vector<std::string> cells = StandingCells(row.belief.standing);
    cells.insert(cells.begin(), row.arm);
    cells.insert(cells.end(),
                 {Fixed(row.mean(), 3), Fixed(row.belief.alpha, 1), Fixed(row.belief.beta, 1),
                  Fixed(100 * row.active_s() / whole_s, 1),
                  std::to_string(row.activity.frame_count), Fixed(row.detection_ms(), 4)});
    table.AddRow(std::move(cells));
  }
  return table.Text() + StandingLegend() +
         "mean: mean of the reward's posterior Beta(alpha, beta); 1 is the best possible\n";
}

// Returns whether nothing was learnt: a decider without evidence reports Beta(1,1) for every arm.
bool IsNothingKnown(std::span<const ArmRow> arms) {
  return std::all_of(arms.begin(), arms.end(), [](const ArmRow& row) {
    return row.belief.alpha == 1 && row.belief.beta == 1;
  });
}

// Returns whether the connection to the daemon was lost and is still lost. A new connection clears
// last_error, so an error after the first connection means that the connection is lost now.
bool IsLost(const SessionStats& session) {
  return session.connection_count > 0 && !session.last_error.empty();
}

// Returns whether the run had a daemon's address but never a session with it.
bool IsUnreached(const RunSummary& summary) {
  return summary.setup.decider != "embedded" && summary.session.connection_count == 0;
}

// Returns what was learnt: a table of the arms, or why there is none.
std::string LearntText(const RunSummary& summary) {
  const RunSetup& setup = summary.setup;
  if (IsUnreached(summary)) {
    return "\nNothing was learnt, because no daemon decided: start one with sweepstaked --listen " +
           setup.decider + ", or use --embedded\n";
  }
  std::string text = "\nPosteriors learnt in " + setup.scene.name + " with " +
                     std::to_string(setup.scene.object_count) + " objects (" +
                     PriorsText(setup, summary.session) + ")\n" + ArmTable(summary);
  if (IsNothingKnown(summary.arms))
    text += "Nothing was learnt yet: all posteriors are Beta(1,1)\n";
  return text;
}

std::string DropCause(const SessionStats& session) {
  if (session.awaits_acknowledgement) return "the daemon has not acknowledged the sent messages";
  return IsLost(session) ? "the daemon was lost" : "frames come faster than they are sent";
}

// Returns, for example, "3 switches: 2 policy, 1 bail-out; 1 ended a trial".
std::string SwitchCountsText(const RunSummary& summary) {
  const size_t switch_count = summary.switches.size();
  std::string text = std::to_string(switch_count) + (switch_count == 1 ? " switch" : " switches");
  const char* separator = ": ";
  for (const SwitchReason reason : kReasons) {
    const size_t count = summary.SwitchCount(reason);
    if (count == 0) continue;
    text += separator + std::to_string(count) + ' ' + ReasonName(reason);
    separator = ", ";
  }
  const auto trial_count =
      std::count_if(summary.switches.begin(), summary.switches.end(),
                    [](const SwitchRow& row) { return row.trial_detection_time_ns > 0; });
  if (trial_count > 0) text += "; " + std::to_string(trial_count) + " ended a trial";
  return text;
}

// Returns a line about the suspended frames, or an empty text if there were none.
std::string SuspendedText(uint64_t count) {
  if (count == 0) return "";
  return "The system suspended the game in " + std::to_string(count) +
         (count == 1 ? " frame, which does" : " frames, which do") + " not count as evidence\n";
}

Json ShadowJson(const RunSummary& summary) {
  const ShadowStats& shadow = summary.shadow;
  return {{"state", StateName(shadow.state)},
          {"sweeps", shadow.sweep_count},
          {"visits", shadow.visit_count},
          {"capped_visits", shadow.capped_visit_count},
          {"busy_share", summary.shadow_busy_ratio()},
          {"frame_share", summary.shadow_frame_share()},
          {"copied_frames", shadow.copied_frame_count},
          {"copy_ns_per_frame", summary.shadow_copy_ns_per_frame()},
          {"ms_per_frame", summary.shadow_ms_per_frame()},
          {"memory_bytes", shadow.memory_bytes},
          {"warm_switches", shadow.warm_switch_count},
          {"cold_switches", shadow.cold_switch_count}};
}

Json ArmJson(const ArmRow& row) {
  Json document = {{"arm", row.arm},
                   {"alpha", row.belief.alpha},
                   {"beta", row.belief.beta},
                   {"mean", row.mean()},
                   {"active_s", row.active_s()},
                   {"frames", row.activity.frame_count},
                   {"fps", row.fps()},
                   {"detection_ms", row.detection_ms()}};
  AddStanding(row.belief.standing, document);
  return document;
}

Json SwitchJson(const SwitchRow& row) {
  return {{"frame", row.frame_index},
          {"time_s", row.time_s},
          {"from", row.from},
          {"to", row.to},
          {"reason", ReasonName(row.reason)},
          {"trial_detection_time_ns", row.trial_detection_time_ns}};
}

Json VerdictJson(const VerdictRow& row) {
  Json document = {{"verdict", row.name}};
  if (row.leader_arm.empty()) return document;
  document["leader_arm"] = row.leader_arm;
  document["leader_probability"] = row.leader_probability;
  return document;
}

Json VerdictChangeJson(const VerdictChangeRow& row) {
  Json document = {{"frame", row.frame_index}, {"time_s", row.time_s}};
  document.update(VerdictJson(row.verdict));
  return document;
}

std::string InvalidBoxesText(uint32_t count) {
  if (count == 0) return "";
  if (count == 1)
    return "1 object overlaps nothing, because its box is infinite, NaN or inverted\n";
  return std::to_string(count) +
         " objects overlap nothing, because their boxes are infinite, NaN or inverted\n";
}

// Returns the part of the run's JSON about the daemon, or null if there was no daemon. The seed is
// a string, because a JSON number cannot represent all 64 bits.
Json DaemonJson(const SessionStats& session) {
  if (session.daemon_version.empty()) return nullptr;
  Json document = {{"version", session.daemon_version},
                   {"policy", session.policy},
                   {"seed", std::to_string(session.seed)},
                   {"interval_s", Seconds(session.rules.decision_interval_ns.value_or(0))},
                   {"cooldown_s", Seconds(session.rules.cooldown_ns.value_or(0))},
                   {"settling_s", Seconds(session.rules.settling_ns.value_or(0))}};
  if (const std::optional<RewardWeights>& weights = session.rules.weights) {
    document["weights"] = {weights->fps, weights->detection, weights->memory, weights->checks};
  }
  return document;
}

Json RecordingsJson(const SessionStats& session) {
  Json rows = Json::array();
  for (const FlightRecording& recording : session.recordings) {
    rows.push_back({{"file", recording.path},
                    {"bytes", recording.bytes},
                    {"worst_frame_ms", static_cast<double>(recording.worst_frame_ns) * 1e-6}});
  }
  return rows;
}

// Returns the fields that have one value for the whole run.
Json TotalsJson(const RunSummary& summary) {
  const SessionStats& session = summary.session;
  return {{"command", "run"},
          {"scene", summary.setup.scene.name},
          {"objects", summary.setup.scene.object_count},
          {"seed", summary.setup.scene.seed},
          {"mode", summary.setup.mode},
          {"decider", summary.setup.decider},
          {"session_id", session.session_id},
          {"connections", session.connection_count},
          {"last_error", session.last_error},
          {"prior_sources", session.prior_source_count},
          {"daemon", DaemonJson(session)},
          {"frames", summary.frame_count},
          {"suspended_frames", summary.suspended_frame_count},
          {"invalid_boxes", summary.invalid_box_count},
          {"seconds", summary.active_s()},
          {"fps", summary.fps()},
          {"detection_ms", summary.detection_ms()},
          {"initial_arm", summary.initial_arm},
          {"saved_against_initial_us", OrNull(session.saved_us)},
          {"sent_frames", session.sent_frame_count},
          {"dropped_frames", session.dropped_frame_count},
          {"resent_messages", session.resent_message_count},
          {"commands", session.command_count},
          {"active_arm", summary.active_arm},
          {"recordings", RecordingsJson(session)},
          {"recording_error", session.recording_error},
          {"shadow", ShadowJson(summary)}};
}

Status WriteSwitches(const RunSummary& summary, const std::filesystem::path& path) {
  const auto csv = WholeFile::Create(path);
  if (!csv.ok()) return csv.status();
  (*csv)->WriteRow({"frame", "time_s", "from", "to", "reason", "rebuild_time_ns",
                    "settling_cost_ns", "trial_detection_time_ns"});
  for (const SwitchRow& row : summary.switches) {
    (*csv)->WriteRow({std::to_string(row.frame_index), Fixed(row.time_s, 6), row.from, row.to,
                      ReasonName(row.reason), std::to_string(row.rebuild_time_ns),
                      std::to_string(row.settling_cost_ns),
                      std::to_string(row.trial_detection_time_ns)});
  }
  return (*csv)->Commit();
}

std::string ExactText(uint64_t count) { return std::to_string(count); }
std::string ExactText(double value) { return Fixed(value, 9); }

Status WritePosteriors(const RunSummary& summary, const std::filesystem::path& path) {
  const auto csv = WholeFile::Create(path);
  if (!csv.ok()) return csv.status();
  (*csv)->WriteRow({"arm", "backend_version", "alpha", "beta", "mean", "n", "active_s", "frames",
                    "live_windows", "lane_visits", "best_probability", "cost_ratio",
                    "cost_ratio_low", "cost_ratio_high"});
  for (const ArmRow& row : summary.arms) {
    const std::optional<ArmStanding>& standing = row.belief.standing;
    const auto known = [&](auto ArmStanding::*value) {
      return standing ? ExactText((*standing).*value) : "";
    };
    const auto ratio = [&](double CostRatio::*value) {
      return standing && standing->cost_ratio ? ExactText((*standing->cost_ratio).*value) : "";
    };
    (*csv)->WriteRow({row.arm, std::to_string(row.backend_version), Fixed(row.belief.alpha, 9),
                      Fixed(row.belief.beta, 9), Fixed(row.mean(), 9),
                      known(&ArmStanding::effective_window_count), Fixed(row.active_s(), 6),
                      std::to_string(row.activity.frame_count),
                      known(&ArmStanding::live_window_count), known(&ArmStanding::lane_visit_count),
                      known(&ArmStanding::best_probability), ratio(&CostRatio::median),
                      ratio(&CostRatio::low), ratio(&CostRatio::high)});
  }
  return (*csv)->Commit();
}

}  // namespace

std::string PriorsText(const RunSetup& setup, const SessionStats& session) {
  if (session.prior_source_count == 0 && !setup.priors_file.empty()) {
    return setup.priors_file + " has no priors of these backends for " + setup.priors_key;
  }
  if (session.priors_unavailable) return "the daemon cannot read its priors; its log says why";
  if (session.prior_source_count == 0) return "no priors yet";
  return "starts from priors of " + std::to_string(session.prior_source_count) +
         (session.prior_source_count == 1 ? " earlier session" : " earlier sessions");
}

std::string SwitchText(const SwitchRow& row) {
  return TimeText(row.time_s, row.frame_index) + row.from + " → " + row.to + " (" +
         ReasonName(row.reason) + ")";
}

std::string VerdictText(const VerdictRow& row) {
  if (row.leader_arm.empty()) return row.name;
  return row.name + ": " + row.leader_arm + " is the best with probability " +
         Fixed(row.leader_probability, 2);
}

std::string VerdictChangeText(const VerdictChangeRow& row) {
  return TimeText(row.time_s, row.frame_index) + "verdict " + VerdictText(row.verdict);
}

std::string BeliefsText(std::span<const ArmBelief> beliefs) {
  const auto mean = [](const ArmBelief& belief) {
    return belief.alpha / (belief.alpha + belief.beta);
  };
  std::vector<ArmBelief> best_first(beliefs.begin(), beliefs.end());
  std::stable_sort(best_first.begin(), best_first.end(),
                   [&](const ArmBelief& a, const ArmBelief& b) { return mean(a) > mean(b); });
  std::string text;
  for (const ArmBelief& belief : best_first) {
    const std::optional<ArmStanding>& standing = belief.standing;
    const bool has_ratio = standing && standing->cost_ratio;
    const std::string n = standing ? Fixed(standing->effective_window_count, 1) : "";
    text += (text.empty() ? "" : " · ") + belief.arm + " " +
            (has_ratio ? "×" + RatioText(standing->cost_ratio->median) : Fixed(mean(belief), 2)) +
            (n.empty() ? "" : " (" + n + (text.empty() ? " equivalent windows)" : ")"));
  }
  return text;
}

std::string FrameCostText(const RunSummary& summary) {
  std::string text = "Per frame: " + Fixed(summary.detection_ms(), 4) + " ms of detection";
  if (const std::optional<double> saved_us = summary.session.saved_us) {
    text += ", " + Fixed(std::abs(*saved_us) / 1e3, 4) + " ms " +
            (*saved_us < 0 ? "more" : "less") + " than estimated for always " +
            summary.initial_arm + ", the arm at the start";
  }
  if (summary.shadow.busy_time_ns == 0) return text;
  return text + "; the shadow lane used " + Fixed(summary.shadow_ms_per_frame(), 4) +
         " ms of another core";
}

std::string ShadowText(const RunSummary& summary) {
  const ShadowStats& shadow = summary.shadow;
  std::string text = "Shadow lane: " + StateName(shadow.state);
  if (shadow.visit_count > 0) {
    text += ", " + text::Counted(shadow.visit_count, "visit") + " in " +
            text::Counted(shadow.sweep_count, "sweep") + ", " +
            Fixed(100 * summary.shadow_busy_ratio(), 1) +
            " % of its thread's time, slowed the frame thread by " +
            Fixed(100 * summary.shadow_frame_share(), 2) + " %, copying took " +
            Fixed(summary.shadow_copy_ns_per_frame(), 0) + " ns per frame";
  }
  return text + "; " + std::to_string(shadow.warm_switch_count) + " warm and " +
         std::to_string(shadow.cold_switch_count) + " cold switches";
}

std::string DroppedText(const SessionStats& session, uint64_t frame_count) {
  if (session.dropped_frame_count == 0) return "no samples dropped";
  return std::to_string(session.dropped_frame_count) + " of " + std::to_string(frame_count) +
         " samples were dropped because the queue was full (" + DropCause(session) +
         "): there is less evidence, but the frames were not delayed";
}

std::string RecordingsText(const SessionStats& session) {
  std::string text;
  for (const FlightRecording& recording : session.recordings) {
    text += "Recorded a frame of " +
            Fixed(static_cast<double>(recording.worst_frame_ns) * 1e-6, 1) +
            " ms: " + recording.path + '\n';
  }
  if (session.recording_error.empty()) return text;
  return text + "The flight recorder wrote no file: " + session.recording_error + '\n';
}

std::string RunReportText(const RunSummary& summary) {
  return LearntText(summary) + std::to_string(summary.frame_count) + " frames in " +
         Fixed(summary.active_s(), 1) + " s, " + Fixed(summary.fps(), 0) + " frames/s\n" +
         InvalidBoxesText(summary.invalid_box_count) +
         DroppedText(summary.session, summary.frame_count) + '\n' +
         SuspendedText(summary.suspended_frame_count) +
         (IsLost(summary.session)
              ? "The session did not end properly: " + summary.session.last_error + '\n'
              : "") +
         SwitchCountsText(summary) + '\n' + ShadowText(summary) + '\n' + FrameCostText(summary) +
         '\n' + (IsUnreached(summary) ? "" : "Verdict: " + VerdictText(summary.verdict) + '\n') +
         RecordingsText(summary.session);
}

Json RunReportJson(const RunSummary& summary) {
  Json document = TotalsJson(summary);
  document["arms"] = Json::array();
  for (const ArmRow& row : summary.arms) document["arms"].push_back(ArmJson(row));
  document["switches_by_reason"] = Json::object();
  for (const SwitchReason reason : kReasons) {
    document["switches_by_reason"][ReasonName(reason)] = summary.SwitchCount(reason);
  }
  document["switches"] = Json::array();
  for (const SwitchRow& row : summary.switches) document["switches"].push_back(SwitchJson(row));
  document["verdict_changes"] = Json::array();
  document.update(VerdictJson(summary.verdict));
  for (const VerdictChangeRow& row : summary.verdict_changes) {
    document["verdict_changes"].push_back(VerdictChangeJson(row));
  }
  return document;
}

void WriteFrameHeader(WholeFile& csv) {
  csv.WriteRow({"frame", "arm", "switch_epoch", "frame_time_ns", "detection_time_ns",
                "aabb_check_count", "pair_count", "object_count", "native_bytes", "flags"});
}

void WriteFrame(const FrameSample& sample, const AdaptiveBroadPhase& adaptive, WholeFile& csv) {
  csv.WriteRow({std::to_string(sample.frame_index), adaptive.arms()[sample.arm],
                std::to_string(sample.switch_epoch), std::to_string(sample.frame_time_ns),
                std::to_string(sample.detection_time_ns), std::to_string(sample.aabb_check_count),
                std::to_string(sample.pair_count), std::to_string(sample.object_count),
                std::to_string(sample.native_bytes), std::to_string(sample.flags)});
}

Status WriteRunReportCsv(const RunSummary& summary, const std::filesystem::path& folder) {
  Status status = WriteSwitches(summary, folder / "switches.csv");
  return status.ok() ? WritePosteriors(summary, folder / "posteriors.csv") : status;
}

}  // namespace sweepstake::cli
