// `sweepstake priors describe|builds`: says what a build of a game was made from, which the daemon
// weighs its evidence by, and shows what was said.
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/pooling/build_lineage.h"
#include "sweepstake/v1/priors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct BuildsOptions {
  DaemonOptions daemon;
  std::string project;
  std::string build;
  std::vector<std::string> parents;
  int64_t unix_made_s = 0;
  bool forget = false;
  bool json = false;
};

// An empty `project` selects all. Error: kUnavailable (no daemon answered).
Result<std::vector<v1::Build>> ListBuilds(const DaemonOptions& daemon, const std::string& project) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, kTransferPatience);
  v1::ListBuildsRequest request;
  request.set_project(project);
  const auto reader = stub->ListBuilds(&context, request);
  std::vector<v1::Build> builds;
  for (v1::ListBuildsResponse part; reader->Read(&part);)
    builds.insert(builds.end(), part.builds().begin(), part.builds().end());
  const Status status = ToStatus(reader->Finish(), daemon);
  if (!status.ok()) return status;
  return builds;
}

Status DescribeBuild(const DaemonOptions& daemon, const v1::Build& build, bool forget) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PriorsService::NewStub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, kTransferPatience);
  v1::DescribeBuildsRequest request;
  *request.add_builds() = build;
  request.set_forget(forget);
  v1::DescribeBuildsResponse response;
  return ToStatus(stub->DescribeBuilds(&context, request, &response), daemon);
}

Json BuildJson(const v1::Build& build) {
  return {{"project", build.project()},
          {"build", build.name()},
          {"parents", std::vector<std::string>(build.parents().begin(), build.parents().end())},
          {"unix_made_s", build.unix_made_s()}};
}

std::string ParentsText(const v1::Build& build) {
  std::string text;
  for (const std::string& parent : build.parents()) text += (text.empty() ? "" : ", ") + parent;
  return text;
}

// Returns whether `name` is among what the builds were made from, however far back.
bool IsAncestor(const std::string& name, std::vector<std::string> of,
                const std::vector<v1::Build>& builds) {
  std::map<std::string, const v1::Build*> known;
  for (const v1::Build& build : builds) known[build.name()] = &build;
  std::set<std::string> seen;
  while (!of.empty()) {
    const std::string next = std::move(of.back());
    of.pop_back();
    if (next == name) return true;
    const auto found = known.find(next);
    if (found == known.end() || !seen.insert(next).second) continue;
    of.insert(of.end(), found->second->parents().begin(), found->second->parents().end());
  }
  return false;
}

Status CheckNoCycle(const BuildsOptions& options) {
  if (options.parents.empty()) return {};
  const auto builds = ListBuilds(options.daemon, options.project);
  if (!builds.ok()) return builds.status();
  for (const std::string& parent : options.parents) {
    if (parent == options.build)
      return {StatusCode::kInvalidArgument, "a build is not its own parent"};
    if (IsAncestor(options.build, {parent}, *builds))
      return {StatusCode::kFailedPrecondition,
              "build " + parent + " was made from " + options.build +
                  " itself, as `sweepstake priors builds` shows: one of both is the wrong way "
                  "round, and --forget takes back what was said"};
  }
  return {};
}

int RunDescribe(const BuildsOptions& options, Terminal& terminal) {
  if (const Status status = CheckNoCycle(options); !status.ok())
    return FailAnswer(terminal, status);
  v1::Build build;
  build.set_project(options.project);
  build.set_name(options.build);
  build.mutable_parents()->Assign(options.parents.begin(), options.parents.end());
  build.set_unix_made_s(options.unix_made_s);
  const Status status = DescribeBuild(options.daemon, build, options.forget);
  if (!status.ok()) return FailAnswer(terminal, status);
  Json document = {{"command", "priors describe"}, {"forgotten", options.forget}};
  document.update(BuildJson(build));
  const std::string parents = ParentsText(build);
  const std::string said = options.forget    ? " is forgotten"
                           : parents.empty() ? " was made from none"
                                             : " was made from " + parents;
  PrintResult(terminal, options.json, document,
              "build " + build.name() + " of " + build.project() + said + "\n");
  return kDone;
}

int RunBuilds(const BuildsOptions& options, Terminal& terminal) {
  const auto builds = ListBuilds(options.daemon, options.project);
  if (!builds.ok()) return FailAnswer(terminal, builds.status());
  Json rows = Json::array();
  TextTable table({"project", "build", "made from", "made (UTC)"});
  for (const v1::Build& build : *builds) {
    rows.push_back(BuildJson(build));
    table.AddRow({build.project(), build.name(), ParentsText(build),
                  build.unix_made_s() > 0 ? UtcText(build.unix_made_s() * 1000) : ""});
  }
  const Json document = {{"command", "priors builds"}, {"builds", rows}};
  PrintResult(terminal, options.json, document,
              builds->empty() ? "Nothing was said of any build: `sweepstake priors describe` does\n"
                              : table.Text());
  return kDone;
}

void Declare(CLI::App& command, BuildsOptions& options) {
  AddDaemonOptions(command, options.daemon);
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddPriorsBuildsCommands(CLI::App& priors, Terminal& terminal, int& exit_code) {
  AddCommand<BuildsOptions>(
      priors, "describe", "Say what a build was made from, so that related builds count for it",
      "  sweepstake priors describe --daemon 127.0.0.1:7433 --project arcade --build 1.3 "
      "--parent 1.2\n"
      "  sweepstake priors describe --daemon 127.0.0.1:7433 --project arcade --build 1.4 \\\n"
      "    --parent 1.3 --parent 1.2-hotfix --made $(git show -s --format=%ct)\n"
      "  sweepstake priors describe --daemon 127.0.0.1:7433 --project arcade --build 1.O --forget\n"
      "What the same build taught counts with weight 0.5, a parent or a child of it with 0.4, and\n"
      "with each step between two builds with 0.8 of that; what is of another branch with 0.125.\n"
      "For a build that none is known to be related to, all others count with 0.25.\n",
      exit_code,
      [](CLI::App& command, BuildsOptions& options) {
        Declare(command, options);
        command.add_option("--project", options.project, "The game's project")->required();
        command.add_option("--build", options.build, "The build, as its games say it")->required();
        command.add_option("--parent", options.parents, "What it was made from, up to 8 builds");
        CLI::Option* const made =
            command
                .add_option("--made", options.unix_made_s, "When it was made (default: unknown)")
                ->check(CLI::Range(int64_t{0}, priors::kMaxUnixMadeS))
                ->type_name("UNIX_S");
        command.add_flag("--forget", options.forget, "Forget what was said of it")
            ->excludes("--parent")
            ->excludes(made);
      },
      [&terminal](const BuildsOptions& options) { return RunDescribe(options, terminal); });
  AddCommand<BuildsOptions>(
      priors, "builds", "Show what was said of builds",
      "  sweepstake priors builds --daemon 127.0.0.1:7433 --project arcade\n", exit_code,
      [](CLI::App& command, BuildsOptions& options) {
        Declare(command, options);
        command.add_option("--project", options.project, "Only this project");
      },
      [&terminal](const BuildsOptions& options) { return RunBuilds(options, terminal); });
}

}  // namespace sweepstake::cli
