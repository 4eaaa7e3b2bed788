// The registry of policies: names (options.h) and what they stand for (policy.h).
#include <array>
#include <cassert>
#include <memory>
#include <string_view>

#include "server/decision/options.h"
#include "server/decision/policy.h"
#include "server/decision/thompson_policy.h"

namespace sweepstake::decision {
namespace {

constexpr std::array<std::string_view, 1> kPolicyNames = {"paper"};

}  // namespace

std::span<const std::string_view> PolicyNames() { return kPolicyNames; }

std::unique_ptr<Policy> MakePolicy(std::string_view name) {
  if (name == "paper") return std::make_unique<ThompsonPolicy>();
  assert(false && "Validate(options) lets only known policies through");
  return nullptr;
}

}  // namespace sweepstake::decision
