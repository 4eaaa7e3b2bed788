// The files of the dashboard, built from this folder and embedded in the program. The functions may
// be called from any thread.
#pragma once

#include <span>
#include <string_view>

namespace sweepstake {

struct DashboardAsset {
  std::string_view path;          // as in a request: "/index.html", "/assets/main-1f2e3d4c.js"
  std::string_view content_type;  // "text/html; charset=utf-8"
  std::string_view gzip_bytes;    // one gzip member whose header has no optional fields
  std::string_view etag;          // entity tag of the content, with its quotation marks
  bool is_immutable = false;      // the path contains a hash of the content
};

// Returns the files, ordered by path; one of them is /index.html. Empty if the program was built
// without the dashboard.
std::span<const DashboardAsset> DashboardAssets();

// Returns a sentence with the reason why the files are missing and how to build them. Empty if the
// program contains them.
std::string_view DashboardProblem();

}  // namespace sweepstake
