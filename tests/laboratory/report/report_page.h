// The page that reports are filled into, built from this folder and embedded in the program. Safe
// from any thread.
#pragma once

#include <string_view>

namespace sweepstake {

// The page, in which the word SWEEPSTAKE_DOCUMENTS stands for the documents that it shows. Empty
// where the program was built without it.
std::string_view ReportPage();

// Why the page is missing and how to get it, as a sentence. Empty where it is there.
std::string_view ReportPageProblem();

}  // namespace sweepstake
