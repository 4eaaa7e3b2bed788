#include "server/web/dashboard_files.h"

#include <algorithm>
#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cstdint>

#include "absl/strings/str_cat.h"

namespace sweepstake::web {
namespace {

constexpr std::string_view kIndex = "/index.html";
// The first parts of the paths of the dashboard's pages, which its own program tells apart.
constexpr std::array<std::string_view, 6> kPages = {"scenes", "sessions", "decisions",
                                                    "priors", "health",   "login"};

bool IsPage(std::string_view path) {
  const std::string_view first = path.substr(1, path.find('/', 1) - 1);
  return path == "/" || std::find(kPages.begin(), kPages.end(), first) != kPages.end();
}

// Undoes gzip (RFC 1952): ten bytes of header, what deflate made, the checksum and the length.
// REQUIRES: it is one member without optional fields, as DashboardAsset has it.
std::string Decompress(std::string_view gzip) {
  constexpr size_t kHeaderBytes = 10;
  constexpr size_t kTrailerBytes = 8;
  size_t length = 0;
  for (size_t i = 1; i <= 4; ++i)
    length = length << 8 | static_cast<uint8_t>(gzip[gzip.size() - i]);
  std::string text(length, '\0');
  boost::beast::zlib::z_params place;
  place.next_in = gzip.data() + kHeaderBytes;
  place.avail_in = gzip.size() - kHeaderBytes - kTrailerBytes;
  place.next_out = text.data();
  place.avail_out = text.size();
  boost::system::error_code end;
  boost::beast::zlib::inflate_stream().write(place, boost::beast::zlib::Flush::finish, end);
  return text;
}

}  // namespace

const DashboardAsset* DashboardFiles::Find(std::string_view path) const {
  const auto found = std::lower_bound(
      files_.begin(), files_.end(), path,
      [](const DashboardAsset& file, std::string_view wanted) { return file.path < wanted; });
  return found != files_.end() && found->path == path ? &*found : nullptr;
}

Page DashboardFiles::PageFor(const Request& request) const {
  const bool is_page = IsPage(request.path());
  const DashboardAsset* file = Find(is_page ? kIndex : request.path());
  if (file == nullptr) {
    if (!is_page) return {404, "There is no such page.\n"};
    return {.body = absl::StrCat(std::string(problem_), "\n")};
  }
  Page page;
  page.content_type = std::string(file->content_type);
  page.headers = {
      {"ETag", std::string(file->etag)},
      {"Vary", "Accept-Encoding"},
      {"Cache-Control", file->is_immutable ? "public, max-age=31536000, immutable" : "no-cache"}};
  if (request.Header("If-None-Match").find(file->etag) != std::string_view::npos) {
    page.status = 304;
  } else if (request.Header("Accept-Encoding").find("gzip") != std::string_view::npos) {
    page.headers.emplace_back("Content-Encoding", "gzip");
    page.body = std::string(file->gzip_bytes);
  } else {
    page.body = Decompress(file->gzip_bytes);
  }
  return page;
}

}  // namespace sweepstake::web
