#include "engine_client/c_api/boundary.h"

#include <array>
#include <cstdio>

namespace sweepstake::c_api {
namespace {

static_assert(SWP_OK == static_cast<int>(StatusCode::kOk));
static_assert(SWP_INVALID_ARGUMENT == static_cast<int>(StatusCode::kInvalidArgument));
static_assert(SWP_NOT_FOUND == static_cast<int>(StatusCode::kNotFound));
static_assert(SWP_DATA_LOSS == static_cast<int>(StatusCode::kDataLoss));
static_assert(SWP_UNAVAILABLE == static_cast<int>(StatusCode::kUnavailable));
static_assert(SWP_RESOURCE_EXHAUSTED == static_cast<int>(StatusCode::kResourceExhausted));
static_assert(SWP_FAILED_PRECONDITION == static_cast<int>(StatusCode::kFailedPrecondition));
static_assert(SWP_INTERNAL == static_cast<int>(StatusCode::kInternal));

}  // namespace

swp_result Fail(swp_result result, std::string_view message) noexcept {
  swp_set_last_error(message.data(), message.size());
  return result;
}

swp_result ToResult(const Status& status) noexcept {
  if (status.ok()) return SWP_OK;
  return Fail(static_cast<swp_result>(status.code()), status.message());
}

swp_result NullArgument(std::string_view name) noexcept {
  std::array<char, 128> message;
  std::snprintf(message.data(), message.size(), "%.*s must not be NULL",
                static_cast<int>(name.size()), name.data());
  return Fail(SWP_INVALID_ARGUMENT, message.data());
}

}  // namespace sweepstake::c_api
