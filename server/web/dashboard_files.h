// Serves the files of the dashboard: compressed for clients that accept it, and cached by browsers
// while they are unchanged. The files are part of the program, so no request reads the file system.
// Thread-safe.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "server/dashboard/dashboard_assets.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

class DashboardFiles {
 public:
  // `files` are ordered by path and must outlive this object. `problem` is shown if there are none.
  DashboardFiles(std::span<const DashboardAsset> files, std::string_view problem)
      : files_(files), problem_(problem) {}

  // Returns the file at the request's path. All paths of the dashboard's pages have the same file,
  // with two differences: its URLs begin with the base path, and the title that chats and mail show
  // for a link (Open Graph) contains the scene or session that the path names.
  Page PageFor(const Request& request) const;

 private:
  const DashboardAsset* Find(std::string_view path) const;

  std::span<const DashboardAsset> files_;
  std::string_view problem_;
};

}  // namespace sweepstake::web
