#include "tests/laboratory/laboratory.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine_client/cli/io/json_output.h"
#include "tests/laboratory/bench/flight_replay.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/replay/replay_output.h"

namespace sweepstake::cli {
namespace {

struct ReplayCommandOptions {
  ReplayRequest request;
  std::string log_file;
  std::string recording;
  bool json = false;
};

int ReplayTraces(const ReplayCommandOptions& options, Terminal& terminal) {
  const auto plan = MakeReplayPlan(options.request);
  if (!plan.ok()) return Fail(terminal, plan.status());
  ReplayReport report{plan->scenes, plan->study, {}};
  {
    Progress progress(terminal, "replay");
    const auto show = OnShareWithTimeLeft(progress);
    report.rows = RunStudy(plan->scenes, plan->study, [&](uint64_t done, uint64_t all) {
      show(static_cast<double>(done) / static_cast<double>(all),
           std::to_string(done) + " of " + std::to_string(all) + " games");
    });
  }
  if (options.json) {
    PrintReplayJson(report, terminal.out);
  } else {
    PrintReplayTable(report, terminal.out);
  }
  return kDone;
}

int RederiveLog(const ReplayCommandOptions& options, Terminal& terminal) {
  const auto report = ReplayLog(options.log_file);
  if (!report.ok()) return Fail(terminal, report.status());
  PrintResult(terminal, options.json, ReplayLogJson(*report, options.log_file),
              ReplayLogText(*report));
  return report->difference ? kCheckFailed : kDone;
}

int ReplayRecording(const ReplayCommandOptions& options, Terminal& terminal) {
  const auto replay = ReplayFlight(options.recording);
  if (!replay.ok()) return Fail(terminal, replay.status());
  PrintResult(terminal, options.json, *replay, FlightReplayText(*replay));
  return kDone;
}

int RunReplay(const ReplayCommandOptions& options, Terminal& terminal) {
  const int given_count = (options.request.costs.empty() ? 0 : 1) +
                          (options.log_file.empty() ? 0 : 1) + (options.recording.empty() ? 0 : 1);
  if (given_count != 1) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument,
                                 "give exactly one of --costs FILE.costs, --log FILE.csv and "
                                 "--recording FILE.aabbs"));
  }
  if (!options.recording.empty()) return ReplayRecording(options, terminal);
  return options.log_file.empty() ? ReplayTraces(options, terminal)
                                  : RederiveLog(options, terminal);
}

void Declare(CLI::App& command, ReplayCommandOptions& options) {
  ReplayRequest& request = options.request;
  StudyOptions& study = request.study;
  study.thread_count = std::max(std::thread::hardware_concurrency(), 1U);
  command.add_option("--costs", request.costs, "Cost traces, made by `sweepstake-lab trace`")
      ->delimiter(',');
  command.add_option("--log", options.log_file,
                     "Audit log in CSV; derive each of its decisions again and compare");
  command.add_option("--recording", options.recording,
                     "Time every arm on the frames of a flight recorder, and show its switches "
                     "and decisions");
  command
      .add_option(
          "--policy", request.policies,
          "Policies, or all of them; ablations (AI Decides without one of its parts), fixed (each "
          "arm without switches), fixed:ARM, oracle (the best sequence of arms)")
      ->delimiter(',');
  command.add_option("--seeds", study.seed_count, "Games of each policy on each trace")
      ->check(CLI::Range(uint32_t{1}, uint32_t{100'000}));
  command.add_option("--run", request.run, "Virtual time of a game if it uses the best fixed arm");
  command
      .add_option("--pass", request.passes,
                  "Virtual time of one pass through the trace (default: the run), for all traces "
                  "or one for each")
      ->delimiter(',');
  AddDecisionOptions(command, study.decision);
  command.add_flag("--no-shadow", request.no_shadow,
                   "Disable the shadow lane of the policies that learn from it");
  LaneErrors& errors = study.lane_errors;
  const auto add = [&command](const char* name, double& value, double min, double max,
                              const char* description) {
    command.add_option(name, value, description)->check(CLI::Range(min, max));
  };
  command
      .add_option("--lane-ratio", request.lane_ratios,
                  "Time of an arm in the shadow lane ÷ on the frame thread (default: 1)")
      ->type_name("ARM RATIO");
  add("--lane-bias", errors.bias_deviation, 0.0, 2.0,
      "Standard deviation of that ratio's logarithm between arms; random in each game");
  add("--lane-noise", errors.noise_deviation, 0.0, 2.0,
      "Standard deviation of the logarithm of the times of one arm's visits");
  add("--lane-spikes", errors.spike_ratio, 0.0, 1.0,
      "Share of visits that are interrupted (Pareto, shape 1.5)");
  add("--lane-contention", errors.contention_ratio, 1.0, 10.0,
      "Frame time during a visit of the lane ÷ frame time without one");
  add("--frame-load", study.frame_load.ratio, 1.0, 100.0,
      "Frame time with other work on the frame thread's core ÷ without it; not counted "
      "in the regret");
  add("--frame-load-share", study.frame_load.share, 0.001, 0.999,
      "Share of the time with that work, in stretches of 10 s on average");
  command
      .add_option(
          "--priors", request.priors,
          "Priors from another game: of the same scene (right), with the ranking of the arms "
          "reversed "
          "(wrong), on another class of machines (class), or of all other traces (scenes; none if "
          "there is only one trace)")
      ->check(OneOf(kReplayPriorsNames));
  command.add_option("--threads", study.thread_count, "Games played in parallel")
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}));
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddReplayCommand(const CommandContext& context) {
  std::string policies;
  for (const std::string_view name : decision::PolicyNames(decision::StudyPolicies()))
    policies.append(" ").append(name);
  AddCommand<ReplayCommandOptions>(
      context, "replay",
      "Replay cost traces in virtual time, the decisions of an audit log, or a flight recording",
      "  sweepstake-lab replay --costs hurricane.costs --policy default,paper,fixed --seeds 200\n"
      "  sweepstake-lab replay --costs a.costs,b.costs --policy default,oracle --priors wrong "
      "--json\n"
      "  sweepstake-lab replay --costs a.costs --policy fixed:SAP,default --pass 3m "
      "--json\n"
      "  sweepstake-lab replay --log decisions.csv\n"
      "  sweepstake-lab replay --recording flight-20261123-234641-250.aabbs\n"
      "Policies:" +
          policies +
          "\nRegret is frame time ÷ that of the best fixed arm on the same frames, minus 1; less "
          "is better.\n",
      Declare, RunReplay);
}

}  // namespace sweepstake::cli
