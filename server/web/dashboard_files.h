// The dashboard's files as answers: compressed for who takes that, and kept by browsers as long as
// they are the same. No path leads to the file system. Safe from any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "server/dashboard/dashboard_assets.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

class DashboardFiles {
 public:
  // The files are borrowed, and ordered by path. `problem` says why there are none.
  DashboardFiles(std::span<const DashboardAsset> files, std::string_view problem)
      : files_(files), problem_(problem) {}

  // Returns the file at the request's path. The paths of the dashboard's own pages all have the
  // same file but for the title that chats and mail show of a link (Open Graph): what the path of
  // a scene or a session names is in it.
  Page PageFor(const Request& request) const;

 private:
  const DashboardAsset* Find(std::string_view path) const;

  std::span<const DashboardAsset> files_;
  std::string_view problem_;
};

}  // namespace sweepstake::web
