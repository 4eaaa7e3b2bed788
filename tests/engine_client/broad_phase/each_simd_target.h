// Runs a test with each instruction set that this machine has kernels for.
#pragma once

#include <gtest/gtest.h>

#include <string_view>

#include "sweepstake/simd.h"

namespace sweepstake::test_support {

// Restores the former instruction set at the end, also after a fatal failure.
template <class Test>
void OnEachSimdTarget(const Test& test) {
  const std::string_view before = SimdTarget();
  for (const std::string_view target : SimdTargets()) {
    SCOPED_TRACE(target);
    EXPECT_TRUE(UseSimdTarget(target).ok());
    EXPECT_EQ(SimdTarget(), target);
    test();
    if (testing::Test::HasFatalFailure()) break;
  }
  EXPECT_TRUE(UseSimdTarget(before).ok());
}

}  // namespace sweepstake::test_support
