#include "server/storage/postgres/postgres_builds.h"

#include <set>

#include "server/storage/record_limits.h"

namespace sweepstake::storage {
namespace {

// Of two who describe a build at the same time the later one counts, and both count builds; held
// until the transaction's end.
constexpr const char* kLockBuilds = "SELECT pg_advisory_xact_lock(7743300016)";
constexpr const char* kForgetBuild = "DELETE FROM build_parent WHERE project = $1 AND build = $2";
constexpr const char* kAddParent = R"sql(
    INSERT INTO build_parent (project, build, parent, unix_made_s)
    VALUES ($1, $2, $3, $4::bigint))sql";
constexpr const char* kCountBuilds =
    "SELECT count(DISTINCT build) FROM build_parent WHERE project = $1";
constexpr const char* kLoadBuilds = R"sql(
    SELECT project, build, parent, unix_made_s FROM build_parent
    WHERE project = $1 AND build = ANY ($2::text[])
    ORDER BY build, parent)sql";
constexpr const char* kListBuilds = R"sql(
    SELECT project, build, parent, unix_made_s FROM build_parent
    WHERE (project, build) IN (SELECT DISTINCT project, build FROM build_parent
                               WHERE (project, build) > ($2, $3) AND ($1 = '' OR project = $1)
                                 AND ($4::text[] = '{}' OR project = ANY ($4::text[]))
                               ORDER BY 1, 2 LIMIT $5::bigint)
    ORDER BY project, build, parent)sql";

priors::BuildRow RowOf(const PostgresRow& row) {
  return {.project = row.Text(0),
          .name = row.Text(1),
          .parent = row.Text(2),
          .unix_made_s = row.Unsigned(3)};
}

template <typename... Args>
absl::StatusOr<std::vector<priors::Build>> Load(PostgresConnection& connection, const char* sql,
                                                const Args&... args) {
  if (absl::Status status = connection.Connect(); !status.ok()) return status;
  std::vector<priors::Build> builds;
  absl::Status status = connection.ForEachRow(
      sql, [&](const PostgresRow& row) { priors::AppendRow(RowOf(row), builds); }, args...);
  if (!status.ok()) return status;
  return builds;
}

}  // namespace

absl::Status DescribeBuilds(PostgresConnection& connection, std::span<const priors::Build> builds) {
  absl::Status status = connection.Run(kLockBuilds);
  std::set<std::string> projects;
  for (const priors::Build& build : builds) {
    projects.insert(build.project);
    if (status.ok()) status = connection.Run(kForgetBuild, build.project, build.name);
    for (const std::string& parent : priors::ParentColumn(build)) {
      if (status.ok())
        status = connection.Run(kAddParent, build.project, build.name, parent, build.unix_made_s);
    }
  }
  for (const std::string& project : projects) {
    uint64_t count = 0;
    if (status.ok())
      status = connection.ForEachRow(
          kCountBuilds, [&](const PostgresRow& row) { count = row.Unsigned(0); }, project);
    if (status.ok()) status = BuildBound(project, count);
  }
  return status;
}

absl::Status ForgetBuilds(PostgresConnection& connection,
                          std::span<const priors::BuildPlace> builds) {
  absl::Status status = connection.Run(kLockBuilds);
  for (const priors::BuildPlace& build : builds) {
    if (status.ok()) status = connection.Run(kForgetBuild, build.project, build.name);
  }
  return status;
}

absl::StatusOr<std::vector<priors::Build>> LoadBuilds(PostgresConnection& connection,
                                                      const std::string& project,
                                                      std::span<const std::string> names) {
  PostgresArray wanted;
  for (const std::string& name : names) wanted.Add(name);
  return Load(connection, kLoadBuilds, project, wanted);
}

absl::StatusOr<std::vector<priors::Build>> ListBuilds(PostgresConnection& connection,
                                                      const priors::SceneFilter& filter,
                                                      const priors::BuildPlace& after,
                                                      uint32_t limit) {
  PostgresArray projects;
  for (const std::string& project : filter.projects) projects.Add(project);
  return Load(connection, kListBuilds, filter.project, after.project, after.name, projects, limit);
}

}  // namespace sweepstake::storage
