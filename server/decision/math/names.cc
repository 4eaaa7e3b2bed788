#include "server/decision/math/names.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace sweepstake::math {
namespace {

constexpr size_t kLineMax = 200;

// Returns the Levenshtein distance. It fills the table of distances between all prefixes row by
// row.
size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j < row.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replaced}));
    }
  }
  return row.back();
}

}  // namespace

std::string PrintableLine(std::string_view text) {
  std::string line(text.substr(0, kLineMax));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return line;
}

std::string_view NearestName(std::string_view name, std::span<const std::string_view> valid) {
  const auto nearest =
      std::min_element(valid.begin(), valid.end(), [name](std::string_view a, std::string_view b) {
        return EditDistance(name, a) < EditDistance(name, b);
      });
  return nearest == valid.end() ? std::string_view() : *nearest;
}

std::string UnknownName(std::string_view kind, std::string_view name,
                        std::span<const std::string_view> valid) {
  const std::string shown = PrintableLine(name);
  const std::string_view nearest = NearestName(shown, valid);
  std::string message = "unknown ";
  message.append(kind).append(" '").append(shown).append("', must be one of ").append(nearest);
  for (const std::string_view each : valid) {
    if (each != nearest) message.append(", ").append(each);
  }
  return message;
}

}  // namespace sweepstake::math
