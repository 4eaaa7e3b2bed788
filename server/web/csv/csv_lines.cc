#include "server/web/csv/csv_lines.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "engine_client/text/csv.h"

namespace sweepstake::web {
namespace {

// Returns whether a spreadsheet may read the text as a formula: it begins, after blanks, with =, +,
// - or @, also as the full-width characters U+FF1D, U+FF0B, U+FF0D and U+FF20, or with a tab, a
// line break or a semicolon, which separates cells in some countries.
bool LooksLikeFormula(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.starts_with("\xc2\xa0")))
    text.remove_prefix(text.front() == ' ' ? 1 : 2);
  if (text.empty()) return false;
  if (std::string_view(";=+-@\t\r\n").find(text.front()) != std::string_view::npos) return true;
  for (const std::string_view wide :
       {"\xef\xbc\x9d", "\xef\xbc\x8b", "\xef\xbc\x8d", "\xef\xbc\xa0"})
    if (text.starts_with(wide)) return true;
  return false;
}

}  // namespace

void CsvLines::Text(std::string_view text) {
  Cell(LooksLikeFormula(text) ? absl::StrCat("'", std::string(text)) : std::string(text));
}

void CsvLines::Time(int64_t unix_ms) {
  if (unix_ms == 0) return Nothing();
  Cell(
      absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", absl::FromUnixMillis(unix_ms), absl::UTCTimeZone()));
}

void CsvLines::Nothing(int count) {
  for (int i = 0; i < count; ++i) Cell({});
}

void CsvLines::End() {
  lines_ += "\r\n";
  is_first_ = true;
}

std::string CsvLines::Take() { return std::exchange(lines_, {}); }

void CsvLines::Cell(std::string_view cell) {
  if (!std::exchange(is_first_, false)) lines_ += ',';
  text::AppendCsv(lines_, cell);
}

}  // namespace sweepstake::web
