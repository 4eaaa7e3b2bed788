// The report page without documents, built from this folder and embedded in the program. Safe from
// any thread.
#pragma once

#include <string_view>

namespace sweepstake {

// Returns the page. The word SWEEPSTAKE_DOCUMENTS in it is a placeholder for the documents. Empty
// if the program was built without the page.
std::string_view ReportPage();

// Returns a sentence that says why the page is missing and how to build it. Empty if the page is
// present.
std::string_view ReportPageProblem();

}  // namespace sweepstake
