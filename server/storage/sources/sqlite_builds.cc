#include <set>
#include <span>
#include <string>

#include "server/storage/record_limits.h"
#include "server/storage/sources/sqlite_sources.h"
#include "server/storage/sqlite_prior_reader.h"

namespace sweepstake::storage {
namespace {

priors::BuildRow RowOf(const SqliteRow& row) {
  return {.project = row.Text(0),
          .name = row.Text(1),
          .parent = row.Text(2),
          .unix_made_s = row.Unsigned(3)};
}

}  // namespace

absl::Status DescribeBuilds(PriorStatements& statements, std::span<const priors::Build> builds) {
  absl::Status status;
  std::set<std::string> projects;
  for (const priors::Build& build : builds) {
    projects.insert(build.project);
    if (status.ok()) status = statements.forget_build.Run(build.project, build.name);
    for (const std::string& parent : priors::ParentColumn(build)) {
      if (status.ok())
        status = statements.add_parent.Run(build.project, build.name, parent, build.unix_made_s);
    }
  }
  for (const std::string& project : projects) {
    uint64_t count = 0;
    if (status.ok())
      status = statements.count_builds.ForEachRow(
          [&](const SqliteRow& row) { count = row.Unsigned(0); }, project);
    if (status.ok()) status = BuildBound(project, count);
  }
  return status;
}

absl::Status ForgetBuilds(PriorStatements& statements, std::span<const priors::BuildPlace> builds) {
  absl::Status status;
  for (const priors::BuildPlace& build : builds) {
    if (status.ok()) status = statements.forget_build.Run(build.project, build.name);
  }
  return status;
}

absl::StatusOr<std::vector<priors::Build>> SqlitePriorReader::LoadBuilds(
    const std::string& project, std::span<const std::string> names) {
  std::vector<priors::Build> builds;
  for (const std::string& name : names) {
    absl::Status status = statements_.build.ForEachRow(
        [&](const SqliteRow& row) { priors::AppendRow(RowOf(row), builds); }, project, name);
    if (!status.ok()) return status;
  }
  return builds;
}

absl::StatusOr<std::vector<priors::Build>> SqlitePriorReader::ListBuilds(
    const priors::SceneFilter& filter, const priors::BuildPlace& after, uint32_t limit) {
  std::vector<priors::Build> builds;
  absl::Status status = statements_.list_builds.ForEachRow(
      [&](const SqliteRow& row) { priors::AppendRow(RowOf(row), builds); }, filter.project,
      after.project, after.name, LineList(filter.projects), limit);
  if (!status.ok()) return status;
  return builds;
}

}  // namespace sweepstake::storage
