#include "tests/server/simulation/tally.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace sweepstake::simulation {
namespace {

constexpr std::array kCounts = {
    std::pair{"kills", &Tally::kills},
    std::pair{"power cuts among the kills", &Tally::power_cuts},
    std::pair{"failed starts", &Tally::failed_starts},
    std::pair{"drains", &Tally::drains},
    std::pair{"commits", &Tally::commits},
    std::pair{"failed commits", &Tally::failed_commits},
    std::pair{"lost answers of the store", &Tally::lost_answers},
    std::pair{"sessions resumed", &Tally::resumed},
    std::pair{"sessions begun without stored evidence", &Tally::degraded_starts},
    std::pair{"lost acknowledgements", &Tally::lost_acknowledgements},
    std::pair{"resent messages", &Tally::resent},
    std::pair{"resent messages that were already applied", &Tally::replayed},
    std::pair{"imports", &Tally::imports},
    std::pair{"tokens revoked", &Tally::revoked_tokens},
    std::pair{"attempts to steal a session", &Tally::thefts},
    std::pair{"jumps of the wall clock", &Tally::clock_jumps},
    std::pair{"scenes watched to the end", &Tally::watched_scenes},
    std::pair{"decisions", &Tally::decisions},
    std::pair{"replayed decisions", &Tally::derived_decisions},
};

}  // namespace

Tally& Tally::operator+=(const Tally& other) {
  for (const auto& [name, count] : kCounts) this->*count += other.*count;
  return *this;
}

std::string Tally::Text() const {
  return absl::StrJoin(kCounts, ", ", [this](std::string* text, const auto& entry) {
    absl::StrAppend(text, this->*entry.second, " ", entry.first);
  });
}

std::string Tally::NeverHappened() const {
  std::string text;
  for (const auto& [name, count] : kCounts) {
    if (this->*count == 0) absl::StrAppend(&text, name, ";");
  }
  return text;
}

}  // namespace sweepstake::simulation
