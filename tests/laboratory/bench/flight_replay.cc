#include "tests/laboratory/bench/flight_replay.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/text/names.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/laboratory/bench/scene_timing.h"

namespace sweepstake::cli {
namespace {

constexpr int kPasses = 3;

// One frame in the recorder's notes, as engine_client/telemetry/common/flight_notes.cc writes it.
struct Frame {
  uint64_t number;
  double frame_ms;
  double detection_ms;
  uint64_t object_count;
  uint64_t pair_count;
  std::string arm;
  bool has_boxes;
};

// Returns the frames of the recorder's notes. The box sets of frames must be numbered 0, 1, 2, … in
// this order. Otherwise, or if no frame has boxes, the list is empty.
std::vector<Frame> FramesOf(const Json& notes) {
  std::vector<Frame> frames;
  size_t box_frame_count = 0;
  for (const Json& row : notes.at("frames")) {
    const Json& boxes = row.at(10);
    frames.push_back({row.at(0), row.at(1).get<double>() * 1e-6, row.at(2).get<double>() * 1e-6,
                      row.at(3), row.at(4), notes.at("arms").at(row.at(7).get<size_t>()),
                      !boxes.is_null()});
    if (!boxes.is_null() && boxes != box_frame_count++) frames.clear();
    if (frames.empty()) break;
  }
  if (box_frame_count == 0) frames.clear();
  return frames;
}

Json SwitchesOf(const std::vector<Frame>& frames) {
  Json switches = Json::array();
  for (size_t i = 1; i < frames.size(); ++i) {
    if (frames[i].arm == frames[i - 1].arm) continue;
    switches.push_back(
        {{"frame", frames[i].number}, {"from", frames[i - 1].arm}, {"to", frames[i].arm}});
  }
  return switches;
}

Json DecisionsOf(const Json& notes) {
  Json decisions = Json::array();
  for (const Json& row : notes.at("decisions")) {
    const auto name = [&](const char* key) {
      const Json& arm = row.at(key);
      return arm.is_null() ? Json() : notes.at("arms").at(arm.get<size_t>());
    };
    const auto chances = row.at("best_probability").get<std::vector<double>>();
    const auto leader = std::max_element(chances.begin(), chances.end()) - chances.begin();
    decisions.push_back(
        {{"frame", row.at("frame").get<uint64_t>()},
         {"outcome", row.at("outcome").get<std::string>()},
         {"candidate", name("candidate_arm")},
         {"commanded", name("commanded_arm")},
         {"reason", row.value("reason", "")},
         {"verdict", row.at("verdict").get<std::string>()},
         {"best_probability", chances},
         {"leader", chances.empty() ? Json() : notes.at("arms").at(static_cast<size_t>(leader))}});
  }
  return decisions;
}

Json DocumentOf(const Json& notes, const std::vector<Frame>& frames, size_t worst,
                const std::string& file) {
  Json document = {{"command", "replay"}, {"recording", file}};
  for (const char* key : {"project", "scene", "build", "machine_class"}) {
    document[key] = notes.at(key).get<std::string>();
  }
  document["recorded_unix_ms"] = notes.at("recorded_unix_ms").get<int64_t>();
  document["frame_budget_ms"] = notes.at("frame_budget_ms").get<double>();
  document["frames"] = frames.size();
  document["box_frames"] = std::count_if(frames.begin(), frames.end(),
                                         [](const Frame& frame) { return frame.has_boxes; });
  document["worst_frame"] = {{"frame", frames[worst].number},
                             {"frame_ms", frames[worst].frame_ms},
                             {"detection_ms", frames[worst].detection_ms},
                             {"objects", frames[worst].object_count},
                             {"pairs", frames[worst].pair_count},
                             {"arm", frames[worst].arm}};
  document["arms"] = Json::array();
  document["switches"] = SwitchesOf(frames);
  document["decisions"] = DecisionsOf(notes);
  return document;
}

// Returns the time of each arm in each step of the scene: the minimum of several passes, because
// other work on the machine can only add time.
Result<std::vector<std::vector<double>>> TimeArms(const std::string& file, uint64_t steps) {
  std::vector<std::vector<double>> least(BroadPhaseNames().size(),
                                         std::vector<double>(steps, 1e300));
  for (int pass = 0; pass < kPasses; ++pass) {
    auto scene = MakeScene(file, {});
    if (!scene.ok()) return scene.status();
    std::vector<Contestant> contestants;
    for (const std::string_view arm : BroadPhaseNames()) {
      contestants.push_back({.broad_phase = std::move(*MakeBroadPhase(arm))});
    }
    const auto timings =
        TimeScene(**scene, contestants, {.warmup = 0, .frames = steps}, [](size_t, uint64_t) {});
    for (size_t arm = 0; arm < least.size(); ++arm) {
      for (size_t step = 0; step < steps; ++step) {
        least[arm][step] = std::min(least[arm][step], timings[arm].step_ms[step]);
      }
    }
  }
  return least;
}

Json ArmJson(const std::string& arm, const std::vector<double>& step_ms, size_t worst_step,
             const std::vector<Frame>& frames) {
  std::vector<double> live_ms;
  for (const Frame& frame : frames) {
    if (frame.arm == arm) live_ms.push_back(frame.detection_ms);
  }
  return {{"arm", arm},
          {"ms_mean", Mean(step_ms)},
          {"ms_max", *std::max_element(step_ms.begin(), step_ms.end())},
          {"ms_worst_frame", step_ms[worst_step]},
          {"live_frames", live_ms.size()},
          {"live_ms_mean", live_ms.empty() ? Json() : Json(Mean(live_ms))}};
}

// Returns one of the recording's texts without control characters.
std::string Line(const Json& text) { return text::PrintableLine(text.get<std::string>()); }

std::string Number(const Json& number, int decimals) {
  return number.is_null() ? "-" : Fixed(number.get<double>(), decimals);
}

std::string DecisionText(const Json& row) {
  std::string text = "frame " + row["frame"].dump() + ": " + Line(row["outcome"]);
  if (!row["candidate"].is_null()) text += ", candidate " + Line(row["candidate"]);
  if (!row["commanded"].is_null()) {
    text += ", commanded " + Line(row["commanded"]) + " (" + Line(row["reason"]) + ")";
  }
  if (!row["leader"].is_null()) {
    const auto chances = row["best_probability"].get<std::vector<double>>();
    text += ", " + Line(row["leader"]) + " is the best with probability " +
            Fixed(*std::max_element(chances.begin(), chances.end()), 2);
  }
  return text + '\n';
}

}  // namespace

Result<Json> ReplayFlight(const std::string& file) {
  const auto text = RecordedNotes(file);
  if (!text.ok()) return text.status();
  const Json notes = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!notes.is_object() || notes.value("flight_recording", Json()) != 1) {
    return Status(
        StatusCode::kInvalidArgument,
        text::PrintableLine(file) +
            " was not written by a flight recorder, or the recorder is newer than this program; "
            "`sweepstake-lab bench "
            "--scene` times any .aabbs file");
  }
  Json document;
  std::vector<Frame> frames;
  size_t worst = 0;
  std::string broken = "a box number is out of order";
  try {
    frames = FramesOf(notes);
    const auto number = notes.at("worst_frame").get<uint64_t>();
    while (worst + 1 < frames.size() && frames[worst].number != number) ++worst;
    if (!frames.empty()) document = DocumentOf(notes, frames, worst, file);
  } catch (const Json::exception& error) {
    broken = error.what();
  }
  if (document.is_null()) {
    return Status(StatusCode::kDataLoss, text::PrintableLine(file) +
                                             " has invalid data of the flight recorder: " +
                                             text::PrintableLine(broken) + "; record it again");
  }
  // The structures are built on the first recorded boxes; step k updates them to the boxes with
  // number k. If the longest frame has no boxes, the next frame with boxes is used in its place.
  const size_t steps = std::max<size_t>(document["box_frames"].get<size_t>() - 1, 1);
  const auto worst_boxes = static_cast<size_t>(
      std::count_if(frames.begin(), frames.begin() + static_cast<ptrdiff_t>(worst),
                    [](const Frame& frame) { return frame.has_boxes; }));
  const size_t worst_step = std::clamp<size_t>(worst_boxes, 1, steps) - 1;
  const auto times = TimeArms(file, steps);
  if (!times.ok()) return times.status();
  Json& arms = document["arms"];
  for (size_t i = 0; i < times->size(); ++i) {
    arms.push_back(ArmJson(std::string(BroadPhaseNames()[i]), (*times)[i], worst_step, frames));
  }
  std::stable_sort(arms.begin(), arms.end(),
                   [](const Json& a, const Json& b) { return a["ms_mean"] < b["ms_mean"]; });
  return document;
}

std::string FlightReplayText(const Json& document) {
  const Json& worst = document["worst_frame"];
  std::string text = Line(document["recording"]) + ": " + Line(document["scene"]) + " of " +
                     Line(document["project"]);
  if (document["build"] != "") text += ", build " + Line(document["build"]);
  if (document["machine_class"] != "") text += ", on " + Line(document["machine_class"]);
  text += "\nFrame " + worst["frame"].dump() + " took " + Number(worst["frame_ms"], 1) +
          " ms (budget " + Number(document["frame_budget_ms"], 1) + " ms): detection " +
          Number(worst["detection_ms"], 3) + " ms with " + Line(worst["arm"]) + ", " +
          worst["objects"].dump() + " objects, " + worst["pairs"].dump() + " pairs\n" +
          document["frames"].dump() + " frames, " + document["box_frames"].dump() +
          " of them with boxes\n\nEvery arm on these boxes, timed on this machine\n";
  TextTable table({"arm", "ms_mean", "ms_max", "ms_worst_frame", "live_frames", "live_ms_mean"});
  for (const Json& arm : document["arms"]) {
    table.AddRow({arm["arm"], Number(arm["ms_mean"], 4), Number(arm["ms_max"], 4),
                  Number(arm["ms_worst_frame"], 4), arm["live_frames"].dump(),
                  Number(arm["live_ms_mean"], 4)});
  }
  text += table.Text() + "\nSwitches\n" + (document["switches"].empty() ? "none\n" : "");
  for (const Json& row : document["switches"]) {
    text +=
        "frame " + row["frame"].dump() + ": " + Line(row["from"]) + " → " + Line(row["to"]) + '\n';
  }
  text += std::string("\nDecisions\n") + (document["decisions"].empty() ? "none\n" : "");
  for (const Json& row : document["decisions"]) text += DecisionText(row);
  return text;
}

}  // namespace sweepstake::cli
