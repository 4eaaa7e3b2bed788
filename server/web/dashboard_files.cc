#include "server/web/dashboard_files.h"

#include <algorithm>
#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "engine_client/text/names.h"
#include "server/web/gzip.h"
#include "server/web/query.h"

namespace sweepstake::web {
namespace {

constexpr std::string_view kIndex = "/index.html";
// The first parts of the paths of the dashboard's pages. The dashboard's program in the browser
// chooses the page.
constexpr std::array<std::string_view, 7> kPages = {"scenes", "sessions",  "decisions", "priors",
                                                    "health", "recording", "login"};

bool IsPage(std::string_view path) {
  const std::string_view first = path.substr(1, path.find('/', 1) - 1);
  return path == "/" || path == kIndex ||
         std::find(kPages.begin(), kPages.end(), first) != kPages.end();
}

// Decompresses gzip (RFC 1952): a header of ten bytes, the deflated data, checksum and length.
// REQUIRES: one member without optional fields, as in DashboardAsset.
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

// Returns whether a name may reorder or hide the text beside it: it contains one of U+061C, U+200B
// to U+200F, U+2028 to U+202E, U+2060 to U+206F, U+FEFF.
bool IsDeceptive(std::string_view name) {
  for (; !name.empty(); name.remove_prefix(1)) {
    if (name.starts_with("\xd8\x9c") || name.starts_with("\xef\xbb\xbf")) return true;
    const auto last = static_cast<uint8_t>(name.size() > 2 ? name[2] : '\0');
    if (name.starts_with("\xe2\x80") &&
        ((last >= 0x8b && last <= 0x8f) || (last >= 0xa8 && last <= 0xae)))
      return true;
    if (name.starts_with("\xe2\x81") && last >= 0xa0 && last <= 0xaf) return true;
  }
  return false;
}

// Returns the names in the path of a scene or a session, separated as in the title of the page.
// Returns an empty text if there are none, or if a name is not safe to show. Nothing is looked up,
// so that a link reveals only its own text to readers who may not see the page.
std::string NamesIn(std::string_view path) {
  const std::vector<std::string> parts =
      absl::StrSplit(absl::string_view(path.data(), path.size()), '/');
  const bool is_named =
      (parts.size() == 4 && parts[1] == "scenes") || (parts.size() == 3 && parts[1] == "sessions");
  if (!is_named) return "";
  std::vector<std::string> names;
  for (size_t i = 2; i < parts.size(); ++i) {
    const auto part = PercentDecoded(parts[i]);
    // The dashboard puts ~ before a name such as "..", which browsers would read as a folder.
    const std::string name =
        part.ok() && part->starts_with('~') ? part->substr(1) : part.value_or("");
    if (!text::IsName(name) || IsDeceptive(name)) return "";
    names.push_back(name);
  }
  return absl::StrJoin(names, " / ");
}

// Returns the page with `names` before the title that chats and mail show for a link to it, and
// with the base path in its URLs, which begin with "./".
std::string CompletePage(std::string html, const std::string& base_path, const std::string& names) {
  absl::StrReplaceAll({{"=\"./", absl::StrCat("=\"", base_path, "/")}}, &html);
  constexpr std::string_view kTitle = "<meta property=\"og:title\" content=\"";
  const size_t place = html.find(kTitle);
  if (place == std::string::npos || names.empty()) return html;
  const std::string escaped = absl::StrReplaceAll(
      names, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
  return html.insert(place + kTitle.size(), absl::StrCat(escaped, " \u00b7 "));
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
    if (!is_page) return {404, "This page does not exist.\n"};
    return {.body = absl::StrCat(std::string(problem_), "\n")};
  }
  Page page;
  page.content_type = std::string(file->content_type);
  std::string etag(file->etag);
  if (is_page) etag.insert(etag.size() - 1, request.base_path);
  page.headers = {
      {"ETag", etag},
      {"Vary", "Accept-Encoding"},
      {"Cache-Control", file->is_immutable ? "public, max-age=31536000, immutable" : "no-cache"}};
  if (request.Header("If-None-Match").find(etag) != std::string_view::npos) {
    page.status = 304;
  } else if (is_page) {
    page.body =
        CompletePage(Decompress(file->gzip_bytes), request.base_path, NamesIn(request.path()));
  } else if (AcceptsGzip(request)) {
    page.headers.emplace_back("Content-Encoding", "gzip");
    page.body = std::string(file->gzip_bytes);
  } else {
    page.body = Decompress(file->gzip_bytes);
  }
  return page;
}

}  // namespace sweepstake::web
