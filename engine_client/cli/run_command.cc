// `sweepstake run`: runs a scene on the frame path. The arm is chosen by a daemon, the embedded
// decider or the user.
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/game/live_view.h"
#include "engine_client/cli/game/run_report.h"
#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/process.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/telemetry/daemon_session.h"
#include "sweepstake/machine_class.h"
#include "sweepstake/session.h"

namespace sweepstake::cli {
namespace {

constexpr uint32_t kStopDeadlineMs = 2000;
constexpr uint32_t kViewFps = 60;  // a step of a scene is 1/60 s, so it moves at its own speed
constexpr std::array<std::string_view, 2> kModes = {"ai", "manual"};
constexpr std::array<std::string_view, 3> kShadowModes = {"auto", "on", "off"};

struct RunOptions {
  SceneChoice scene{"hurricane", 3000, 1};
  std::string mode = "ai";
  std::string arm;
  DaemonOptions daemon;
  bool embedded = false;
  std::string priors;
  std::string duration = "60s";
  // 0: frames follow each other without waiting. Absent: 0, or kViewFps with --view.
  std::optional<uint32_t> fps;
  SessionOptions session = DefaultSession();
  std::string shadow = "auto";
  std::string csv;
  bool json = false;
  bool view = false;

  static SessionOptions DefaultSession() {
    SessionOptions session;
    session.scene.clear();  // set later, when the number of objects is known
    session.machine_class = MachineClass();
    session.flight_recorder.directory = ".";
    return session;
  }
};

// Completes the session's options with the scene's name in the prior store, the seed, and the
// credentials.
SessionOptions SessionOf(const RunOptions& options, size_t object_count) {
  SessionOptions session = options.session;
  if (session.scene.empty()) {
    session.scene = std::filesystem::path(options.scene.name).stem().string() + "-" +
                    std::to_string(object_count);
  }
  session.seed = options.scene.seed;
  session.tls = options.daemon.tls;
  session.token = options.daemon.token;
  return session;
}

// Makes the session. If `decisions` is not null, the embedded decider writes one line per decision
// to it.
Result<std::unique_ptr<Session>> MakeSession(const RunOptions& options,
                                             const SessionOptions& session, WholeFile* decisions) {
  if (!options.embedded)
    return MakeDaemonSession(options.daemon.address, session, TlsOptionNames());
  EmbeddedOptions embedded;
  if (!session.policy.empty()) embedded.policy = session.policy;
  embedded.project = session.project;
  embedded.scene = session.scene;
  embedded.build = session.build;
  embedded.machine_class = session.machine_class;
  if (!session.ignore_priors) embedded.priors_file = options.priors;
  embedded.seed = session.seed;
  embedded.time_scale = session.time_scale;
  const DecisionRules& rules = session.rules;
  embedded.weights = rules.weights.value_or(embedded.weights);
  embedded.decision_interval_ns =
      rules.decision_interval_ns.value_or(embedded.decision_interval_ns);
  embedded.cooldown_ns = rules.cooldown_ns.value_or(embedded.cooldown_ns);
  embedded.settling_ns = rules.settling_ns.value_or(embedded.settling_ns);
  embedded.mode = options.mode == "ai" ? Mode::kAi : Mode::kManual;
  if (decisions != nullptr) {
    embedded.on_audit_row = [decisions](std::string_view row) {
      decisions->Write(row);
      decisions->Write("\n");
    };
  }
  return MakeEmbeddedSession(embedded, session);
}

// The files that --csv writes during the run. Both are null without --csv.
struct RunLogs {
  std::unique_ptr<WholeFile> frames;
  // Null with a daemon, because the daemon keeps the log of decisions.
  std::unique_ptr<WholeFile> decisions;

  Status Commit() {
    if (frames == nullptr) return {};
    Status status = frames->Commit();
    return status.ok() && decisions != nullptr ? decisions->Commit() : status;
  }
};

// Makes the folder given by --csv, and in it frames.csv and decisions.csv.
Result<RunLogs> MakeLogs(const RunOptions& options) {
  RunLogs logs;
  if (options.csv.empty()) return logs;
  const std::filesystem::path folder = options.csv;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Status(StatusCode::kInvalidArgument,
                  options.csv + " cannot be created as a folder: " + error.message() +
                      "; give --csv a folder, or a path that does not exist yet");
  }
  auto frames = WholeFile::Create(folder / "frames.csv");
  if (!frames.ok()) return frames.status();
  logs.frames = std::move(*frames);
  WriteFrameHeader(*logs.frames);
  if (!options.embedded) return logs;
  auto decisions = WholeFile::Create(folder / "decisions.csv");
  if (!decisions.ok()) return decisions.status();
  logs.decisions = std::move(*decisions);
  logs.decisions->Write(decision::AuditHeader() + '\n');
  return logs;
}

uint64_t FrameIntervalNs(const RunOptions& options) {
  const uint32_t fps = options.fps.value_or(options.view ? kViewFps : 0);
  return fps == 0 ? 0 : 1'000'000'000 / fps;
}

ShadowMode ToShadowMode(const std::string& word) {
  if (word == "off") return ShadowMode::kOff;
  return word == "on" ? ShadowMode::kOn : ShadowMode::kAuto;
}

std::string StateText(const SessionStats& stats) {
  switch (stats.state) {
    case ConnectionState::kOffline:
      return "offline: " + (stats.last_error.empty() ? "not connected yet" : stats.last_error);
    case ConnectionState::kConnecting:
      return "connecting";
    case ConnectionState::kOnline:
      return "online";
    case ConnectionState::kEmbedded:
      return "embedded";
    case ConnectionState::kClosed:
      return "closed";
  }
  return "";
}

// Returns whether the terminal may show colours (https://no-color.org).
bool HasColours() {
  const char* const no_color = std::getenv("NO_COLOR");
  return no_color == nullptr || *no_color == '\0';
}

// Runs the frame loop, and prints events and the progress. With a view, it shows the scene instead,
// and prints the events at the end.
class Player {
 public:
  Player(const RunSetup& setup, GameRun& run, const Session& session, WholeFile* log,
         Terminal& terminal, uint64_t duration_ns, const RunOptions& options)
      : setup_(setup),
        run_(run),
        session_(session),
        log_(log),
        terminal_(terminal),
        duration_ns_(duration_ns),
        json_(options.json),
        progress_(terminal, "run", duration_ns / 1'000'000) {
    if (!options.view) return;
    CatchSuspendSignal();
    view_.emplace(terminal.out, terminal.out_size, HasColours(), run);
  }

  void Play() {
    while (run_.elapsed_ns() < duration_ns_ && !StopRequested() && refusal_.empty()) {
      if (run_.Frame()) SaySwitch();
      if (run_.verdicts().size() > said_verdict_count_) SayVerdict();
      if (log_ != nullptr) WriteFrame(run_.adaptive().last_sample(), run_.adaptive(), *log_);
      if (!priors_said_ && run_.elapsed_ns() >= next_look_ns_) LookForAnswer();
      if (view_) {
        if (SuspendRequested()) view_->Suspend();
        if (view_->due()) DrawView();
      } else if (progress_.due()) {
        ShowProgress();
      }
    }
    if (!view_) return;
    view_.reset();
    ReleaseSuspendSignal();
    PrintText(terminal_, events_);
  }

  // Call it after the session has stopped. In a short run, the decider's answer about priors may
  // arrive only then.
  void End() {
    if (!priors_said_) LookForAnswer();
  }

  // Returns why the daemon refused the session; empty if it did not.
  const std::string& refusal() const { return refusal_; }

 private:
  // Prints which priors the session starts from, as soon as the decider has answered.
  void LookForAnswer() {
    constexpr uint64_t kLookIntervalNs = 50'000'000;
    next_look_ns_ = run_.elapsed_ns() + kLookIntervalNs;
    const SessionStats stats = session_.stats();
    if (stats.connection_count == 0) refusal_ = stats.refusal;
    if (stats.state != ConnectionState::kEmbedded && stats.connection_count == 0) return;
    Say(PriorsText(setup_, stats));
    priors_said_ = true;
  }

  void SaySwitch() {
    Say(SwitchText(ToRow(run_.switches().back(), run_.adaptive())));
    const SessionStats stats = session_.stats();
    if (view_) view_->NoteSwitch(stats);
    const std::string beliefs = BeliefsText(stats.beliefs);
    if (!beliefs.empty()) Say("       " + beliefs);
  }

  void SayVerdict() {
    const VerdictEvent& event = run_.verdicts().back();
    said_verdict_count_ = run_.verdicts().size();
    Say(VerdictChangeText(ToRow(event, run_.adaptive())));
  }

  void DrawView() {
    const SessionStats stats = session_.stats();
    view_->Draw(stats, StateText(stats));
  }

  void ShowProgress() {
    const uint64_t now_ns = run_.elapsed_ns();
    const double fps = 1e9 * static_cast<double>(run_.frame_count() - shown_frames_) /
                       static_cast<double>(std::max<uint64_t>(now_ns - shown_ns_, 1));
    shown_frames_ = run_.frame_count();
    shown_ns_ = now_ns;
    const SessionStats stats = session_.stats();
    const std::string beliefs = BeliefsText(stats.beliefs);
    progress_.Show(now_ns / 1'000'000, run_.adaptive().arms()[run_.adaptive().active_arm()] + ", " +
                                           Fixed(fps, 0) + " frames/s, " + StateText(stats) +
                                           (beliefs.empty() ? "" : "; " + beliefs));
  }

  void Say(const std::string& line) {
    if (view_) {
      events_ += line + '\n';
    } else if (json_) {
      progress_.Line(line);
    } else {
      progress_.ClearBar();
      PrintText(terminal_, line + '\n');
    }
  }

  const RunSetup& setup_;
  GameRun& run_;
  const Session& session_;
  WholeFile* const log_;
  Terminal& terminal_;
  const uint64_t duration_ns_;
  const bool json_;
  Progress progress_;
  std::optional<LiveView> view_;
  std::string events_;  // lines to print after the view
  uint64_t next_look_ns_ = 0;
  // Frame count and time at the latest update of the progress.
  uint64_t shown_frames_ = 0;
  uint64_t shown_ns_ = 0;
  size_t said_verdict_count_ = 0;
  bool priors_said_ = false;
  std::string refusal_;
};

int Report(const RunOptions& options, const RunSummary& summary, RunLogs& logs,
           Terminal& terminal) {
  PrintResult(terminal, options.json, RunReportJson(summary), RunReportText(summary));
  if (!options.csv.empty()) {
    Status status = logs.Commit();
    if (status.ok()) status = WriteRunReportCsv(summary, options.csv);
    if (!status.ok()) return Fail(terminal, status);
  }
  if (options.embedded || summary.session.connection_count > 0) return kDone;
  return Fail(
      terminal,
      Status(StatusCode::kUnavailable,
             "no session with " + options.daemon.address + ": " + summary.session.last_error +
                 ". The run continued without a decider. If no daemon is running there, start one "
                 "with sweepstaked --listen " +
                 options.daemon.address + ", or use --embedded"));
}

Status CheckRun(const RunOptions& options, const Terminal& terminal) {
  if (options.view && !terminal.out_is_tty) {
    return {StatusCode::kInvalidArgument,
            "--view needs a terminal on stdout; run it in a terminal, or leave --view out"};
  }
  if (options.embedded == !options.daemon.address.empty()) {
    return {StatusCode::kInvalidArgument, "give either --daemon HOST:PORT or --embedded"};
  }
  const std::string& policy = options.session.policy;
  const decision::PolicyEntry* entry = decision::FindPolicy(
      policy.empty() && options.embedded ? "default" : policy, decision::ShippedPolicies());
  if (options.session.rules.weights && entry != nullptr && entry->kind.goes_by_cost()) {
    return {StatusCode::kInvalidArgument,
            "--weights needs --policy paper: AI Decides uses the detection time alone"};
  }
  if (!options.priors.empty() && !options.embedded) {
    return {StatusCode::kInvalidArgument,
            "--priors needs --embedded: a daemon uses its own priors"};
  }
  if (options.session.allow_operator_orders && options.embedded) {
    return {StatusCode::kInvalidArgument,
            "--allow-orders needs --daemon: only operators of a daemon send orders"};
  }
  if (options.session.allow_box_view && options.embedded) {
    return {StatusCode::kInvalidArgument,
            "--allow-box-view needs --daemon: only operators of a daemon view boxes"};
  }
  return {};
}

int RunRun(const RunOptions& options, Terminal& terminal) {
  if (const Status status = CheckRun(options, terminal); !status.ok())
    return Fail(terminal, status);
  const auto duration_ns = ParseDuration(options.duration);
  if (!duration_ns.ok()) return Fail(terminal, duration_ns.status());
  auto scene = OpenScene(options.scene);
  if (!scene.ok()) return Fail(terminal, scene.status());
  RunSetup setup{options.scene, options.mode,
                 options.embedded ? "embedded" : options.daemon.address, "", ""};
  setup.scene.object_count = static_cast<uint32_t>((*scene)->max_object_count());
  const SessionOptions chosen = SessionOf(options, setup.scene.object_count);
  if (!chosen.ignore_priors) setup.priors_file = options.priors;
  setup.priors_key = "project " + chosen.project + ", scene " + chosen.scene + ", machines " +
                     chosen.machine_class;
  // The logs are made before the session and so outlive it, because it writes to them until its
  // end.
  auto logs = MakeLogs(options);
  if (!logs.ok()) return Fail(terminal, logs.status());
  auto session = MakeSession(options, chosen, logs->decisions.get());
  if (!session.ok()) return Fail(terminal, session.status());
  AdaptiveOptions adaptive;
  adaptive.initial_arm = options.arm;
  adaptive.mode = options.mode == "ai" ? Mode::kAi : Mode::kManual;
  adaptive.shadow = ScaledShadow(ToShadowMode(options.shadow), chosen.time_scale);
  auto run = GameRun::Create(adaptive, **scene, (*session)->sink(), FrameIntervalNs(options));
  if (!run.ok()) return Fail(terminal, run.status());
  const Status started = (*session)->Start((*run)->adaptive());
  if (!started.ok()) return Fail(terminal, started);
  InstallStopSignal();
  Player player(setup, **run, **session, logs->frames.get(), terminal, *duration_ns, options);
  player.Play();
  (*session)->Stop(kStopDeadlineMs);
  player.End();
  if (!player.refusal().empty()) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument,
                                 "the daemon at " + options.daemon.address +
                                     " refuses the session: " + player.refusal()));
  }
  return Report(options, Summarize(setup, **run, (*session)->stats()), *logs, terminal);
}

void DeclareFlightRecorder(CLI::App& command, FlightRecorderOptions& options) {
  command
      .add_option("--flight-recorder", options.memory_mb,
                  "Memory in MiB for the boxes of the last 5 s, which are written to a file after "
                  "a frame over --frame-budget, for `sweepstake-lab replay --recording`; 0: off")
      ->check(WholeUpTo(1024));
  command
      .add_option("--frame-budget", options.frame_budget_ms,
                  "Frame time in ms above which the flight recorder writes a file")
      ->check(RealFrom(0.001, 60'000.0));
  command
      .add_option("--flight-folder", options.directory,
                  "Folder for the files of the flight recorder")
      ->check(CLI::ExistingDirectory);
}

void Declare(CLI::App& command, RunOptions& options) {
  command.add_option("--scene", options.scene.name, "Scene or .aabbs file");
  command.add_option("--objects", options.scene.object_count, "Object count");
  AddSeedOption(command, options.scene.seed, "the scene and of the decisions");
  command
      .add_option("--mode", options.mode,
                  "ai: the decider chooses the arm; manual: --arm stays active")
      ->check(OneOf(kModes));
  command.add_option("--arm", options.arm, "Arm to start with (default: KDTree)");
  AddDaemonOptions(command, options.daemon)->required(false);
  command.add_flag("--embedded", options.embedded, "Decide in this process, without a daemon");
  command.add_option("--priors", options.priors, "Priors file for --embedded");
  command.add_option("--duration", options.duration,
                     "Duration of the run, such as 500ms, 60s or 15m");
  command
      .add_option(
          "--fps", options.fps,
          "Maximum frames per second, as with vertical sync; 0: unlimited (default: 0, with --view "
          "60)")
      ->check(WholeUpTo(1000));
  command.add_option("--policy", options.session.policy,
                     "Policy: adaptive (compares expected costs), or paper (Thompson sampling) "
                     "(default: the decider's, adaptive)");
  command
      .add_option("--time-scale", options.session.time_scale,
                  "Divides every interval of the decider except the bail-out limit; a daemon must "
                  "allow it with --max-time-scale")
      ->check(RealFrom(1.0, 1000.0));
  AddDecisionOptions(command, options.session.rules);
  command.add_option("--project", options.session.project, "Project the priors belong to");
  command.add_option("--scene-name", options.session.scene,
                     "Scene the priors belong to (default: SCENE-OBJECTS)");
  command.add_option("--build", options.session.build, "Build of the game (default: unknown)");
  command.add_option("--machine-class", options.session.machine_class,
                     "Class of machines with comparable timings");
  command.add_flag("--ignore-priors", options.session.ignore_priors,
                   "Start without priors, from Beta(1,1)");
  command.add_flag("--allow-orders", options.session.allow_operator_orders,
                   "Follow `sweepstake sessions pin` and `release` from the daemon");
  command.add_flag("--allow-box-view", options.session.allow_box_view,
                   "Send the objects' boxes to operators who view the session in the dashboard");
  DeclareFlightRecorder(command, options.session.flight_recorder);
  command
      .add_option("--shadow", options.shadow,
                  "Shadow lane, which measures inactive arms and prepares switches; auto: in mode "
                  "ai, if a core is free and the policy learns from it (paper does not); on: in "
                  "mode manual and with paper too")
      ->check(OneOf(kShadowModes));
  command.add_option(
      "--csv", options.csv,
      "Folder for frames.csv, switches.csv, posteriors.csv and, with --embedded, decisions.csv");
  AddJsonFlag(command, options.json);
  command
      .add_flag("--view", options.view,
                "Draw the scene in the terminal: boxes, active arm, P(best) of each arm")
      ->excludes("--json");
}

}  // namespace

void AddRunCommand(const CommandContext& context) {
  AddCommand<RunOptions>(
      context, "run", "Run a scene on the frame path and let a decider choose the arm",
      "  sweepstake run --scene hurricane --objects 3000 --mode ai --embedded --duration 60s\n"
      "  sweepstake run --scene hurricane --objects 2000 --arm BruteForce --embedded --view\n"
      "  sweepstake run --scene suite-g --objects 2000 --daemon 127.0.0.1:7433\n"
      "  sweepstake run --scene h.aabbs --mode manual --arm SAP --embedded --csv out\n"
      "  sweepstake run --scene suite-g --objects 2000 --daemon 127.0.0.1:7433 --allow-orders\n"
      "  sweepstake run --scene suite-h --objects 1000 --daemon 127.0.0.1:7433 --fps 60 --duration "
      "1h\n"
      "Ctrl-C ends the run and prints the report. --view draws between frames, so that no\n"
      "frame time or detection time includes it. NO_COLOR=1 turns its colours off.\n"
      "Exit code 3 if the daemon was never reached; the run continues without it. Exit code 2\n"
      "if the daemon refuses the session, for example because it has no such policy.",
      Declare, RunRun);
}

}  // namespace sweepstake::cli
