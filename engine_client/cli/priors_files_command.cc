// `sweepstake priors show|doctor|diff|merge|arm` works on priors files. It shows a file, checks
// which part counts on this machine, compares or merges two files, and prints the arm that a file
// would choose.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/cli/priors/priors_doctor.h"
#include "engine_client/cli/priors/priors_text.h"
#include "engine_client/decider/embedded/evidence_ledger.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/text/counts.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/machine_class.h"

namespace sweepstake::cli {
namespace {

using Records = std::vector<PriorRecord>;

struct PriorsFileOptions {
  std::string file;
  std::string other_file;
  std::string out;
  std::string project;
  std::string scene;
  std::string build;
  std::string other_build;
  std::string machine_class = MachineClass();
  bool json = false;
};

decision::ArmVersions OwnVersions() {
  decision::ArmVersions versions;
  for (const std::string_view arm : BroadPhaseNames())
    versions.emplace(arm, (*MakeBroadPhase(arm))->version());
  return versions;
}

int RunShow(const PriorsFileOptions& options, Terminal& terminal) {
  const auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const decision::PriorsGroups groups = decision::GroupPriors(*records);
  const Json document = {
      {"command", "priors show"}, {"file", options.file}, {"scenes", ShowJson(groups)}};
  PrintResult(terminal, options.json, document,
              groups.empty() ? options.file + " has no records\n" : ShowText(groups));
  return kDone;
}

std::vector<Diagnosed> Diagnose(const Records& records, const PriorsFileOptions& options) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const decision::ArmVersions own = OwnVersions();
  return DiagnosePriors(decision::GroupPriors(records, own),
                        {.machine_class = options.machine_class,
                         .build = options.build,
                         .reward_version = decision::kLogCostRewardVersion,
                         .arm_versions = own,
                         .unix_now_s = static_cast<uint64_t>(
                             std::chrono::duration_cast<std::chrono::seconds>(now).count())});
}

bool Counts(const Diagnosed& one) { return one.fitness != Fitness::kForeign; }

int RunDoctor(const PriorsFileOptions& options, Terminal& terminal) {
  const auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const std::vector<Diagnosed> diagnosed = Diagnose(*records, options);
  const Json document = {{"command", "priors doctor"},
                         {"file", options.file},
                         {"machine_class", options.machine_class},
                         {"build", options.build},
                         {"entries", DoctorJson(diagnosed)}};
  PrintResult(terminal, options.json, document,
              diagnosed.empty() ? options.file + " has no records\n" : DoctorText(diagnosed));
  return std::any_of(diagnosed.begin(), diagnosed.end(), Counts) ? kDone : kCheckFailed;
}

// Returns whether any record is of the build `build`. An empty `build` stands for all builds.
bool HasBuild(const Records& records, const std::string& build) {
  return build.empty() || std::any_of(records.begin(), records.end(),
                                      [&](const auto& record) { return record.build == build; });
}

Status NoSuchBuild(const std::string& file, const Records& records, const std::string& build) {
  std::set<std::string> builds;
  for (const PriorRecord& record : records) builds.insert(record.build);
  builds.erase("");
  std::string names;
  for (const std::string& name : builds) names += (names.empty() ? "; builds: " : " ") + name;
  return {StatusCode::kNotFound, file + " has no evidence of build " + build + names};
}

// Returns the records of one build, or of all builds if `build` is empty, with their build removed
// so that they form one group. Quarantined records count too, so that a diff shows what their
// promotion would change.
Records OfBuild(Records records, const std::string& build) {
  std::erase_if(records,
                [&](const PriorRecord& record) { return !build.empty() && record.build != build; });
  for (PriorRecord& record : records) {
    record.build.clear();
    record.is_quarantined = false;
  }
  return records;
}

int RunDiff(const PriorsFileOptions& options, Terminal& terminal) {
  auto before = ReadPriorsFile(options.file);
  if (!before.ok()) return Fail(terminal, before.status());
  auto after = ReadPriorsFile(options.other_file);
  if (!after.ok()) return Fail(terminal, after.status());
  for (const auto& [file, records, build] :
       {std::tie(options.file, *before, options.build),
        std::tie(options.other_file, *after, options.other_build)}) {
    if (!HasBuild(records, build)) return FailAnswer(terminal, NoSuchBuild(file, records, build));
  }
  const std::vector<decision::SceneComparison> changes =
      decision::DiffPriors(decision::GroupPriors(OfBuild(*std::move(before), options.build)),
                           decision::GroupPriors(OfBuild(*std::move(after), options.other_build)));
  const Json document = {{"command", "priors diff"},
                         {"before", options.file},
                         {"after", options.other_file},
                         {"scenes", DiffJson(changes)}};
  PrintResult(terminal, options.json, document, DiffText(changes));
  return kDone;
}

// Looks for a sum in `records` that may include evidence of sessions in `others`; merging would
// count that evidence twice. Returns such a sum, or null if there is none. A sum that `others`
// contains too is safe: the sessions in `others` belong to a game that started from that sum.
const PriorRecord* SumOfSessions(const Records& records, const Records& others) {
  std::set<decision::PriorsGroupKey> with_sessions;
  std::map<decltype(KeyOf(records.front())), uint64_t> sums;
  for (const PriorRecord& other : others) {
    if (IsSum(other)) {
      sums[KeyOf(other)] = other.source_sequence;
    } else {
      with_sessions.insert(decision::GroupOf(other));
    }
  }
  for (const PriorRecord& record : records) {
    if (!IsSum(record) || !with_sessions.contains(decision::GroupOf(record))) continue;
    const auto same = sums.find(KeyOf(record));
    if (same == sums.end() || same->second < record.source_sequence) return &record;
  }
  return nullptr;
}

Status CheckCountedOnce(const Records& records, const Records& others) {
  const PriorRecord* sum = SumOfSessions(records, others);
  if (sum == nullptr) sum = SumOfSessions(others, records);
  if (sum == nullptr) return {};
  return {StatusCode::kInvalidArgument,
          "in " + NameOf(decision::GroupOf(*sum)) +
              ", a sum in one file may contain sessions of the other file, which would count "
              "twice: merge exports without --sums, and add a game's own priors to a daemon with "
              "`sweepstake priors import`"};
}

int RunMerge(const PriorsFileOptions& options, Terminal& terminal) {
  auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  auto others = ReadPriorsFile(options.other_file);
  if (!others.ok()) return Fail(terminal, others.status());
  if (const Status once = CheckCountedOnce(*records, *others); !once.ok())
    return Fail(terminal, once);
  const Records united = Unite(*std::move(records), *std::move(others));
  if (const Status count = CheckRecordCount(united); !count.ok()) return Fail(terminal, count);
  if (const Status written = WriteWhole(options.out, FormatPriors(united)); !written.ok())
    return Fail(terminal, written);
  const Json document = {
      {"command", "priors merge"}, {"file", options.out}, {"records", united.size()}};
  PrintResult(terminal, options.json, document,
              options.out + ": " + text::Counted(united.size(), "record") + "\n");
  return kDone;
}

int RunArm(const PriorsFileOptions& options, Terminal& terminal) {
  EmbeddedOptions priors;
  priors.project = options.project;
  priors.scene = options.scene;
  priors.machine_class = options.machine_class;
  priors.priors_file = options.file;
  std::vector<std::string> arms;
  std::vector<uint32_t> versions;
  for (const std::string_view arm : BroadPhaseNames()) {
    arms.emplace_back(arm);
    versions.push_back((*MakeBroadPhase(arm))->version());
  }
  const auto arm = EmbeddedDecider::ArmOfPriors(priors, arms, versions);
  if (!arm.ok()) {
    // If the file exists but has no evidence of the scene, the command was used correctly and the
    // answer is "none": exit code 1.
    std::error_code error;
    const bool is_answer = arm.status().code() == StatusCode::kNotFound &&
                           std::filesystem::exists(options.file, error);
    return is_answer ? FailAnswer(terminal, arm.status()) : Fail(terminal, arm.status());
  }
  const auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const std::vector<Diagnosed> diagnosed = Diagnose(*records, options);
  const bool knows_scene = std::any_of(diagnosed.begin(), diagnosed.end(), [&](const auto& one) {
    return Counts(one) && one.key.project == options.project && one.key.scene == options.scene;
  });
  if (!knows_scene) {
    Say(terminal, options.file + " has no evidence that counts here for scene \"" + options.scene +
                      "\": " + *arm + " is chosen from the project's other scenes; " +
                      "`sweepstake priors doctor` shows how much each scene counts");
  }
  const Json document = {
      {"command", "priors arm"}, {"arm", *arm}, {"of", knows_scene ? "scene" : "project"}};
  PrintResult(terminal, options.json, document, *arm + "\n");
  return kDone;
}

void DeclareFile(CLI::App& command, PriorsFileOptions& options) {
  command.add_option("--in", options.file, "Priors file")->required();
  AddJsonFlag(command, options.json);
}

void DeclareMachineClass(CLI::App& command, PriorsFileOptions& options) {
  command.add_option("--machine-class", options.machine_class,
                     "Class of the machines that will use the file (default: this machine's)");
}

// Declares two files as positional arguments, and --json.
void DeclareTwoFiles(CLI::App& command, PriorsFileOptions& options) {
  command.add_option("FILE", options.file, "Priors file")->required();
  command.add_option("OTHER", options.other_file, "Second priors file")->required();
  AddJsonFlag(command, options.json);
}

void AddTwoFileCommands(const CommandContext& priors) {
  AddCommand<PriorsFileOptions>(
      priors, "diff", "Print the scenes and regimes in which two priors files differ",
      "  sweepstake priors diff monday.json friday.json\n"
      "  sweepstake priors diff all.json all.json --build 1.0 --other-build 1.1\n"
      "Costs are ratios to the cheapest arm's; those that differ by more than 5 % are printed.\n"
      "Exit code 1 if a file has no evidence of the build.\n",
      [](CLI::App& command, PriorsFileOptions& options) {
        DeclareTwoFiles(command, options);
        command.add_option("--build", options.build, "Use only the evidence of this build in FILE");
        command.add_option("--other-build", options.other_build,
                           "Use only the evidence of this build in OTHER");
      },
      RunDiff);
  AddCommand<PriorsFileOptions>(
      priors, "merge", "Merge two priors files into one; of each source, the later record is kept",
      "  sweepstake priors merge ours.json theirs.json --out all.json\n"
      "It refuses to merge a sum of `export --sums` with sessions that the sum may contain,\n"
      "because they would count twice.\n",
      [](CLI::App& command, PriorsFileOptions& options) {
        DeclareTwoFiles(command, options);
        command.add_option("--out", options.out, "File to write")->required();
      },
      RunMerge);
}

}  // namespace

void AddPriorsFileCommands(const CommandContext& priors) {
  AddCommand<PriorsFileOptions>(
      priors, "show",
      "Print the content of a priors file by scene, machine class, build and regime",
      "  sweepstake priors show --in priors.json\n", DeclareFile, RunShow);
  AddCommand<PriorsFileOptions>(
      priors, "doctor",
      "Print which evidence of a priors file counts here, and why the rest does not",
      "  sweepstake priors doctor --in priors.json --build 1.2\n"
      "An entry is valid (it counts as if this machine and build had measured it), near (it or\n"
      "some of its arms count less: another build, machine class or version of an arm) or\n"
      "foreign (it does not count, such as evidence in a daemon's quarantine). Exit code 1 if\n"
      "no entry counts.\n",
      [](CLI::App& command, PriorsFileOptions& options) {
        DeclareFile(command, options);
        DeclareMachineClass(command, options);
        command.add_option("--build", options.build, "Build of the game (default: unknown)");
      },
      RunDoctor);
  AddTwoFileCommands(priors);
  AddCommand<PriorsFileOptions>(
      priors, "arm",
      "Print the arm that a priors file expects to cost least, for builds that always use it",
      "  sweepstake priors arm --in priors.json --project arcade --scene arena\n"
      "The same file gives the same arm. For a scene that is not in the file, the arm is\n"
      "chosen from the project's other scenes; exit code 1 if there are none.\n",
      [](CLI::App& command, PriorsFileOptions& options) {
        DeclareFile(command, options);
        DeclareMachineClass(command, options);
        command.add_option("--project", options.project, "The game's project")->required();
        command.add_option("--scene", options.scene, "The game's scene")->required();
      },
      RunArm);
}

}  // namespace sweepstake::cli
