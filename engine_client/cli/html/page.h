// The shell of a page that is one file: style and script inside, a table of contents, light and
// dark theme by the system's setting or a switch, nothing loaded from anywhere (its content
// security policy forbids it). Tables, pictures, the switch of the theme and the legends work
// without the script. Pure functions, safe from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct PageSection {
  std::string id;  // one on the page
  std::string heading;
  Markup body;
};

struct Page {
  std::string title;
  Markup lead;  // below the title
  std::vector<PageSection> sections;
};

// The whole file.
std::string WritePage(const Page& page);

// `json` in the page for programs, under `id`: an object whose "rows" is an array of flat objects.
// Buttons copy it as it is, or its rows as CSV; they need the script, and are not shown without it.
Markup EmbedRows(const std::string& id, const std::string& json);

}  // namespace sweepstake::cli::html
