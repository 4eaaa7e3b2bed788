// page.css and page.js, as compiled in. Thread-safe.
#pragma once

#include <string_view>

namespace sweepstake::cli::html {

std::string_view PageStyle();
std::string_view PageScript();

}  // namespace sweepstake::cli::html
