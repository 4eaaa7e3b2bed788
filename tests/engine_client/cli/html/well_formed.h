// Whether HTML that our own code wrote is in order. Stricter than HTML itself is: every element is
// closed, attributes are quoted, each id occurs once.
#pragma once

#include <string>
#include <string_view>

namespace sweepstake::test_support {

// Says what is wrong first, with the text around it; empty when nothing is.
std::string FirstFlaw(std::string_view html);

}  // namespace sweepstake::test_support
