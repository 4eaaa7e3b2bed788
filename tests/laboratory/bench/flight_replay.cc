#include "tests/laboratory/bench/flight_replay.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/text/names.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/laboratory/bench/scene_timing.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kRowCells = 11;  // engine_client/telemetry/common/flight_notes.cc writes them

template <typename T>
std::optional<T> OptionalOf(const Json& value) {
  return value.is_null() ? std::nullopt : std::optional<T>(value.get<T>());
}

FlightFrameRow FrameRowOf(const Json& row) {
  return {.frame = row.at(0),
          .frame_ms = row.at(1).get<double>() * 1e-6,
          .detection_ms = row.at(2).get<double>() * 1e-6,
          .object_count = row.at(3),
          .pair_count = row.at(4),
          .arm = row.at(7),
          .boxes = OptionalOf<size_t>(row.at(kRowCells - 1))};
}

FlightDecisionRow DecisionRowOf(const Json& row) {
  return {.frame = row.at("frame"),
          .outcome = row.at("outcome"),
          .verdict = row.at("verdict"),
          .reason = row.value("reason", ""),
          .candidate_arm = OptionalOf<uint32_t>(row.at("candidate_arm")),
          .commanded_arm = OptionalOf<uint32_t>(row.at("commanded_arm")),
          .best_probability = row.at("best_probability").get<std::vector<double>>()};
}

FlightLog LogOf(const Json& notes) {
  FlightLog log{.project = notes.at("project"),
                .scene = notes.at("scene"),
                .build = notes.at("build"),
                .machine_class = notes.at("machine_class"),
                .recorded_unix_ms = notes.at("recorded_unix_ms"),
                .frame_budget_ms = notes.at("frame_budget_ms"),
                .worst = 0,
                .arms = notes.at("arms").get<std::vector<std::string>>(),
                .frames = {},
                .decisions = {}};
  const auto worst_frame = notes.at("worst_frame").get<uint64_t>();
  for (const Json& row : notes.at("frames")) {
    log.frames.push_back(FrameRowOf(row));
    if (log.frames.back().frame == worst_frame) log.worst = log.frames.size() - 1;
  }
  for (const Json& row : notes.at("decisions")) log.decisions.push_back(DecisionRowOf(row));
  return log;
}

bool IsArm(const FlightLog& log, std::optional<uint32_t> arm) {
  return !arm || *arm < log.arms.size();
}

// Returns whether all arm indices and box numbers are in range, since later code uses them as
// indices without checks.
bool IsSound(const FlightLog& log) {
  size_t box_frame_count = 0;
  for (const FlightFrameRow& frame : log.frames) {
    if (!IsArm(log, frame.arm)) return false;
    if (frame.boxes && *frame.boxes != box_frame_count++) return false;
  }
  return box_frame_count > 0 &&
         std::all_of(log.decisions.begin(), log.decisions.end(), [&](const FlightDecisionRow& row) {
           return IsArm(log, row.candidate_arm) && IsArm(log, row.commanded_arm) &&
                  row.best_probability.size() <= log.arms.size();
         });
}

size_t BoxFrameCount(const FlightLog& log) {
  return static_cast<size_t>(
      std::count_if(log.frames.begin(), log.frames.end(),
                    [](const FlightFrameRow& frame) { return frame.boxes.has_value(); }));
}

// Returns the number of the boxes of the longest frame. If these were not recorded, returns the
// next recorded ones.
size_t WorstBoxes(const FlightLog& log) {
  for (size_t index = log.worst; index < log.frames.size(); ++index) {
    if (log.frames[index].boxes) return *log.frames[index].boxes;
  }
  return BoxFrameCount(log) - 1;
}

// Returns the time of each arm in each step of the scene.
Result<std::vector<std::vector<double>>> TimeOnce(const std::string& file, uint64_t steps) {
  auto scene = MakeScene(file, {});
  if (!scene.ok()) return scene.status();
  std::vector<Contestant> contestants;
  for (const std::string_view arm : BroadPhaseNames())
    contestants.push_back({.broad_phase = std::move(*MakeBroadPhase(arm))});
  std::vector<std::vector<double>> times;
  for (ContestantTiming& timing :
       TimeScene(**scene, contestants, {.warmup = 0, .frames = steps}, [](size_t, uint64_t) {}))
    times.push_back(std::move(timing.step_ms));
  return times;
}

// Takes the minimum of several passes, because other work on the machine can only add time.
Result<std::vector<std::vector<double>>> TimeArms(const std::string& file, uint64_t steps) {
  auto least = TimeOnce(file, steps);
  for (int pass = 1; pass < kFlightPasses && least.ok(); ++pass) {
    const auto times = TimeOnce(file, steps);
    if (!times.ok()) return times.status();
    for (size_t arm = 0; arm < least->size(); ++arm) {
      for (size_t step = 0; step < steps; ++step)
        (*least)[arm][step] = std::min((*least)[arm][step], (*times)[arm][step]);
    }
  }
  return least;
}

void AddLive(const FlightLog& log, FlightArm& arm) {
  double sum_ms = 0;
  for (const FlightFrameRow& frame : log.frames) {
    if (log.arms[frame.arm] != arm.name) continue;
    ++arm.live_frame_count;
    sum_ms += frame.detection_ms;
  }
  if (arm.live_frame_count > 0) {
    arm.live_ms_mean = sum_ms / static_cast<double>(arm.live_frame_count);
  }
}

std::string ArmName(const FlightLog& log, uint32_t arm) {
  return text::PrintableLine(log.arms[arm]);
}

std::string DecisionText(const FlightLog& log, const FlightDecisionRow& row) {
  std::string text = "frame " + std::to_string(row.frame) + ": " + text::PrintableLine(row.outcome);
  if (row.candidate_arm) text += ", candidate " + ArmName(log, *row.candidate_arm);
  if (row.commanded_arm) {
    text += ", commanded " + ArmName(log, *row.commanded_arm) + " (" +
            text::PrintableLine(row.reason) + ")";
  }
  const auto leader = std::max_element(row.best_probability.begin(), row.best_probability.end());
  if (leader != row.best_probability.end()) {
    const auto arm = static_cast<uint32_t>(leader - row.best_probability.begin());
    text += ", " + ArmName(log, arm) + " is the best with probability " + Fixed(*leader, 2);
  }
  return text + '\n';
}

std::string SwitchesText(const FlightLog& log) {
  std::string text;
  for (size_t index = 1; index < log.frames.size(); ++index) {
    const FlightFrameRow& frame = log.frames[index];
    const FlightFrameRow& before = log.frames[index - 1];
    if (frame.arm == before.arm) continue;
    text += "frame " + std::to_string(frame.frame) + ": " + ArmName(log, before.arm) + " → " +
            ArmName(log, frame.arm) + '\n';
  }
  return text;
}

std::string ArmsText(const FlightReplay& replay) {
  TextTable table({"arm", "ms_mean", "ms_max", "ms_worst_frame", "live_frames", "live_ms_mean"});
  for (const FlightArm& arm : replay.arms) {
    table.AddRow({arm.name, Fixed(arm.ms_mean, 4), Fixed(arm.ms_max, 4), Fixed(arm.ms_worst, 4),
                  std::to_string(arm.live_frame_count),
                  arm.live_ms_mean ? Fixed(*arm.live_ms_mean, 4) : "-"});
  }
  return table.Text();
}

}  // namespace

Result<FlightLog> ReadFlightLog(const std::string& file) {
  const auto notes = RecordedNotes(file);
  if (!notes.ok()) return notes.status();
  const Json document = Json::parse(*notes, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object() || document.value("flight_recording", Json()) != 1) {
    return Status(
        StatusCode::kInvalidArgument,
        text::PrintableLine(file) +
            " was not written by a flight recorder, or by a newer one; `sweepstake-lab bench "
            "--scene` times any .aabbs file");
  }
  std::optional<FlightLog> log;
  std::string broken = "an arm index or a box number is out of range";
  try {
    log = LogOf(document);
  } catch (const Json::exception& error) {
    broken = error.what();
  }
  if (log && IsSound(*log)) return *std::move(log);
  return Status(StatusCode::kDataLoss, text::PrintableLine(file) + " has broken notes: " +
                                           text::PrintableLine(broken) + "; record it again");
}

Result<FlightReplay> ReplayFlight(const std::string& file) {
  auto log = ReadFlightLog(file);
  if (!log.ok()) return log.status();
  FlightReplay replay{.log = std::move(*log), .box_frame_count = 0, .arms = {}};
  replay.box_frame_count = BoxFrameCount(replay.log);
  // Structures are built on the boxes with number 0; step k searches the boxes with number k.
  const size_t steps = std::max<size_t>(replay.box_frame_count - 1, 1);
  const size_t worst = std::clamp<size_t>(WorstBoxes(replay.log), 1, steps) - 1;
  const auto times = TimeArms(file, steps);
  if (!times.ok()) return times.status();
  for (size_t index = 0; index < times->size(); ++index) {
    const TimeSummary summary = Summarize((*times)[index]);
    FlightArm arm{.name = std::string(BroadPhaseNames()[index]),
                  .ms_mean = summary.ms_mean,
                  .ms_max = *std::max_element((*times)[index].begin(), (*times)[index].end()),
                  .ms_worst = (*times)[index][worst],
                  .live_frame_count = 0,
                  .live_ms_mean = {}};
    AddLive(replay.log, arm);
    replay.arms.push_back(std::move(arm));
  }
  std::stable_sort(replay.arms.begin(), replay.arms.end(),
                   [](const FlightArm& a, const FlightArm& b) { return a.ms_mean < b.ms_mean; });
  return replay;
}

Json FlightReplayJson(const FlightReplay& replay, const std::string& file) {
  const FlightLog& log = replay.log;
  const FlightFrameRow& worst = log.frames[log.worst];
  Json document = {{"command", "replay"},
                   {"recording", file},
                   {"project", log.project},
                   {"scene", log.scene},
                   {"build", log.build},
                   {"machine_class", log.machine_class},
                   {"recorded_unix_ms", log.recorded_unix_ms},
                   {"frame_budget_ms", log.frame_budget_ms},
                   {"frames", log.frames.size()},
                   {"box_frames", replay.box_frame_count},
                   {"worst_frame",
                    {{"frame", worst.frame},
                     {"frame_ms", worst.frame_ms},
                     {"detection_ms", worst.detection_ms},
                     {"objects", worst.object_count},
                     {"pairs", worst.pair_count},
                     {"arm", log.arms[worst.arm]}}}};
  document["arms"] = Json::array();
  for (const FlightArm& arm : replay.arms) {
    document["arms"].push_back({{"arm", arm.name},
                                {"ms_mean", arm.ms_mean},
                                {"ms_max", arm.ms_max},
                                {"ms_worst_frame", arm.ms_worst},
                                {"live_frames", arm.live_frame_count},
                                {"live_ms_mean", OrNull(arm.live_ms_mean)}});
  }
  document["decisions"] = Json::array();
  for (const FlightDecisionRow& row : log.decisions) {
    const auto name = [&](std::optional<uint32_t> arm) {
      return arm ? Json(log.arms[*arm]) : Json();
    };
    document["decisions"].push_back({{"frame", row.frame},
                                     {"outcome", row.outcome},
                                     {"candidate", name(row.candidate_arm)},
                                     {"commanded", name(row.commanded_arm)},
                                     {"reason", row.reason},
                                     {"verdict", row.verdict},
                                     {"best_probability", row.best_probability}});
  }
  return document;
}

std::string FlightReplayText(const FlightReplay& replay, const std::string& file) {
  const FlightLog& log = replay.log;
  const FlightFrameRow& worst = log.frames[log.worst];
  std::string text = text::PrintableLine(file) + ": " + text::PrintableLine(log.scene) + " of " +
                     text::PrintableLine(log.project);
  if (!log.build.empty()) text += ", build " + text::PrintableLine(log.build);
  if (!log.machine_class.empty()) text += ", on " + text::PrintableLine(log.machine_class);
  text += "\nFrame " + std::to_string(worst.frame) + " took " + Fixed(worst.frame_ms, 1) +
          " ms (budget " + Fixed(log.frame_budget_ms, 1) + " ms): detection " +
          Fixed(worst.detection_ms, 3) + " ms with " + ArmName(log, worst.arm) + ", " +
          std::to_string(worst.object_count) + " objects, " + std::to_string(worst.pair_count) +
          " pairs\n" + std::to_string(log.frames.size()) + " frames, with boxes " +
          std::to_string(replay.box_frame_count) + "\n\nEvery arm on these boxes, here\n" +
          ArmsText(replay);
  const std::string switches = SwitchesText(log);
  text += "\nSwitches\n" + (switches.empty() ? "none\n" : switches) + "\nDecisions\n";
  if (log.decisions.empty()) text += "none\n";
  for (const FlightDecisionRow& row : log.decisions) text += DecisionText(log, row);
  return text;
}

}  // namespace sweepstake::cli
