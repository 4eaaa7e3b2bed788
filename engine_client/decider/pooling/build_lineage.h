// The builds of a project and what each was made from, as whoever makes them has told: a session
// weighs what related builds taught by how near they are. Plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sweepstake::priors {

struct Build {
  std::string project;
  std::string name;                  // as its games say it
  std::vector<std::string> parents;  // builds of the project, ascending; empty: from none
  uint64_t unix_made_s = 0;          // at most kMaxUnixMadeS; 0 if unknown

  friend bool operator==(const Build&, const Build&) = default;
};

inline constexpr size_t kMaxParents = 8;
inline constexpr uint64_t kMaxBuilds = 10'000;             // of a project
inline constexpr int64_t kMaxUnixMadeS = 253'402'300'799;  // the end of the year 9999

// A place in the builds, which are ordered by project and name. By default before all.
struct BuildPlace {
  std::string project;
  std::string name;
};

// A build and one of its parents, as stores keep it; of a build from none the parent is empty.
struct BuildRow {
  std::string project;
  std::string name;
  std::string parent;
  uint64_t unix_made_s = 0;
};

// Appends the row's build or, where that is the last one already, its parent.
inline void AppendRow(BuildRow row, std::vector<Build>& builds) {
  if (builds.empty() ||
      std::tie(builds.back().project, builds.back().name) != std::tie(row.project, row.name)) {
    builds.push_back({.project = std::move(row.project),
                      .name = std::move(row.name),
                      .parents = {},
                      .unix_made_s = row.unix_made_s});
  }
  if (!row.parent.empty()) builds.back().parents.push_back(std::move(row.parent));
}

// Returns the rows of a build, one at least.
inline std::vector<std::string> ParentColumn(const Build& build) {
  return build.parents.empty() ? std::vector<std::string>{""} : build.parents;
}

}  // namespace sweepstake::priors
